// Where things of a building's plan are: the ground below a point, and walls
// by their names.
#ifndef SIMULATION_BUILDING_PLAN_GEOMETRY_H_
#define SIMULATION_BUILDING_PLAN_GEOMETRY_H_

#include <optional>
#include <vector>

#include "absl/strings/string_view.h"
#include "simulation/building/building_plan.h"

namespace treeline::building {

// The height of the ground at a point; stairs are none. nullopt: there is no
// ground, or none within 10 cm of the point's z. Without a z: the lowest
// ground that is not inside of a platform or ramp.
std::optional<double> GroundAt(const BuildingPlan& plan,
                               const PlanPoint& point);

// A side of a room, or a wall.
struct WallRef {
  int room = -1;  // among BuildingPlan::rooms, with its side
  PlanSide side = kSouth;
  int wall = -1;  // among BuildingPlan::walls, with the side that is meant
  bool is_left = true;
  bool names_side = true;  // false: "NAME" of a wall, both sides
  // Bounds of PlanOnWall::at_m, and of heights.
  double low_m = 0;
  double high_m = 0;
  double base_m = 0;
  double height_m = 0;

  bool IsSameFace(const WallRef& other) const {
    return room == other.room && side == other.side && wall == other.wall;
  }
};
std::optional<WallRef> FindWall(const BuildingPlan& plan,
                                absl::string_view name);
// All names that FindWall knows.
std::vector<std::string> WallNames(const BuildingPlan& plan);

// The room's side on the other side of a stretch of this one, from at0 to at1;
// nullopt: it is not all of one room, or the outside.
std::optional<WallRef> WallBehind(const BuildingPlan& plan, const WallRef& ref,
                                  double at0_m, double at1_m);

// Where somebody stands who looks at a wall's surface, turned round: x along
// the wall, y out of it (see Placement).
struct WallFrame {
  double x_m = 0;
  double y_m = 0;
  double yaw_rad = 0;
};
WallFrame FrameOnWall(const BuildingPlan& plan, const WallRef& ref,
                      double at_m);

}  // namespace treeline::building

#endif  // SIMULATION_BUILDING_PLAN_GEOMETRY_H_
