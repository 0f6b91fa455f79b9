// The way to a goal over a building's levels.
#ifndef NAV_AGENT_PLANNING_GLOBAL_PLANNER_H_
#define NAV_AGENT_PLANNING_GLOBAL_PLANNER_H_

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "nav_agent/core/level_pose.h"
#include "nav_agent/core/navigation_cause.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/planning/planner_parameters.h"
#include "nav_agent/traversability/loose_things.h"
#include "nav_agent/traversability/navigation_map.h"
#include "nav_agent/zones/zone_map.h"

namespace treeline::planning {

// A disc that must not be driven through: something stood there that the map
// does not have.
struct Blockage {
  geometry::Vec2 center;
  double radius_m = 0;
  int level = 0;
};

struct PlanRequest {
  core::LevelPose start;
  core::LevelPose goal;
  std::vector<Blockage> blockages = {};
  uint64_t seed = 0;
  // Of the planner's map; null: none.
  std::shared_ptr<const zones::ZoneMap> zones = nullptr;
  // What of the map was seen to be gone; null: nothing.
  std::shared_ptr<const traversability::FreedCells> freed = nullptr;
};

struct PlanBudget {
  // Both end the improving of a path; infinite time makes the result a function
  // of the request alone.
  int max_iterations = kMaxIterations;
  double max_time_s = std::numeric_limits<double>::infinity();
  // false: the first path will do (of variable-rrt).
  bool improves = true;
  // What time is counted by, of variable-rrt, which plans in the caller's
  // thread; not owned. Null: the steady clock.
  const base::Clock* clock = nullptr;
};

struct PlanResult {
  // kNone: there is a path.
  core::NavigationCause failure = core::NavigationCause::kNone;
  // Of a failure: what is where, for people.
  std::string why;
  // From start to goal, poses the robot can stand at, dense enough to be drawn
  // as lines; headings are along the path, and the goal's at its end.
  std::vector<core::LevelPose> path;
  double length_m = 0;
  // How far start and goal were moved to where the robot has room (m); also
  // where it cannot turn at the start and only get away backwards, or only come
  // to the goal backwards: the path then begins behind it, and ends where it
  // can turn.
  double moved_start_m = 0;
  double moved_goal_m = 0;
  int iterations = 0;
  double first_path_s = 0;
  double total_s = 0;
  // Pairs of points: the edges of both trees as they were when the first path
  // was found, for pictures.
  std::vector<geometry::Vec2> tree_edges;
  // How many of the points are of the start's tree; the goal's follow.
  size_t start_tree_points = 0;
};

struct GlobalPlannerOptions {
  // "variable-rrt" (our own), or of OMPL: "rrt-connect", "rrt-star",
  // "bit-star", "informed-rrt-star", and "ompl-variable-rrt", our own as a
  // planner of OMPL.
  std::string planner = "variable-rrt";
  // Room beside the robot's footprint (m, 0 to 1).
  double margin_m = kPlanMargin_m;
  // Start and goal are moved by at most this, a robot's length, to where there
  // is room (m).
  double max_move_m = core::RobotModel().front_m + core::RobotModel().rear_m;

  absl::Status Validate() const;
};

// Thread-safe. Plan is a pure function of the request, and of time where the
// budget is of time. All planners respect zones (ZonePlanner) and
// plan over what is gone (FreedPlanner).
class GlobalPlanner {
 public:
  virtual ~GlobalPlanner() = default;
  // CANCELLED if `stop` is requested; INVALID_ARGUMENT for poses that are not
  // finite. That there is no way is a result.
  virtual absl::StatusOr<PlanResult> Plan(
      const PlanRequest& request, const PlanBudget& budget,
      const std::stop_token& stop) const = 0;
};

// INVALID_ARGUMENT for bad options, and for planners there are not, with those
// there are.
absl::StatusOr<std::unique_ptr<GlobalPlanner>> MakeGlobalPlanner(
    std::shared_ptr<const traversability::NavigationMap> map,
    const core::RobotModel& robot, const GlobalPlannerOptions& options);

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_GLOBAL_PLANNER_H_
