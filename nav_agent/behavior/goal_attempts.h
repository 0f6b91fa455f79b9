// How often a robot tries to get on before its goal fails.
#ifndef NAV_AGENT_BEHAVIOR_GOAL_ATTEMPTS_H_
#define NAV_AGENT_BEHAVIOR_GOAL_ATTEMPTS_H_

#include <optional>

#include "nav_agent/behavior/maneuver.h"

namespace treeline::behavior {

// First other ways, then recoveries; all of them again once it has got on. Not
// thread-safe.
class GoalAttempts {
 public:
  explicit GoalAttempts(const NavigatorLimits& limits)
      : max_replans_(limits.max_replans), recoveries_(limits) {}

  // False: other ways do not help.
  bool TakeReplan() { return ++replans_ <= max_replans_; }
  RecoverySequence& recoveries() { return recoveries_; }
  void Refill() {
    replans_ = 0;
    recoveries_.Refill();
  }

 private:
  int max_replans_;
  int replans_ = 0;
  RecoverySequence recoveries_;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_GOAL_ATTEMPTS_H_
