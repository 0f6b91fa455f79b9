#include "simulation/building/cylinder_field.h"

#include <cmath>

#include "gtest/gtest.h"
#include "simulation/building/plan_file.h"

namespace treeline::building {
namespace {

TEST(CylinderField, IsAFunctionOfItsSeed) {
  EXPECT_EQ(DrawField(5).is_filled, DrawField(5).is_filled);
  EXPECT_NE(DrawField(5).is_filled, DrawField(17).is_filled);
}

TEST(CylinderField, TwelveKindsComeOneAfterTheOther) {
  const CylinderField first = DrawField(0);
  EXPECT_DOUBLE_EQ(first.fill, 0.15);
  EXPECT_EQ(first.smoothings, 2);
  const CylinderField last = DrawField(11);
  EXPECT_DOUBLE_EQ(last.fill, 0.30);
  EXPECT_EQ(last.smoothings, 4);
}

TEST(CylinderField, AWayLeadsThroughEach) {
  for (uint64_t seed = 0; seed < 24; ++seed) {
    const CylinderField field = DrawField(seed);
    const double way_m = BestWay_m(field);
    // As far as it is straight ahead, and not twice around the field.
    EXPECT_GE(way_m, kFieldGoalAhead_m - 1e-9) << seed;
    EXPECT_LT(way_m, 20) << seed;
    // The corridor before the field is closed at its sides, and free.
    for (int y = 1; y < CylinderField::kRows - CylinderField::kFieldRows; ++y) {
      EXPECT_TRUE(field.At(0, y));
      EXPECT_FALSE(field.At(15, y));
      EXPECT_TRUE(field.At(29, y));
    }
  }
}

TEST(CylinderField, AFreeFieldsWayIsStraight) {
  CylinderField field;
  field.is_filled.assign(
      static_cast<size_t>(CylinderField::kColumns * CylinderField::kRows),
      false);
  // Columns are beside the middle by half a cell.
  EXPECT_NEAR(BestWay_m(field), kFieldGoalAhead_m, 0.01);
  for (int x = 0; x < CylinderField::kColumns; ++x) {
    field.is_filled[static_cast<size_t>(50 * CylinderField::kColumns + x)] =
        true;
  }
  EXPECT_TRUE(std::isinf(BestWay_m(field)));
}

TEST(CylinderField, AWorldFileHoldsItsPlan) {
  const BuildingPlan plan = FieldPlan(DrawField(11));
  EXPECT_GT(plan.pillars.size(), 150U);
  const auto read = ParsePlan(PlanText(plan), "field.yaml");
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(*read, plan);
}

}  // namespace
}  // namespace treeline::building
