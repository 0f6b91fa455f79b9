#include "nav_agent/zones/zone_map.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::zones {
namespace {

using testing::HasSubstr;

constexpr double kPi = std::numbers::pi;
constexpr double kFull_mps = 0.6;

// Levels of 4 x 3 m in cells of 0.1 m, all free.
traversability::TraversableMap MapOf(int levels,
                                     const geometry::Rigid2& map_from_grid) {
  traversability::TraversableMap map;
  for (int i = 0; i < levels; ++i) {
    traversability::TraversableLevel level;
    level.grid = core::OccupancyGrid::Filled(40, 30, 0.1, map_from_grid,
                                             core::Occupancy::kFree);
    level.height_m.assign(level.grid.cells.size(),
                          3.0F * static_cast<float>(i));
    level.slope_rad.assign(level.grid.cells.size(), 0);
    level.clearance_m.assign(level.grid.cells.size(), 3);
    map.levels.push_back(std::move(level));
  }
  return map;
}

Zone Box(ZoneKind kind, double x0, double y0, double x1, double y1,
         const std::string& name = "box") {
  return {.name = name,
          .kind = kind,
          .level = 0,
          .corners_in_map = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}},
          .max_mps = 0.2};
}

std::shared_ptr<const ZoneMap> ZonesOf(
    const traversability::TraversableMap& map, const std::vector<Zone>& zones,
    const std::vector<ZoneMask>& masks = {}) {
  const auto made = ZoneMap::Make(map, zones, masks, kFull_mps);
  EXPECT_TRUE(made.ok()) << made.status();
  return made.value_or(nullptr);
}

TEST(ZoneMapTest, CellsAreThoseInsideAndThoseUnderASide) {
  const auto zones =
      ZonesOf(MapOf(2, {}), {Box(ZoneKind::kKeepOut, 1.03, 1.03, 2.07, 1.97)});
  EXPECT_TRUE(zones->has_keep_out());
  EXPECT_FALSE(zones->has_one_way());
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      EXPECT_EQ(zones->IsKeptOut(0, core::CellIndex{x, y}),
                x >= 10 && x <= 20 && y >= 10 && y <= 19)
          << x << " " << y;
      EXPECT_FALSE(zones->IsKeptOut(1, core::CellIndex{x, y}));
    }
  }
  EXPECT_FALSE(zones->IsKeptOut(0, core::CellIndex{-1, 15}));
  EXPECT_FALSE(zones->IsKeptOut(-1, core::CellIndex{15, 15}));
  EXPECT_FALSE(zones->IsKeptOut(2, core::CellIndex{15, 15}));
}

TEST(ZoneMapTest, AZoneThinnerThanACellHasCells) {
  const auto zones =
      ZonesOf(MapOf(1, {}), {Box(ZoneKind::kKeepOut, 0.51, 1.01, 3.49, 1.02)});
  for (int x = 5; x <= 34; ++x) {
    EXPECT_TRUE(zones->IsKeptOut(0, core::CellIndex{x, 10})) << x;
  }
  EXPECT_EQ(zones->kept_out_cells(), 30);
}

TEST(ZoneMapTest, ATurnedMapHasItsZonesWhereTheyWereDrawn) {
  const geometry::Rigid2 map_from_grid = {.translation = {-3, 7},
                                          .yaw_rad = 0.7};
  const auto map = MapOf(1, map_from_grid);
  Zone zone = Box(ZoneKind::kKeepOut, 1, 1, 2, 2);
  for (geometry::Vec2& corner : zone.corners_in_map) {
    corner = map_from_grid * corner;
  }
  const auto zones = ZonesOf(map, {zone});
  EXPECT_TRUE(zones->IsKeptOut(0, map_from_grid * geometry::Vec2{1.5, 1.5}));
  EXPECT_FALSE(zones->IsKeptOut(0, map_from_grid * geometry::Vec2{2.5, 1.5}));
  EXPECT_EQ(zones->KeepOutName(0, map_from_grid * geometry::Vec2{1.5, 1.5}),
            "box");
  EXPECT_EQ(zones->KeepOutName(0, map_from_grid * geometry::Vec2{2.5, 1.5}),
            "");
}

TEST(ZoneMapTest, WhereZonesOverlapAllOfThemHold) {
  Zone slow = Box(ZoneKind::kSpeed, 0, 0, 2, 3, "slow");
  Zone slower = Box(ZoneKind::kSpeed, 1, 0, 3, 3, "slower");
  slower.max_mps = 0.1;
  Zone east = Box(ZoneKind::kOneWay, 0, 0, 2, 3, "east");
  Zone north = Box(ZoneKind::kOneWay, 1, 0, 3, 3, "north");
  north.direction_rad = kPi / 2;
  const auto zones = ZonesOf(MapOf(1, {}), {slow, slower, east, north});
  EXPECT_FALSE(zones->has_keep_out());
  EXPECT_NEAR(zones->MaxSpeed_mps(0, {0.5, 1}), 0.2, 1e-6);
  EXPECT_NEAR(zones->MaxSpeed_mps(0, {1.5, 1}), 0.1, 1e-6);
  EXPECT_NEAR(zones->MaxSpeed_mps(0, {2.5, 1}), 0.1, 1e-6);
  EXPECT_TRUE(std::isinf(zones->MaxSpeed_mps(0, {3.5, 1})));
  EXPECT_TRUE(std::isinf(zones->MaxSpeed_mps(0, {-5, 1})));
  const auto forbids = [&](int x, double yaw_rad) {
    return zones->ForbidsHeading(0, {x, 10},
                                 {std::cos(yaw_rad), std::sin(yaw_rad)});
  };
  EXPECT_FALSE(forbids(5, 0));
  EXPECT_FALSE(forbids(5, -kPi / 2));
  EXPECT_TRUE(forbids(5, kPi));
  EXPECT_FALSE(forbids(15, kPi / 4));
  EXPECT_TRUE(forbids(15, -kPi / 4));
  EXPECT_TRUE(forbids(15, 3 * kPi / 4));
  EXPECT_FALSE(forbids(25, kPi));
  EXPECT_TRUE(forbids(25, -kPi / 2));
  EXPECT_FALSE(forbids(35, -kPi / 2));
}

TEST(ZoneMapTest, TheWayOutLeadsOverFreeGround) {
  traversability::TraversableMap map = MapOf(1, {});
  // A wall along the zone's left side, from the bottom to the top.
  for (int y = 0; y < 30; ++y) {
    map.levels[0].grid.Set({9, y}, core::Occupancy::kOccupied);
  }
  const auto zones = ZonesOf(map, {Box(ZoneKind::kKeepOut, 1.01, -1, 2.99, 4)});
  EXPECT_EQ(zones->WayOut_m(0, {30, 15}), 0);
  EXPECT_NEAR(zones->WayOut_m(0, {29, 15}), 0.1, 1e-5);
  // Not through the wall, which is nearer.
  EXPECT_NEAR(zones->WayOut_m(0, {10, 15}), 2.0, 1e-5);
}

ZoneMask MaskOf(double resolution_m, const geometry::Rigid2& map_from_grid,
                int width, int height, ZoneKind kind) {
  core::ValueGrid values = {.width = width,
                            .height = height,
                            .resolution_m = resolution_m,
                            .map_from_grid = map_from_grid,
                            .values = {}};
  values.values.assign(static_cast<size_t>(width * height), 0);
  ZoneMask mask;
  mask.name = "mask.yaml";
  mask.kind = kind;
  mask.is_percent = true;
  mask.values = std::make_shared<const core::ValueGrid>(std::move(values));
  return mask;
}

void Paint(ZoneMask& mask, int x, int y, uint8_t value) {
  core::ValueGrid values = *mask.values;
  values.values[static_cast<size_t>(y * values.width + x)] = value;
  mask.values = std::make_shared<const core::ValueGrid>(std::move(values));
}

TEST(ZoneMapTest, ACoarserTurnedMaskLiesWhereItsOriginSays) {
  // One cell of half a metre, turned by a quarter about (2, 1): it covers x
  // from 1.5 to 2, y from 1 to 1.5.
  ZoneMask mask = MaskOf(0.5, {.translation = {2, 1}, .yaw_rad = kPi / 2}, 2, 2,
                         ZoneKind::kKeepOut);
  Paint(mask, 0, 0, 100);
  const auto zones = ZonesOf(MapOf(1, {}), {}, {mask});
  EXPECT_EQ(zones->kept_out_cells(), 25);
  EXPECT_TRUE(zones->IsKeptOut(0, geometry::Vec2{1.55, 1.45}));
  EXPECT_FALSE(zones->IsKeptOut(0, geometry::Vec2{2.05, 1.45}));
  EXPECT_EQ(zones->KeepOutName(0, {1.75, 1.25}), "mask.yaml");
}

TEST(ZoneMapTest, NoCellOfAFinerMaskIsLost) {
  ZoneMask mask = MaskOf(0.02, {}, 200, 150, ZoneKind::kKeepOut);
  // A line of one pixel between two of the map's centres.
  for (int y = 0; y < 150; ++y) Paint(mask, 101, y, 100);
  const auto zones = ZonesOf(MapOf(1, {}), {}, {mask});
  for (int y = 0; y < 30; ++y) {
    EXPECT_TRUE(zones->IsKeptOut(0, core::CellIndex{20, y})) << y;
  }
  EXPECT_EQ(zones->kept_out_cells(), 30);
}

TEST(ZoneMapTest, ASpeedMaskOfPercents) {
  ZoneMask mask = MaskOf(0.1, {}, 10, 10, ZoneKind::kSpeed);
  Paint(mask, 5, 5, 50);
  const auto zones = ZonesOf(MapOf(1, {}), {}, {mask});
  EXPECT_NEAR(zones->MaxSpeed_mps(0, {0.55, 0.55}), 0.3, 1e-6);
  EXPECT_TRUE(std::isinf(zones->MaxSpeed_mps(0, {0.45, 0.55})));
}

// That is the map's own fault, and is said where the map is used.
TEST(ZoneMapTest, NoZonesAreNotToBlameForAMapWithoutGround) {
  auto map = MapOf(1, {});
  std::ranges::fill(map.levels[0].grid.cells, core::Occupancy::kOccupied);
  EXPECT_TRUE(ZoneMap::Make(map, {}, {}, kFull_mps).ok());
}

TEST(ZoneMapTest, WhatMakesNoSenseOnTheMapIsRefused) {
  const auto map = MapOf(1, {});
  const auto why = [&](const std::vector<Zone>& zones,
                       const std::vector<ZoneMask>& masks = {}) {
    return std::string(
        ZoneMap::Make(map, zones, masks, kFull_mps).status().message());
  };
  EXPECT_THAT(why({Box(ZoneKind::kKeepOut, 10, 10, 11, 11)}),
              HasSubstr("zone 'box' lies beside the map"));
  EXPECT_THAT(why({Box(ZoneKind::kKeepOut, -1, -1, 5, 5)}),
              HasSubstr("leave nothing to drive on"));
  ZoneMask mask = MaskOf(0.1, {}, 2, 2, ZoneKind::kKeepOut);
  mask.level = 3;
  EXPECT_THAT(why({}, {mask}), HasSubstr("is of level 3; the map has 0..0"));
}

TEST(ZoneMapTest, CornersFarAwayCostNothing) {
  const auto zones =
      ZonesOf(MapOf(1, {}), {Box(ZoneKind::kKeepOut, -1e5, -1e5, 2.01, 1e5)});
  EXPECT_EQ(zones->kept_out_cells(), 21 * 30);
}

TEST(ZoneMapTest, NoZonesAreEmpty) {
  EXPECT_TRUE(ZonesOf(MapOf(1, {}), {})->empty());
}

}  // namespace
}  // namespace treeline::zones
