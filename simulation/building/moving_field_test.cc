#include "simulation/building/moving_field.h"

#include <algorithm>
#include <cmath>

#include "gtest/gtest.h"
#include "simulation/building/plan_file.h"

namespace treeline::building {
namespace {

TEST(MovingField, IsAFunctionOfItsSeed) {
  EXPECT_EQ(MovingFieldPlan(DrawMovingField(5)),
            MovingFieldPlan(DrawMovingField(5)));
  EXPECT_NE(MovingFieldPlan(DrawMovingField(5)).movers,
            MovingFieldPlan(DrawMovingField(8)).movers);
}

TEST(MovingField, EasyMediumAndHardOnesComeOneAfterTheOther) {
  EXPECT_EQ(DrawMovingField(1).difficulty, FieldDifficulty::kEasy);
  EXPECT_EQ(DrawMovingField(2).difficulty, FieldDifficulty::kMedium);
  EXPECT_EQ(DrawMovingField(3).difficulty, FieldDifficulty::kHard);
  EXPECT_EQ(DrawMovingField(1001).difficulty, FieldDifficulty::kMedium);
}

TEST(MovingField, NumbersAndSpeedsAreThoseOfTheirKind) {
  bool has_few_fast = false;
  bool has_many_slow = false;
  for (uint64_t seed = 0; seed < 60; ++seed) {
    const MovingField field = DrawMovingField(seed);
    const bool has_many = field.cylinders.size() > 10;
    bool is_fast = false;
    for (const MovingCylinder& cylinder : field.cylinders) {
      for (const double speed_mps : cylinder.speeds_mps) {
        EXPECT_GE(speed_mps, 0.5);
        EXPECT_LE(speed_mps, 2.0);
        is_fast = is_fast || speed_mps > 1;
      }
    }
    switch (field.difficulty) {
      case FieldDifficulty::kEasy:
        EXPECT_FALSE(is_fast || has_many) << seed;
        break;
      case FieldDifficulty::kMedium:
        EXPECT_FALSE(is_fast && has_many) << seed;
        has_few_fast = has_few_fast || is_fast;
        has_many_slow = has_many_slow || has_many;
        break;
      case FieldDifficulty::kHard:
        EXPECT_TRUE(is_fast) << seed;
        EXPECT_GE(field.cylinders.size(), 10u) << seed;
        break;
    }
    EXPECT_GE(field.cylinders.size(), 5u) << seed;
    EXPECT_LE(field.cylinders.size(), 20u) << seed;
  }
  EXPECT_TRUE(has_few_fast);
  EXPECT_TRUE(has_many_slow);
}

TEST(MovingField, EachCrossesTheFieldFromBorderToBorder) {
  const auto is_on_border = [](const PlanPoint& point) {
    return std::max(std::abs(point.x_m), std::abs(point.y_m)) >
           MovingField::kHalf_m - 1e-6;
  };
  for (uint64_t seed = 0; seed < 30; ++seed) {
    for (const MovingCylinder& cylinder : DrawMovingField(seed).cylinders) {
      EXPECT_TRUE(is_on_border(cylinder.points.front())) << seed;
      EXPECT_TRUE(is_on_border(cylinder.points.back())) << seed;
      EXPECT_EQ(cylinder.speeds_mps.size() + 1, cylinder.points.size());
      for (const PlanPoint& point : cylinder.points) {
        EXPECT_LE(std::abs(point.x_m), MovingField::kHalf_m + 1e-6);
        EXPECT_LE(std::abs(point.y_m), MovingField::kHalf_m + 1e-6);
      }
    }
  }
}

TEST(MovingField, AWorldFileHoldsIt) {
  const BuildingPlan plan = MovingFieldPlan(DrawMovingField(3));
  const auto read = ParsePlan(PlanText(plan), "x.yaml");
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(*read, plan);
}

}  // namespace
}  // namespace treeline::building
