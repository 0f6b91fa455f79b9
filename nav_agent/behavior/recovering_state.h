// The robot tries to get out of trouble: one maneuver after another.
#ifndef NAV_AGENT_BEHAVIOR_RECOVERING_STATE_H_
#define NAV_AGENT_BEHAVIOR_RECOVERING_STATE_H_

#include <cstdint>
#include <optional>
#include <utility>

#include "nav_agent/behavior/goal_course.h"
#include "nav_agent/behavior/goal_tools.h"

namespace treeline::behavior {

class RecoveringState {
 public:
  explicit RecoveringState(GoalTrouble trouble)
      : trouble_(std::move(trouble)) {}

  // Begins the next maneuver. False: no more of them.
  bool BeginNext(GoalTools& tools, base::MonotonicTime now);

  enum class Outcome : uint8_t {
    kRuns,
    kDone,        // a path may be there now
    kNotPossible  // the next one is to be begun
  };
  struct Result {
    Outcome outcome = Outcome::kRuns;
    // While it runs: has been through the controller's guard.
    core::VelocityCommand command;
  };
  // After a BeginNext.
  Result Step(const control::ControlPose& pose, GoalTools& tools,
              base::MonotonicTime now);

  // Something that stood in the way is gone: no need to wait for it.
  void NoteWayIsFree() { way_is_free_ = true; }
  const GoalTrouble& trouble() const { return trouble_; }

 private:
  GoalTrouble trouble_;
  std::optional<RecoveryBehavior> maneuver_;
  base::MonotonicTime maneuver_since_;
  // Since the maneuver began.
  bool way_is_free_ = false;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_RECOVERING_STATE_H_
