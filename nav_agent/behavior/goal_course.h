// A goal that is being driven to, and what can come of a step towards it.
#ifndef NAV_AGENT_BEHAVIOR_GOAL_COURSE_H_
#define NAV_AGENT_BEHAVIOR_GOAL_COURSE_H_

#include <string>

#include "nav_agent/behavior/maneuver.h"
#include "nav_agent/behavior/navigator.h"

namespace treeline::behavior {

struct GoalCourse {
  const core::LevelPose& Target() const { return goal.poses[status.next_pose]; }
  bool IsLastLeg() const { return status.next_pose + 1 == goal.poses.size(); }

  NavigationGoal goal;
  GoalStatus status;
  // No path to the next pose has been found yet.
  bool is_first_path = true;
};

// A path to the next pose.
struct PlannedPath {
  planning::PlanResult result;
  // The planner was told of what stands about.
  bool had_blockages = false;
  // Found within the first budget: with more time there may be a better one.
  bool may_be_better = false;
};

// The robot does not get on; there are recoveries for that.
struct GoalTrouble {
  Trouble kind = Trouble::kNoWay;
  core::NavigationCause cause = core::NavigationCause::kNone;
  std::string why;
};

struct GoalEnd {
  GoalState state = GoalState::kFailed;
  core::NavigationCause cause = core::NavigationCause::kNone;
  std::string why;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_GOAL_COURSE_H_
