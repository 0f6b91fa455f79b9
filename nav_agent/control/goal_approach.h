// The last decimetres: onto the goal, then round to its heading.
#ifndef NAV_AGENT_CONTROL_GOAL_APPROACH_H_
#define NAV_AGENT_CONTROL_GOAL_APPROACH_H_

#include "common/geometry/rigid2.h"
#include "nav_agent/control/track_follower.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::control {

struct GoalApproachOptions {
  double tolerance_m = 0.10;
  double tolerance_rad = 0.15;
  // It begins this far from the goal, along the path and in a line (m).
  double near_m = 0.25;
};

// Not thread-safe.
class GoalApproach {
 public:
  explicit GoalApproach(const GoalApproachOptions& options)
      : options_(options) {}

  void Reset() { phase_ = Phase::kFar; }
  // Whether the robot is to be steered by Command from now on.
  bool IsNear(const geometry::Rigid2& map_from_base,
              const geometry::Rigid2& map_from_goal, double left_m);
  core::VelocityCommand Command(const geometry::Rigid2& map_from_base,
                                const geometry::Rigid2& map_from_goal,
                                const core::RobotModel& robot,
                                const TrackFollowerOptions& options);
  // Within both tolerances with room to spare; the robot may still be moving.
  bool is_done() const { return phase_ == Phase::kDone; }
  bool is_turning() const { return phase_ == Phase::kTurn; }

 private:
  enum class Phase { kFar, kMove, kTurn, kDone };

  GoalApproachOptions options_;
  Phase phase_ = Phase::kFar;
  bool aligns_ = false;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_GOAL_APPROACH_H_
