// What the states of a goal work with.
#ifndef NAV_AGENT_BEHAVIOR_GOAL_TOOLS_H_
#define NAV_AGENT_BEHAVIOR_GOAL_TOOLS_H_

#include <memory>
#include <utility>
#include <vector>

#include "nav_agent/behavior/event_log.h"
#include "nav_agent/behavior/goal_attempts.h"
#include "nav_agent/behavior/obstacle_memory.h"
#include "nav_agent/behavior/occupied_goal.h"
#include "nav_agent/behavior/plan_requests.h"
#include "nav_agent/behavior/progress_checker.h"

namespace treeline::behavior {

// What was planned last, for pictures too.
struct PlannedRoute {
  std::vector<core::LevelPose> path;
  // Of the last plan that had any.
  std::vector<geometry::Vec2> tree_edges;
};

// Kept from one state to the next. planner, local_controller and event_log must
// outlive it.
struct GoalTools {
  GoalTools(std::shared_ptr<const traversability::NavigationMap> navigation_map,
            PlannerWorker& planner, control::LocalController& local_controller,
            const NavigatorOptions& navigator_options, EventLog& event_log)
      : map(std::move(navigation_map)),
        controller(local_controller),
        options(navigator_options),
        events(event_log),
        plans(planner, navigator_options),
        blockages(navigator_options.limits),
        progress(navigator_options.limits),
        attempts(navigator_options.limits) {}

  std::shared_ptr<const traversability::NavigationMap> map;
  control::LocalController& controller;
  const NavigatorOptions options;
  EventLog& events;
  PlanRequests plans;
  ObstacleMemory blockages;
  ProgressChecker progress;
  GoalAttempts attempts;
  OccupiedGoal occupied;
  PlannedRoute route;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_GOAL_TOOLS_H_
