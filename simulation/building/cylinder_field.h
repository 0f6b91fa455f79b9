// Fields of cylinders as in the BARN data set (Perille, Truong, Xiao, Stone:
// "Benchmarking Metric Ground Navigation", SSRR 2020): cells of 0.15 m that a
// cellular automaton fills, a cylinder of 7.5 cm radius in each.
#ifndef SIMULATION_BUILDING_CYLINDER_FIELD_H_
#define SIMULATION_BUILDING_CYLINDER_FIELD_H_

#include <cstdint>
#include <vector>

#include "simulation/building/building_plan.h"

namespace treeline::building {

// 66 rows along y, of 30 cells along x. As in the data set, the automaton fills
// the last 30 rows; before them is a free corridor, which cylinders along both
// sides and at its back make the only place to come from.
struct CylinderField {
  static constexpr int kColumns = 30;
  static constexpr int kRows = 66;
  static constexpr int kFieldRows = 30;
  static constexpr double kCell_m = 0.15;

  uint64_t seed = 0;
  // Of the automaton: the share of cells that it begins with, and its steps.
  double fill = 0;
  int smoothings = 0;
  // Rows from y = 0.
  std::vector<bool> is_filled;

  bool At(int x, int y) const {
    return is_filled[static_cast<size_t>(y) * kColumns +
                     static_cast<size_t>(x)];
  }
};

// The field that `seed` stands for. Its fill is 0.15 to 0.30, its steps are 2
// to 4, as in the data set's twelve kinds, one after the other; it is drawn
// again until squares of 5 x 5 free cells (0.75 m) lead from one end to the
// other.
CylinderField DrawField(uint64_t seed);

// The shortest way from start to goal on whose cells squares of 5 x 5 are free
// of cylinders (m); straight before and behind the field. What the score's
// optimal time is made of. Infinite: there is none.
double BestWay_m(const CylinderField& field);

// Start and goal: 2 m before the field, in the middle, heading north, and 10 m
// ahead, 3.5 m behind the field.
inline constexpr double kFieldGoalAhead_m = 10;

// The field in a hall of 12 x 17 m, with places "start" and "goal". A world
// file could hold it.
BuildingPlan FieldPlan(const CylinderField& field);

}  // namespace treeline::building

#endif  // SIMULATION_BUILDING_CYLINDER_FIELD_H_
