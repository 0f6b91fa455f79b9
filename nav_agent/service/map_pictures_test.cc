#include "nav_agent/service/map_pictures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "common/image/decode.h"
#include "nav_agent/service/testing_navigator.h"
#include "nav_agent/traversability/navigation_map.h"

namespace treeline::agent_service {
namespace {

float FloatAt(const std::string& bytes, size_t offset) {
  float value = 0;
  std::memcpy(&value, bytes.data() + offset, sizeof(value));
  return value;
}

uint32_t NumberAt(const std::string& bytes, size_t offset) {
  uint32_t number = 0;
  std::memcpy(&number, bytes.data() + offset, sizeof(number));
  return number;
}

uint32_t CountOf(const std::string& bytes) { return NumberAt(bytes, 4); }

TEST(MapPictures, TheTopRowIsTheNorth) {
  core::OccupancyGrid grid =
      core::OccupancyGrid::Filled(3, 2, 0.05, {}, core::Occupancy::kFree);
  grid.Set({0, 1}, core::Occupancy::kOccupied);
  grid.Set({2, 0}, core::Occupancy::kUnknown);
  const auto png = LevelPng(grid);
  ASSERT_TRUE(png.ok());
  const auto image = image::DecodeColor(*png, {});
  ASSERT_TRUE(image.ok()) << image.status();
  ASSERT_EQ(image->width, 3);
  ASSERT_EQ(image->height, 2);
  EXPECT_EQ(image->rgb[0], 0);
  EXPECT_EQ(image->rgb[3], 255);
  EXPECT_EQ(image->rgb[(3 + 2) * 3], 160);
}

TEST(MapPictures, HeightsAreOfTheSurfaceFromTheBottomRowOn) {
  traversability::TraversableLevel level;
  level.grid =
      core::OccupancyGrid::Filled(3, 2, 0.1, {}, core::Occupancy::kFree);
  level.height_m = {0, 1, 2, -0.5F, std::numeric_limits<float>::quiet_NaN(), 4};
  const std::string bytes = LevelHeights(level);
  ASSERT_EQ(bytes.size(), 12U + 6 * 4U);
  EXPECT_EQ(bytes.substr(0, 4), "TLVH");
  EXPECT_EQ(NumberAt(bytes, 4), 3U);
  EXPECT_EQ(NumberAt(bytes, 8), 2U);
  EXPECT_EQ(FloatAt(bytes, 12), 0.05F);
  EXPECT_EQ(FloatAt(bytes, 12 + 4 * 2), 2.05F);
  EXPECT_EQ(FloatAt(bytes, 12 + 4 * 3), -0.45F);
  EXPECT_TRUE(std::isnan(FloatAt(bytes, 12 + 4 * 4)));
  EXPECT_EQ(FloatAt(bytes, 12 + 4 * 5), 4.05F);
}

TEST(MapPictures, HeightsAreThoseThatPosesHave) {
  const auto map = TwoLevelMap();
  const traversability::NavigationMap places =
      traversability::NavigationMap::Make(map->levels).value();
  const std::string bytes = LevelHeights(map->levels.levels[1]);
  const auto place = places.GroundOf({-0.8, -0.7}, 1);
  ASSERT_TRUE(place.has_value());
  EXPECT_EQ(FloatAt(bytes, 12), static_cast<float>(place->height_m));
}

TEST(MapPictures, WritesCentresOfVoxels) {
  const auto map = TwoLevelMap();
  const std::string bytes = OctomapBytes(map->voxels);
  ASSERT_EQ(bytes.size(), 12U + 2 * 12U);
  EXPECT_EQ(bytes.substr(0, 4), "TLVX");
  EXPECT_EQ(CountOf(bytes), 2U);
  EXPECT_EQ(FloatAt(bytes, 8), 0.5F);
  const geometry::Vec3 first = map->voxels.CenterOf({0, 0, 0});
  EXPECT_EQ(FloatAt(bytes, 12), static_cast<float>(first.x));
  EXPECT_EQ(FloatAt(bytes, 16), static_cast<float>(first.y));
  EXPECT_EQ(FloatAt(bytes, 20), static_cast<float>(first.z));
}

TEST(MapPictures, VoxelsLieWhereTheLevelsCellsDo) {
  const auto map = TwoLevelMap();
  const geometry::Rigid2 same = MapFromVoxels(map->voxels, map->levels);
  EXPECT_LT(geometry::Norm(same.translation), 1e-12);
  EXPECT_EQ(same.yaw_rad, 0);
  traversability::TraversableMap turned = map->levels;
  turned.levels[0].grid.map_from_grid = {.translation = {3, 4}, .yaw_rad = 0.5};
  const geometry::Rigid2 map_from_voxels = MapFromVoxels(map->voxels, turned);
  const geometry::Vec3 first = map->voxels.CenterOf({0, 0, 0});
  // Half a cell from the corner of the cells.
  const geometry::Vec2 in_map =
      turned.levels[0].grid.CenterInMap(core::CellIndex{0, 0});
  const std::string bytes = OctomapBytes(map->voxels, map_from_voxels);
  EXPECT_NEAR(FloatAt(bytes, 12), in_map.x, 1e-6);
  EXPECT_NEAR(FloatAt(bytes, 16), in_map.y, 1e-6);
  EXPECT_EQ(FloatAt(bytes, 20), static_cast<float>(first.z));
  EXPECT_EQ(MapFromVoxels(map->voxels, {}), geometry::Rigid2());
}

TEST(MapPictures, LeavesOutWhatNobodySees) {
  octree::VoxelMap voxels = octree::VoxelMap::Make(1, {}, {3, 3, 3}).value();
  for (int x = 0; x < 3; ++x) {
    for (int y = 0; y < 3; ++y)
      voxels.SetRun(x, y, 0, 3, octree::Voxel::kOccupied);
  }
  EXPECT_EQ(CountOf(OctomapBytes(voxels)), 26U);
}

}  // namespace
}  // namespace treeline::agent_service
