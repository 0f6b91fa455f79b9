// Fields of moving cylinders as in DynaBARN (Nair, Jiang, Hou, Xu, Li, Xiao,
// Stone: "DynaBARN: Benchmarking Metric Ground Navigation in Dynamic
// Environments", SSRR 2022): along polynomials, at speeds that change.
#ifndef SIMULATION_BUILDING_MOVING_FIELD_H_
#define SIMULATION_BUILDING_MOVING_FIELD_H_

#include <cstdint>
#include <vector>

#include "simulation/building/building_plan.h"

namespace treeline::building {

enum class FieldDifficulty : uint8_t { kEasy, kMedium, kHard };

// One cylinder's way: from point to point, each way at a speed of its own, and
// then at once where it began.
struct MovingCylinder {
  // In the field, whose middle is the origin.
  std::vector<PlanPoint> points;
  // From each point to the next (m/s); one less than points.
  std::vector<double> speeds_mps;
  // Where among the points it is at first.
  int first = 0;
};

// 20 x 20 m. The paper's Table I and Fig. 2: easy motion is along polynomials
// of degree 1 or 2 at 0.5 to 1 m/s, hard motion along those of degree 3 or 4 at
// 1 to 2 m/s; 5 to 10 of them are few, 10 to 20 many. Few with easy motion are
// easy, many with hard motion hard, the other two medium.
struct MovingField {
  static constexpr double kHalf_m = 10;
  static constexpr double kRadius_m = 0.5;

  uint64_t seed = 0;
  FieldDifficulty difficulty = FieldDifficulty::kEasy;
  std::vector<MovingCylinder> cylinders;
};

// The field that `seed` stands for: an easy one, a medium one, a hard one, one
// after the other. The robot does not touch its front, so that what begins
// there is not upon it.
MovingField DrawMovingField(uint64_t seed);

// Start and goal: 1 m before the field, in the middle, and 20 m ahead.
inline constexpr double kMovingFieldGoalAhead_m = 20;

// The field with walls on three sides in a hall of 22 x 25 m, with places
// "start" and "goal". A world file could hold it.
BuildingPlan MovingFieldPlan(const MovingField& field);

}  // namespace treeline::building

#endif  // SIMULATION_BUILDING_MOVING_FIELD_H_
