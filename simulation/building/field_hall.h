// The hall that fields of cylinders stand in.
#ifndef SIMULATION_BUILDING_FIELD_HALL_H_
#define SIMULATION_BUILDING_FIELD_HALL_H_

#include <array>
#include <cstdint>

#include "simulation/building/building_plan.h"

namespace treeline::building {

struct FieldHall {
  double width_m = 0;
  double depth_m = 0;
  // Columns and rows of them.
  std::array<int, 2> lamps{};
  // Of the place "start", in the middle of the width; it looks along y.
  double start_y_m = 0;
  // Of the place "goal", from there.
  double goal_ahead_m = 0;
};

// With nothing in it.
BuildingPlan PlanOf(const FieldHall& hall, uint64_t seed);

// To a millimetre, as world files are read and written.
double ToMillimetres(double length_m);

}  // namespace treeline::building

#endif  // SIMULATION_BUILDING_FIELD_HALL_H_
