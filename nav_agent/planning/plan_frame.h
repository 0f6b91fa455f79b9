// Requests and paths, from the map's frame to the grids' and back.
#ifndef NAV_AGENT_PLANNING_PLAN_FRAME_H_
#define NAV_AGENT_PLANNING_PLAN_FRAME_H_

#include <memory>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "nav_agent/planning/configuration_space.h"
#include "nav_agent/planning/global_planner.h"
#include "nav_agent/planning/regions.h"
#include "nav_agent/planning/variable_rrt.h"

namespace treeline::planning {

// What all planners share of a map and a robot.
struct PlanGround {
  // zones: as GroundIndex has them.
  PlanGround(std::shared_ptr<const traversability::NavigationMap> map,
             const core::RobotModel& robot, double margin_m,
             std::shared_ptr<const zones::ZoneMap> zones = nullptr);
  PlanGround(std::shared_ptr<const GroundIndex> index_of,
             const core::RobotModel& robot, double margin_m);

  std::shared_ptr<const GroundIndex> index;
  Footprint footprint;
  // Without blockages.
  std::shared_ptr<const Regions> regions;
};

// A request that has a start and a goal with room, in the grids' frame.
struct PlanTask {
  ConfigurationSpace space;
  Stand start;
  Stand goal;
  std::shared_ptr<const Regions> regions;
  // That both are in.
  int area = 0;
};

// INVALID_ARGUMENT for what is not finite.
absl::Status CheckRequest(const PlanRequest& request);

// Moves start and goal to where there is room. nullopt: `result` says why there
// is no way.
std::optional<PlanTask> MakeTask(const PlanGround& ground,
                                 const PlanRequest& request, double max_move_m,
                                 PlanResult& result);

// A pose of the map in the grids' frame.
Stand StandOf(const GroundIndex& ground, const core::LevelPose& pose);

// Writes the way into the result: poses at most 0.1 m from one another.
void WriteWay(const PlanTask& task, const Polyline& way, PlanResult& result);

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_PLAN_FRAME_H_
