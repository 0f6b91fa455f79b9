#include "nav_agent/planning/regions.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/planning/alternatives.h"
#include "nav_agent/planning/path_smoother.h"
#include "nav_agent/planning/routes.h"
#include "nav_agent/planning/testing_maps.h"

namespace treeline::planning {
namespace {

// A room of 9 x 7 m with walls at random: many areas.
std::vector<std::string> ScatteredRows(uint64_t seed) {
  std::vector<std::string> rows = RoomRows(90, 70);
  base::Random random(seed, 0);
  for (int i = 0; i < 45; ++i) {
    const int x = 1 + static_cast<int>(random.NextBelow(80));
    const int y = 1 + static_cast<int>(random.NextBelow(60));
    const bool is_wide = random.NextBelow(2) == 0;
    Fill(rows, x, std::min(89, x + (is_wide ? 18 : 2)), y,
         std::min(69, y + (is_wide ? 2 : 18)), '#');
  }
  return rows;
}

ConfigurationSpace SpaceOf(const std::vector<std::string>& rows,
                           std::vector<Disc> discs) {
  return {std::make_shared<const GroundIndex>(DrawnMap(rows)),
          Footprint::Of(core::RobotModel(), 0.0), std::move(discs)};
}

std::vector<Disc> SomeDiscs(uint64_t seed) {
  std::vector<Disc> discs;
  base::Random random(seed, 1);
  for (int i = 0; i < 6; ++i) {
    discs.push_back(
        {.center = {random.NextUniform(-0.5, 9.5), random.NextUniform(0, 7)},
         .radius_m = random.NextUniform(0.1, 0.8)});
  }
  return discs;
}

// The area of each cell by flood fill over cells; -1: in none.
std::vector<int> FloodFilled(const ConfigurationSpace& space) {
  const GroundIndex& ground = space.ground();
  const auto is_open = [&](core::CellIndex cell) {
    return ground.Contains(cell) && ground.map().IsFree(0, cell) &&
           space.MayHoldDisc({ground.CenterOf(cell), 0});
  };
  std::vector<int> areas(ground.cells(), -1);
  int count = 0;
  for (int y = 0; y < ground.height(); ++y) {
    for (int x = 0; x < ground.width(); ++x) {
      if (!is_open({x, y}) || areas[ground.IndexOf({x, y})] >= 0) continue;
      std::vector<core::CellIndex> found = {{x, y}};
      areas[ground.IndexOf({x, y})] = count;
      for (size_t i = 0; i < found.size(); ++i) {
        for (int k = 0; k < 9; ++k) {
          const core::CellIndex next = {found[i].x + k % 3 - 1,
                                        found[i].y + k / 3 - 1};
          if (!is_open(next) || areas[ground.IndexOf(next)] >= 0) continue;
          areas[ground.IndexOf(next)] = count;
          found.push_back(next);
        }
      }
      ++count;
    }
  }
  return areas;
}

// Whether both divide the cells in the same way.
void ExpectSameAreas(const ConfigurationSpace& space, const Regions& regions) {
  const GroundIndex& ground = space.ground();
  const std::vector<int> filled = FloodFilled(space);
  std::set<std::pair<int, int>> pairs;
  for (int y = 0; y < ground.height(); ++y) {
    for (int x = 0; x < ground.width(); ++x) {
      const int own = regions.AreaOf(ground, {ground.CenterOf({x, y}), 0});
      const int other = filled[ground.IndexOf({x, y})];
      ASSERT_EQ(own < 0, other < 0) << "cell " << x << ", " << y;
      if (own >= 0) pairs.insert({own, other});
    }
  }
  EXPECT_EQ(pairs.size(), static_cast<size_t>(regions.areas()));
  EXPECT_EQ(pairs.size(), static_cast<size_t>(std::ranges::max(filled) + 1));
}

TEST(RegionsTest, AreasAreThoseOfAFloodFill) {
  for (uint64_t seed = 0; seed < 8; ++seed) {
    const ConfigurationSpace space = SpaceOf(ScatteredRows(seed), {});
    const Regions regions(space);
    EXPECT_GT(regions.areas(), 1);
    ExpectSameAreas(space, regions);
  }
}

TEST(RegionsTest, WithDiscsTheyAreAsIfMadeAnew) {
  for (uint64_t seed = 0; seed < 8; ++seed) {
    const std::vector<std::string> rows = ScatteredRows(seed);
    const Regions without(SpaceOf(rows, {}));
    const ConfigurationSpace space = SpaceOf(rows, SomeDiscs(seed));
    ExpectSameAreas(space, Regions(without, space));
  }
}

TEST(RegionsTest, DrawsAllCellsOfAnAreaAndNoOthers) {
  const ConfigurationSpace space = SpaceOf(TwoRoomsRows(5), {});
  const GroundIndex& ground = space.ground();
  const Regions regions(space);
  ASSERT_EQ(regions.areas(), 2);
  base::Random random(3, 0);
  std::set<uint32_t> drawn;
  for (int i = 0; i < 400'000; ++i) {
    drawn.insert(regions.DrawCell(ground, 1, random));
  }
  EXPECT_EQ(drawn.size(), regions.CellsOf(1));
  for (const uint32_t cell : drawn) {
    const int region = regions.RegionOfCell(cell);
    ASSERT_GE(region, 0);
    EXPECT_EQ(regions.region(static_cast<uint32_t>(region)).area, 1);
  }
}

TEST(RoutesTest, LeadFromCellToCellAndAreNearlyTheShortest) {
  const ConfigurationSpace space = SpaceOf(TwoRoomsRows(10), {});
  const GroundIndex& ground = space.ground();
  const Regions regions(space);
  const Spot start = {{1.02, 4.03}, 0};
  const Spot goal = {{7.01, 4.01}, 0};
  const auto number = [&](const Spot& spot) {
    return static_cast<uint32_t>(regions.RegionOf(ground, spot));
  };
  const Route route = FindRoute(regions, number(start), number(goal), {});
  ASSERT_TRUE(route.is_found);
  const Polyline way = CellsAlong(space, regions, start, goal, route);
  EXPECT_EQ(way.front(), start);
  EXPECT_EQ(way.back(), goal);
  for (size_t i = 1; i < way.size(); ++i) {
    // What is straight within a block is one line.
    EXPECT_LT(geometry::Norm(way[i].at - way[i - 1].at), 0.6);
    EXPECT_TRUE(space.MayHoldDisc(way[i]));
  }
  // Through the middle of the door: 2 * 3.37 m.
  EXPECT_LT(PathLength_m(way), 1.15 * 6.74);
  const RouteField field(regions, number(goal));
  EXPECT_NEAR(field.cost_m(number(start)), route.cost_m, 1e-3);
  EXPECT_EQ(field.RouteFrom(number(start)).edges.size(), route.edges.size());
  const Route back = Reversed(regions, route, number(start));
  EXPECT_EQ(back.edges.front().from_cell, route.edges.back().to_cell);
  EXPECT_EQ(back.edges.back().to_cell, route.edges.front().from_cell);
  const DistanceToGoal distance(ground, regions, goal, 1000);
  EXPECT_NEAR(distance.Of_m(start), 6.74, 0.15 * 6.74);
  EXPECT_NEAR(distance.Of_m({{7.1, 4.0}, 0}), 0.09, 0.01);
}

TEST(RoutesTest, AvoidRegionsThatCostMore) {
  std::vector<std::string> rows = TwoRoomsRows(10);
  Fill(rows, 40, 42, 5, 15, '.');  // a second door
  const ConfigurationSpace space = SpaceOf(rows, {});
  const Regions regions(space);
  const auto number = [&](double x, double y) {
    return static_cast<uint32_t>(regions.RegionOf(space.ground(), {{x, y}, 0}));
  };
  const uint32_t start = number(1, 4);
  const uint32_t goal = number(7, 4);
  std::vector<float> weights(regions.count(), 1.0F);
  const auto passes_below = [&](double y) {
    const Route route = FindRoute(regions, start, goal, weights);
    return std::ranges::any_of(route.edges, [&](const Regions::Edge& edge) {
      return regions.region(edge.to).center.y < y;
    });
  };
  EXPECT_FALSE(passes_below(1.6));
  for (uint32_t region = 0; region < regions.count(); ++region) {
    const geometry::Vec2 center = regions.region(region).center;
    if (std::abs(center.x - 4.1) < 0.6 && center.y > 1.8) weights[region] = 20;
  }
  EXPECT_TRUE(passes_below(1.6));
}

TEST(AlternativesTest, FindTheOtherSideOfAPillar) {
  std::vector<std::string> rows = RoomRows(80, 60);
  Fill(rows, 30, 50, 24, 46, '#');
  const ConfigurationSpace space = SpaceOf(rows, {});
  const Regions regions(space);
  Alternatives alternatives(space, regions, {{1, 3}, 0}, {{7, 3}, 0}, 7);
  std::vector<bool> is_above;
  for (Polyline way = alternatives.Next(); !way.empty();
       way = alternatives.Next()) {
    bool above = false;
    for (const Spot& spot : way) {
      if (std::abs(spot.at.x - 4) < 0.5) above = spot.at.y > 3;
    }
    is_above.push_back(above);
  }
  ASSERT_EQ(is_above.size(), 2U);
  EXPECT_FALSE(is_above[0]);
  EXPECT_TRUE(is_above[1]);
  // Neither is as short as that.
  EXPECT_TRUE(Alternatives(space, regions, {{1, 3}, 0}, {{7, 3}, 0}, 4.5)
                  .Next()
                  .empty());
}

}  // namespace
}  // namespace treeline::planning
