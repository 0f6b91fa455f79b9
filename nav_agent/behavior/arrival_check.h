// Whether a robot that is said to have arrived has reached its goal.
#ifndef NAV_AGENT_BEHAVIOR_ARRIVAL_CHECK_H_
#define NAV_AGENT_BEHAVIOR_ARRIVAL_CHECK_H_

#include <cstdint>
#include <optional>
#include <string>

#include "nav_agent/control/local_controller.h"

namespace treeline::behavior {

// Where a path ends, seen from its goal.
struct PathEnd {
  // So far from it (m), at the next place where there is room.
  double beside_goal_m = 0;
  // Because of something that was seen there, which may go.
  bool is_goal_taken = false;
};

// Not thread-safe.
class ArrivalCheck {
 public:
  explicit ArrivalCheck(const PathEnd& end) : end_(end) {}

  enum class Outcome : uint8_t {
    kOpen,    // not yet, or it waits beside a goal that is taken
    kStands,  // the same, and it stands where it is to wait
    kReached,
    kDisputed  // the controller says so for long, and it is not true
  };
  // While the controller says that it has arrived. target: the path's end.
  Outcome Step(const control::ControlPose& pose, const core::LevelPose& target,
               const control::LocalControllerOptions& tolerances,
               base::MonotonicTime now);
  // The controller does not say so any more.
  void Restart() { since_.reset(); }

  // For people, of a goal that was reached.
  std::string Text(const core::LevelPose& robot, const core::LevelPose& target,
                   double driven_m) const;
  const PathEnd& end() const { return end_; }

 private:
  PathEnd end_;
  std::optional<base::MonotonicTime> since_;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_ARRIVAL_CHECK_H_
