// A building's plan of what stands in a world of Gazebo.
#ifndef SIMULATION_BUILDING_GAZEBO_PLAN_H_
#define SIMULATION_BUILDING_GAZEBO_PLAN_H_

#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "simulation/building/building_plan.h"
#include "simulation/building/gazebo_world.h"

namespace treeline::building {

// The place at Gazebo's origin, which looks along Gazebo's x axis: poses in
// Gazebo's world are seen from it.
inline constexpr absl::string_view kGazeboOrigin = "origin";

// Cylinders as round pillars, boxes as walls, to a millimetre, on flat ground
// in a hall whose walls are, if 200 m allow it, further from everything than
// lasers of 30 m see: Gazebo's worlds have none. What is 2 m above the ground
// or below it is left out. Its places are "start", the nearest one to the
// origin where a robot has room, and kGazeboOrigin.
//
// INVALID_ARGUMENT, "FILE:LINE: reason" with the model's name: something
// hovers below 2 m, is too wide, lies too far from the rest, or there is no
// room for a robot. `name` is what errors call the file.
absl::StatusOr<BuildingPlan> GazeboPlan(const std::vector<GazeboSolid>& solids,
                                        absl::string_view name);

}  // namespace treeline::building

#endif  // SIMULATION_BUILDING_GAZEBO_PLAN_H_
