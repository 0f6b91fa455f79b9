// What a robot does that does not get on: one thing after another, each with
// an end.
#ifndef NAV_AGENT_BEHAVIOR_MANEUVER_H_
#define NAV_AGENT_BEHAVIOR_MANEUVER_H_

#include <cstdint>
#include <optional>
#include <string>

#include "nav_agent/behavior/navigator.h"

namespace treeline::behavior {

enum class RecoveryBehaviorKind : uint8_t {
  kClearCostmap,  // forgets what was seen; the next scans tell anew
  kBackUp,        // as far as there is room, where nobody is about
  kLookAround,    // a full turn, if there is room
  kWait,          // people go away
  kReroute        // what is ahead counts as blocked
};
// "clear costmap" and so on.
const char* RecoveryBehaviorName(RecoveryBehaviorKind kind);

enum class RecoveryBehaviorOutcome : uint8_t {
  kRunning,
  kDone,
  kNotPossible,  // there is no room, or somebody about
  kTimedOut      // it took too long; something held the robot
};
const char* RecoveryBehaviorOutcomeName(RecoveryBehaviorOutcome outcome);

struct RecoverySequenceStep {
  RecoveryBehaviorKind kind = RecoveryBehaviorKind::kWait;
  // Of kWait.
  double wait_s = 0;
  // Little else is left to try: it backs up where people are about, too.
  bool is_bold = false;
};

// One, from its beginning to its end. Not thread-safe.
class RecoveryBehavior {
 public:
  RecoveryBehavior(const RecoverySequenceStep& rung,
                   const NavigatorLimits& limits, base::MonotonicTime now);

  struct Result {
    RecoveryBehaviorOutcome outcome = RecoveryBehaviorOutcome::kRunning;
    core::VelocityCommand command;
  };
  // The command has been through the controller's guard.
  Result Step(const control::ControlPose& pose, base::MonotonicTime now,
              control::LocalController& controller);
  RecoveryBehaviorKind kind() const { return rung_.kind; }

 private:
  Result BackUp(const control::ControlPose& pose, base::MonotonicTime now,
                control::LocalController& controller);
  Result LookAround(const control::ControlPose& pose, double elapsed_s,
                    control::LocalController& controller);

  RecoverySequenceStep rung_;
  NavigatorLimits limits_;
  base::MonotonicTime begun_;
  std::optional<geometry::Rigid2> start_;
  double last_yaw_rad_ = 0;
  double turned_rad_ = 0;
  double way_m_ = 0;
};

// What a robot is in trouble with.
enum class Trouble : uint8_t {
  kNoWay,     // what was seen leaves no way
  kStuck,     // it drives and does not get on
  kEnclosed,  // no free ground where it stands
  kOccupied   // something stands on its goal, and there is no room beside it
};

// Which maneuver is next: each kind of trouble has its own order, and all share
// one budget. Not thread-safe.
class RecoverySequence {
 public:
  explicit RecoverySequence(const NavigatorLimits& limits) : limits_(limits) {}

  // nullopt: the budget is used up.
  std::optional<RecoverySequenceStep> Next(Trouble trouble);
  // The robot got on; all of the budget is there again.
  void Refill() { *this = RecoverySequence(limits_); }
  // The last maneuver ended before its time, as something changed: it does not
  // count. Only so often until the budget is refilled.
  void GiveBack();
  int used() const { return used_; }

 private:
  NavigatorLimits limits_;
  int used_ = 0;
  int given_back_ = 0;
  bool can_give_back_ = false;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_MANEUVER_H_
