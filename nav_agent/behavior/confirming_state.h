// A fix was taken: whether it holds while the robot turns.
#ifndef NAV_AGENT_BEHAVIOR_CONFIRMING_STATE_H_
#define NAV_AGENT_BEHAVIOR_CONFIRMING_STATE_H_

#include <cstdint>

#include "nav_agent/behavior/fix_gate.h"
#include "nav_agent/behavior/relocalization_tools.h"

namespace treeline::behavior {

class ConfirmingState {
 public:
  // The tracker has just been told the fix. seen_twice: two views agreed, and
  // are sure together. Begins the trial of the place: counts nothing yet.
  ConfirmingState(const GatedFix& seed, bool seen_twice,
                  RelocalizationTools& tools, base::MonotonicTime now);

  enum class Outcome : uint8_t {
    kOpen,
    kFound,
    kSecondView,  // a second view must say so
    kRefuted
  };
  struct Result {
    Outcome outcome = Outcome::kOpen;
    // For people, unless it is open.
    const char* why = "";
    core::VelocityCommand wanted;
  };
  Result Step(const RelocalizationInput& input, RelocalizationTools& tools);

  const GatedFix& seed() const { return seed_; }

 private:
  // What the newest scan says, here and elsewhere.
  static void TakeScan(const localization::TrackedPose& pose,
                       RelocalizationTools& tools);
  // Why it cannot be there; null: nothing against it.
  const char* Against(const localization::TrackedMotion& motion,
                      const localization::TrackedPose& pose,
                      const RelocalizationTools& tools,
                      base::MonotonicTime now) const;

  GatedFix seed_;
  bool seen_twice_;
  base::MonotonicTime since_;
  double turned_rad_ = 0;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_CONFIRMING_STATE_H_
