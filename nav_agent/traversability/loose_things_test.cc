#include "nav_agent/traversability/loose_things.h"

#include <limits>
#include <vector>

#include "gtest/gtest.h"

namespace treeline::traversability {
namespace {

// 5 x 5 m of free ground, its surface at height 0.
class LooseThingsTest : public testing::Test {
 protected:
  LooseThingsTest() {
    TraversableLevel level;
    level.grid =
        core::OccupancyGrid::Filled(100, 100, 0.05, {}, core::Occupancy::kFree);
    level.height_m.assign(10000, -0.025F);
    level.slope_rad.assign(10000, 0);
    level.clearance_m.assign(10000, std::numeric_limits<float>::infinity());
    map_.levels.push_back(level);
  }
  void Put(core::CellIndex from, core::CellIndex to) {
    for (int y = from.y; y < to.y; ++y) {
      for (int x = from.x; x < to.x; ++x) {
        map_.levels[0].grid.Set({x, y}, core::Occupancy::kOccupied);
      }
    }
  }
  void Height(core::CellIndex from, core::CellIndex to, float surface_m) {
    for (int y = from.y; y < to.y; ++y) {
      for (int x = from.x; x < to.x; ++x) {
        map_.levels[0].height_m[map_.levels[0].grid.IndexOf({x, y})] =
            surface_m - 0.025F;
      }
    }
  }
  NavigationMap Map() const { return *NavigationMap::Make(map_); }
  std::vector<LooseThing> Things() const { return FindLooseThings(Map(), 2); }

  TraversableMap map_;
};

TEST_F(LooseThingsTest, AreWhatHangsTogether) {
  Put({20, 30}, {22, 34});
  Put({22, 34}, {23, 36});  // by a corner
  Put({60, 60}, {61, 61});
  const std::vector<LooseThing> things = Things();
  ASSERT_EQ(things.size(), 2);
  EXPECT_EQ(things[0].cells.size(), 10);
  EXPECT_NEAR(things[0].ground_m, 0, 1e-6);
  EXPECT_NEAR(things[0].middle_in_map.x, 1.075, 1e-9);
  EXPECT_NEAR(things[0].middle_in_map.y, 1.65, 1e-9);
  EXPECT_EQ(things[1].cells.size(), 1);
}

TEST_F(LooseThingsTest, AreNotWallsNorWhatTouchesThem) {
  Put({10, 50}, {60, 51});
  Put({30, 51}, {32, 55});
  EXPECT_TRUE(Things().empty());
}

TEST_F(LooseThingsTest, AreNotAtTheBorder) {
  Put({0, 20}, {3, 22});
  EXPECT_TRUE(Things().empty());
}

TEST_F(LooseThingsTest, AreNotKerbsNorPlatforms) {
  // A row of cells between two grounds.
  Put({40, 40}, {41, 60});
  Height({41, 0}, {100, 100}, 0.1F);
  EXPECT_TRUE(Things().empty());
}

TEST_F(LooseThingsTest, AreNotHoles) {
  Put({40, 40}, {46, 46});
  Height({41, 41}, {45, 45}, -0.4F);
  EXPECT_TRUE(Things().empty());
}

TEST_F(LooseThingsTest, AreNotAnotherLevelsGround) {
  map_.levels.push_back(map_.levels[0]);
  for (core::Occupancy& cell : map_.levels[1].grid.cells) {
    cell = core::Occupancy::kUnknown;
  }
  map_.levels[1].grid.Set({50, 50}, core::Occupancy::kFree);
  Put({49, 49}, {52, 52});
  for (const LooseThing& thing : Things()) EXPECT_EQ(thing.level, 1);
}

TEST_F(LooseThingsTest, CellsThatAreFreedAreGroundOfTheMap) {
  Put({40, 40}, {43, 43});
  Height({40, 40}, {43, 43}, 0.8F);
  const FreedCells freed({{.level = 0, .cell = {41, 41}, .ground_m = 0},
                          {.level = 0, .cell = {40, 41}, .ground_m = 0}});
  EXPECT_EQ(freed.Ground_m(0, {41, 41}), 0.0F);
  EXPECT_FALSE(freed.Ground_m(0, {41, 40}).has_value());
  EXPECT_FALSE(freed.Ground_m(1, {41, 41}).has_value());
  const NavigationMap map = *MapWithFreed(Map(), freed);
  EXPECT_TRUE(map.IsFree(0, {41, 41}));
  EXPECT_FALSE(map.IsFree(0, {42, 42}));
  EXPECT_NEAR(map.GroundOf({2.075, 2.075}, 0)->height_m, 0, 1e-6);
  EXPECT_FALSE(
      MapWithFreed(Map(),
                   FreedCells({{.level = 0, .cell = {100, 3}, .ground_m = 0}}))
          .ok());
}

}  // namespace
}  // namespace treeline::traversability
