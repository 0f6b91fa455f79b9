// Whether a server's answer can be where the robot is: checks that have nothing
// to do with how the server found it.
#ifndef NAV_AGENT_BEHAVIOR_FIX_GATE_H_
#define NAV_AGENT_BEHAVIOR_FIX_GATE_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "nav_agent/core/level_pose.h"
#include "nav_agent/core/relocalization.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/localization/robot_tracker.h"
#include "nav_agent/traversability/navigation_map.h"

namespace treeline::behavior {

struct FixGateOptions {
  // The server's own probability: below the first it is refused, below the
  // second, or below the scene's own threshold, it is weak.
  double least_confidence = 0.3;
  double sure_confidence = 0.9;
  // The camera's tilt and what the inertial sensor says of it (rad).
  double most_tilt_rad = 0.07;
  // The base stands on ground within this of where it is, up or down (m), and
  // not nearer to an obstacle than this (m).
  double most_height_m = 0.25;
  double least_clearance_m = 0.15;
  // Of the newest scan at the fix: least share that the map explains and most
  // that passes through it, to be taken at all; and to be sure.
  double least_explained = 0.5;
  double most_contradicted = 0.25;
  double sure_explained = 0.75;
  double sure_contradicted = 0.08;
  // Fewer judged beams say nothing: the fix is weak.
  int least_judged = 25;
  // The fix may be this much off: places around it are tried for the best fit
  // (m, rad; and how finely).
  double search_m = 0.15;
  double search_rad = 0.06;
  // Of two fixes: how far they may differ from what the wheels say between them
  // (m, rad); more if the server says that they are not well known.
  double pair_m = 0.3;
  double pair_rad = 0.12;

  absl::Status Validate() const;
};

enum class FixVerdict : uint8_t {
  kSure = 0,  // may be taken
  kWeak = 1,  // a second view must agree
  kNotLocalized = 2,
  kBroken = 3,  // numbers that are none
  kLowConfidence = 4,
  kAgainstGravity = 5,
  kNotOnGround = 6,  // in a wall, in the air, outside of the map
  kAgainstScan = 7
};
const char* FixVerdictName(FixVerdict verdict);
constexpr bool IsRefused(FixVerdict verdict) {
  return verdict != FixVerdict::kSure && verdict != FixVerdict::kWeak;
}

// A fix and what the gate has to say about it.
struct GatedFix {
  FixVerdict verdict = FixVerdict::kNotLocalized;
  // "explained 0.41 of 87 beams": for people.
  std::string why;
  // Meaningful unless refused; of the moment of the frame.
  core::LevelPose pose;
  localization::PoseCovariance2 covariance{};
  double confidence = 0;
  // The server is: sure_confidence and the scene's threshold are reached.
  bool is_server_sure = false;
  // ln(p / (1 - p)) of the confidence; of views that agree, their sum.
  double log_odds = 0;
  std::optional<localization::RobotTracker::ScanFit> fit;
  // The wheels' of that moment.
  localization::TrackedMotion motion;
};

// Stateless; thread-safe as the tracker is.
class FixGate {
 public:
  FixGate(std::shared_ptr<const traversability::NavigationMap> map,
          const core::RobotModel& robot, const FixGateOptions& options)
      : map_(std::move(map)), robot_(robot), options_(options) {}

  // `motion` is the wheels' of the frame's moment. The tracker's newest scan
  // must be of about the same place: the pose is carried on by the wheels.
  GatedFix Check(const core::RelocalizationAnswer& answer,
                 const localization::TrackedMotion& motion,
                 const localization::RobotTracker& tracker) const;

  // Whether two fixes are related as the wheels' motion between them says.
  bool Agree(const GatedFix& first, const GatedFix& second) const;

  const FixGateOptions& options() const { return options_; }

 private:
  // On ground with room; then against the scan; then against the old place.
  GatedFix CheckPlace(const geometry::Rigid3& map_from_base,
                      const core::RelocalizationAnswer& answer,
                      const localization::RobotTracker& tracker,
                      GatedFix fix) const;
  GatedFix CheckScan(const localization::RobotTracker& tracker,
                     GatedFix fix) const;
  void CompareWithBefore(const localization::RobotTracker& tracker,
                         const core::LevelPose& fitted, double score,
                         GatedFix& fix) const;

  std::shared_ptr<const traversability::NavigationMap> map_;
  core::RobotModel robot_;
  FixGateOptions options_;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_FIX_GATE_H_
