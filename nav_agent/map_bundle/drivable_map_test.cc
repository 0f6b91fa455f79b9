#include "nav_agent/map_bundle/drivable_map.h"

#include <filesystem>
#include <string>

#include "common/base/file.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::map_bundle {
namespace {

using testing::HasSubstr;

class DrivableMapTest : public testing::Test {
 protected:
  std::string Write(const std::string& name, absl::string_view bytes) const {
    const std::string path = (folder_ / name).string();
    EXPECT_TRUE(base::WriteFileAtomically(path, bytes).ok());
    return path;
  }
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  static std::string Told(const std::string& path) {
    return std::string(LoadDrivableMap(path).status().message());
  }

  std::filesystem::path folder_;
};

TEST_F(DrivableMapTest, AFlatMapIsOneLevelWhereItsOriginSays) {
  // Free, occupied and unknown; the row on top is the higher one.
  Write("hall.pgm", "P2 3 2 255 254 0 205 254 254 254\n");
  const auto map = LoadDrivableMap(Write(
      "hall.yaml",
      "image: hall.pgm\nresolution: 0.05\norigin: [-1.234, 5.671, 0.5]\n"));
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_EQ(map->name, "hall");
  EXPECT_EQ(map->warning, "");
  ASSERT_EQ(map->levels.levels.size(), 1U);
  const core::OccupancyGrid& grid = map->levels.levels[0].grid;
  // Exactly: no cell is moved to a multiple of the resolution.
  EXPECT_EQ(grid.map_from_grid,
            (geometry::Rigid2{.translation = {-1.234, 5.671}, .yaw_rad = 0.5}));
  EXPECT_EQ(grid.At({0, 0}), core::Occupancy::kFree);
  EXPECT_EQ(grid.At({1, 1}), core::Occupancy::kOccupied);
  EXPECT_EQ(grid.At({2, 1}), core::Occupancy::kUnknown);
  EXPECT_EQ(map->voxels.lowest().x, 0);
  EXPECT_EQ(map->voxels.size(), (octree::VoxelIndex{3, 2, 1}));
  EXPECT_EQ(map->voxels.At({1, 1, 0}), octree::Voxel::kOccupied);
  EXPECT_EQ(map->voxels.At({2, 1, 0}), octree::Voxel::kUnknown);
}

TEST_F(DrivableMapTest, KeysThatMapServerDoesNotKnowArePassedOverAndToldOf) {
  Write("m.pgm", "P2 2 1 255 254 0\n");
  const auto map = LoadDrivableMap(
      Write("m.yaml",
            "image: m.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n"
            "saved_by: me\ncost_translation_table: default\n"));
  ASSERT_TRUE(map.ok()) << map.status();
  EXPECT_THAT(map->warning, HasSubstr("saved_by, cost_translation_table"));
}

TEST_F(DrivableMapTest, UnknownGroundThatCountsAsFreeIsToldOf) {
  Write("m.pgm", "P2 2 2 255 254 0 205 205\n");
  const auto warning = [&](const std::string& more) {
    const auto map = LoadDrivableMap(
        Write("m.yaml",
              "image: m.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n" + more));
    return map.ok() ? map->warning : std::string(map.status().message());
  };
  EXPECT_EQ(warning("free_thresh: 0.196\n"), "");
  EXPECT_EQ(warning("mode: raw\n").find("205"), std::string::npos);
  EXPECT_THAT(warning("free_thresh: 0.25\n"),
              HasSubstr("50 % of its cells are of the grey that map_saver"));
}

TEST_F(DrivableMapTest, WhatIsNoMapIsToldWhatIsMeant) {
  Write("m.pgm", "P2 2 1 255 0 0\n");
  const std::string yaml =
      Write("m.yaml", "image: m.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n");
  EXPECT_THAT(Told(yaml), HasSubstr("none of its cells is free"));
  Write("layers.yaml", "layers: 3\n");
  const std::string beside = "is named by its YAML: " + yaml;
  EXPECT_THAT(Told((folder_ / "m.pgm").string()), HasSubstr(beside));
  EXPECT_THAT(Told((folder_ / "m").string()),
              HasSubstr("do you mean " + yaml + "?"));
  EXPECT_THAT(Told(folder_.string()), HasSubstr(beside));
  EXPECT_THAT(Told("/nowhere/house"),
              HasSubstr("'/nowhere/house' is no map; it must be the folder"));
  EXPECT_THAT(Told("/nowhere/m.posegraph"), HasSubstr("map_saver_cli"));
  EXPECT_THAT(Told("/nowhere/m.yaml"), HasSubstr("/nowhere/m.yaml"));
}

}  // namespace
}  // namespace treeline::map_bundle
