#include "simulation/building/office_generator.h"

#include <cmath>
#include <set>
#include <string>

#include "gtest/gtest.h"
#include "simulation/building/plan_file.h"

namespace treeline::building {
namespace {

TEST(OfficeGenerator, IsAsLargeAsAskedAndAFileHoldsIt) {
  for (const int area_m2 :
       {kSmallestOffice_m2, 250, 500, 1000, kLargestOffice_m2}) {
    for (uint64_t seed = 0; seed < 8; ++seed) {
      const BuildingPlan plan = DrawOffice(area_m2, seed, 0);
      EXPECT_NEAR(plan.size_m[0] * plan.size_m[1], area_m2, 0.01 * area_m2);
      // Rooms of 20 to 35 m2, and corridors.
      EXPECT_GT(plan.rooms.size(), static_cast<size_t>(area_m2 / 50));
      EXPECT_LT(plan.rooms.size(), static_cast<size_t>(area_m2 / 18));
      const auto read = ParsePlan(PlanText(plan), "office.yaml");
      ASSERT_TRUE(read.ok()) << area_m2 << ":" << seed << ": " << read.status();
      EXPECT_TRUE(*read == plan) << area_m2 << ":" << seed;
    }
  }
}

TEST(OfficeGenerator, IsAFunctionOfSizeSeedAndAttempt) {
  EXPECT_TRUE(DrawOffice(300, 5, 0) == DrawOffice(300, 5, 0));
  std::set<std::string> texts;
  for (const int area_m2 : {300, 301}) {
    for (const uint64_t seed : {5U, 6U}) {
      for (const int attempt : {0, 1}) {
        texts.insert(PlanText(DrawOffice(area_m2, seed, attempt)));
      }
    }
  }
  EXPECT_EQ(texts.size(), 8u);
}

// Furniture of the room that is moved to the west by `dx` is furniture, too.
bool HasTwins(const BuildingPlan& plan) {
  for (size_t i = 1; i < plan.rooms.size(); ++i) {
    const PlanRoom& room = plan.rooms[i];
    const PlanRoom& before = plan.rooms[i - 1];
    const double dx = room.area.x0_m - before.area.x0_m;
    if (room.walls != before.walls || room.floor != before.floor ||
        room.area.y0_m != before.area.y0_m) {
      continue;
    }
    int pieces = 0;
    for (const PlanFurniture& piece : plan.furniture) {
      const PlanPoint& at = piece.stand.at;
      if (!room.area.Contains(at.x_m, at.y_m)) continue;
      for (const PlanFurniture& other : plan.furniture) {
        if (other.kind == piece.kind && other.variant == piece.variant &&
            std::abs(other.stand.at.x_m + dx - at.x_m) < 0.02 &&
            other.stand.at.y_m == at.y_m) {
          ++pieces;
        }
      }
    }
    if (pieces >= 4) return true;
  }
  return false;
}

TEST(OfficeGenerator, SomeNeighboursAreAlike) {
  int with_twins = 0;
  for (uint64_t seed = 0; seed < 10; ++seed) {
    if (HasTwins(DrawOffice(1000, seed, 0))) ++with_twins;
  }
  EXPECT_GE(with_twins, 8);
}

}  // namespace
}  // namespace treeline::building
