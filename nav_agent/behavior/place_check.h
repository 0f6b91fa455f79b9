// While the robot drives and knows its place: now and then the server is asked
// whether it sees the robot there, too; more often in trouble on the way.
#ifndef NAV_AGENT_BEHAVIOR_PLACE_CHECK_H_
#define NAV_AGENT_BEHAVIOR_PLACE_CHECK_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "nav_agent/behavior/fix_checker.h"
#include "nav_agent/behavior/relocalization_tools.h"
#include "nav_agent/behavior/server_question.h"

namespace treeline::behavior {

// Asks by itself while it is stepped. Not thread-safe.
class PlaceCheck {
 public:
  // interval_s 0: never.
  explicit PlaceCheck(double interval_s) : interval_s_(interval_s) {}

  // A step of a robot that knows its place: takes the answer if a question is
  // open, or asks if it is time to. A drift is corrected, and told. True: the
  // robot is to look for its place anew.
  bool Step(const RelocalizationInput& input,
            const std::shared_ptr<const core::RgbdFrame>& frame,
            const FixChecker& checker, ServerQuestion& question,
            RelocalizationTools& tools);

  // The time has come; before the first NoteDone or Step it has not.
  bool IsDue(base::MonotonicTime now) const;
  // The place was seen, or looked for, for another reason.
  void NoteDone(base::MonotonicTime now) { last_ = now; }
  // A person said where the robot is: that is checked soon.
  void Soon(base::MonotonicTime now);

 private:
  bool IsTime(const RelocalizationInput& input,
              const std::optional<localization::TrackedPose>& pose,
              const core::RgbdFrame* frame);
  static bool IsElsewhere(const core::RelocalizationAnswer& answer,
                          const localization::TrackedMotion& asked_motion,
                          base::MonotonicTime now, const FixChecker& checker,
                          RelocalizationTools& tools);

  double interval_s_;
  std::optional<base::MonotonicTime> last_;
  // As of the last step.
  bool is_in_trouble_ = false;
};

enum class CheckVerdict : uint8_t {
  kStays,      // they agree, or scans do not speak for the server
  kCorrected,  // a drift, and scans fit better where the server sees the robot
  kElsewhere   // one of them is wrong
};

struct CheckFinding {
  CheckVerdict verdict = CheckVerdict::kStays;
  // Where the server sees the robot now.
  core::LevelPose seen;
  // For people.
  std::string text;
};

// What a sure fix says of where the robot thinks it is, `pose` with the wheels
// of the same moment. fit_at_pose: of the newest scan there; nullopt counts as
// a score of 0. Two places look the same if their scores differ by less than
// alias_margin.
CheckFinding CompareWithFix(
    const GatedFix& fix, const localization::TrackedPose& pose,
    const localization::TrackedMotion& motion,
    const std::optional<localization::ScanFit>& fit_at_pose,
    double alias_margin);

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_PLACE_CHECK_H_
