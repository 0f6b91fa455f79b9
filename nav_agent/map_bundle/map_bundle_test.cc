#include "nav_agent/map_bundle/map_bundle.h"

#include <unistd.h>

#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "common/base/file.h"
#include "common/dataset/dataset.h"
#include "common/image/decode.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/core/map_file.h"
#include "nav_agent/map_bundle/keyframe_files.h"
#include "nav_agent/octomap/octree_file.h"
#include "nav_agent/traversability/level_files.h"

namespace treeline::map_bundle {
namespace {

using ::testing::HasSubstr;

class MapBundleTest : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // A floor of 4 x 4 m with free space above.
  static octree::VoxelMap Floor() {
    octree::VoxelMap map =
        *octree::VoxelMap::Make(0.05, {0, 0, -1}, {80, 80, 40});
    for (int y = 0; y < 80; ++y) {
      for (int x = 0; x < 80; ++x) {
        map.SetRun(x, y, 1, 40, octree::Voxel::kFree);
        map.Set({x, y, 0}, octree::Voxel::kOccupied);
      }
    }
    return map;
  }

  std::string Part(const char* name) const { return folder_ + "/" + name; }

  static MapBundleManifest Manifest() {
    return {.name = "attic", .source = "drive \"1\".tlog", .method = "laser"};
  }

  // A whole bundle.
  void WriteBundle() {
    ASSERT_TRUE(BeginMapBundle(folder_, /*overwrite=*/false).ok());
    const octree::VoxelMap voxels = Floor();
    ASSERT_TRUE(octree::WriteOctree(voxels, Part(kBundleOctomap)).ok());
    MapBundleManifest manifest = Manifest();
    const auto levels =
        traversability::ExtractTraversableMap(voxels, manifest.traversability);
    ASSERT_TRUE(levels.ok()) << levels.status();
    ASSERT_TRUE(
        traversability::WriteTraversableMap(
            *levels, manifest.traversability.max_slope_rad, Part(kBundleLevels))
            .ok());
    manifest.levels = static_cast<int>(levels->levels.size());
    const std::vector<dataset::TimedPose> trajectory = {{5, {}}};
    manifest.poses = 1;
    ASSERT_TRUE(WriteBundleTrajectory(folder_, trajectory).ok());
    ASSERT_TRUE(FinishMapBundle(folder_, manifest).ok());
  }

  const std::string folder_ =
      testing::TempDir() + "/map-bundle-" + std::to_string(getpid());
};

TEST_F(MapBundleTest, WhatIsWrittenIsRead) {
  WriteBundle();
  const auto bundle = LoadMapBundle(folder_);
  ASSERT_TRUE(bundle.ok()) << bundle.status();
  EXPECT_EQ(bundle->manifest.name, "attic");
  EXPECT_EQ(bundle->manifest.source, "drive \"1\".tlog");
  EXPECT_EQ(bundle->manifest.poses, 1);
  EXPECT_EQ(bundle->manifest.traversability.max_slope_rad,
            traversability::TraversabilityOptions{}.max_slope_rad);
  EXPECT_EQ(bundle->voxels, Floor());
  ASSERT_EQ(bundle->levels.levels.size(), 1U);
}

TEST_F(MapBundleTest, WhatSomebodyDrewInALevelHolds) {
  WriteBundle();
  const std::string path = Part(kBundleLevels) + "/level-0.yaml";
  core::OccupancyGrid grid = *core::ReadMap(path);
  const core::CellIndex middle{40, 40};
  ASSERT_EQ(grid.At(middle), core::Occupancy::kFree);
  grid.Set(middle, core::Occupancy::kOccupied);
  ASSERT_TRUE(core::WriteMap(grid, path).ok());
  const auto bundle = LoadMapBundle(folder_);
  ASSERT_TRUE(bundle.ok()) << bundle.status();
  EXPECT_EQ(bundle->levels.levels[0].grid.At(middle),
            core::Occupancy::kOccupied);
}

TEST_F(MapBundleTest, AnotherMapIsNotOverwrittenUnlessToldTo) {
  WriteBundle();
  ASSERT_TRUE(base::WriteFileAtomically(Part("notes.txt"), "mine").ok());
  const absl::Status refused = BeginMapBundle(folder_, /*overwrite=*/false);
  EXPECT_EQ(refused.code(), absl::StatusCode::kAlreadyExists);
  EXPECT_THAT(std::string(refused.message()), HasSubstr("--overwrite"));
  EXPECT_TRUE(BeginMapBundle(folder_, /*overwrite=*/true).ok());
  EXPECT_FALSE(std::filesystem::exists(Part(kBundleOctomap)));
  EXPECT_TRUE(std::filesystem::exists(Part("notes.txt")));
}

TEST_F(MapBundleTest, AnInterruptedOneSaysSo) {
  EXPECT_EQ(LoadMapBundle(folder_).status().code(),
            absl::StatusCode::kNotFound);
  WriteBundle();
  std::filesystem::remove(Part(kBundleManifest));
  const absl::Status half = LoadMapBundle(folder_).status();
  EXPECT_EQ(half.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(half.message()), HasSubstr("interrupted"));
}

TEST_F(MapBundleTest, AMissingPartIsNamed) {
  WriteBundle();
  std::filesystem::remove(Part(kBundleLevels) + "/level-0.yaml");
  const absl::Status lacks = LoadMapBundle(folder_).status();
  EXPECT_EQ(lacks.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(lacks.message()), HasSubstr("level-0.yaml"));
  // Nor can it be finished without.
  EXPECT_FALSE(FinishMapBundle(folder_, {.name = "a", .levels = 1}).ok());
}

TEST_F(MapBundleTest, ALevelOfAnotherSizeIsRefused) {
  WriteBundle();
  ASSERT_TRUE(core::WriteMap(core::OccupancyGrid::Filled(
                                 3, 3, 0.05, {}, core::Occupancy::kFree),
                             Part(kBundleLevels) + "/level-0.yaml")
                  .ok());
  const absl::Status status = LoadMapBundle(folder_).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), HasSubstr("3 x 3"));
}

TEST_F(MapBundleTest, BadManifestsAreRefusedWithTheirLine) {
  WriteBundle();
  const std::string good = *base::ReadFile(Part(kBundleManifest));
  ASSERT_TRUE(ParseMapBundleManifest(good, "b").ok());
  const auto with = [&good](const std::string& from, const std::string& to) {
    std::string text = good;
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    const auto parsed = ParseMapBundleManifest(text, "b");
    EXPECT_EQ(parsed.status().code(), absl::StatusCode::kInvalidArgument);
    return std::string(parsed.status().message());
  };
  EXPECT_THAT(with("version: 1", "version: 2"), HasSubstr("version 2"));
  EXPECT_THAT(with("name: attic", "name: ../attic"), HasSubstr("name"));
  EXPECT_THAT(with("keyframes: 0", "keyframes: -1"), HasSubstr("b:9"));
  EXPECT_THAT(with("levels: 1", "level: 1"), HasSubstr("levels"));
  EXPECT_THAT(with("of: base", "of: wheel"), HasSubstr("camera"));
  EXPECT_THAT(with("max_step_m: ", "max_step_m: 9"), HasSubstr("step"));
}

TEST_F(MapBundleTest, ALaserAloneMakesPlanarLevels) {
  core::OccupancyGrid ground = core::OccupancyGrid::Filled(
      10, 8, 0.05, {.translation = {-0.5, 0.2}}, core::Occupancy::kFree);
  ground.Set({9, 7}, core::Occupancy::kOccupied);
  const core::OccupancyGrid upper = core::OccupancyGrid::Filled(
      4, 4, 0.05, {.translation = {0, 0}}, core::Occupancy::kFree);
  const std::vector<core::OccupancyGrid> grids = {ground, upper};
  const std::vector<double> heights_m = {0, 3};
  const auto levels = PlanarLevels(grids, heights_m);
  ASSERT_TRUE(levels.ok()) << levels.status();
  ASSERT_EQ(levels->levels.size(), 2U);
  const core::OccupancyGrid& grid = levels->levels[0].grid;
  EXPECT_EQ(grid.width, 14);
  EXPECT_EQ(grid.height, 12);
  EXPECT_EQ(grid.At(grid.CellOf({-0.02, 0.57})), core::Occupancy::kOccupied);
  EXPECT_EQ(grid.At(grid.CellOf({0.1, 0.1})), core::Occupancy::kUnknown);
  EXPECT_EQ(levels->levels[1].grid.At(grid.CellOf({0.1, 0.1})),
            core::Occupancy::kFree);
  const auto voxels = PlanarVoxels(*levels, 0.33);
  ASSERT_TRUE(voxels.ok()) << voxels.status();
  EXPECT_EQ(voxels->CountOccupied(), 1);
  EXPECT_EQ(voxels->CountFree(), 79 + 16);
  EXPECT_EQ(voxels->At(voxels->IndexOf({-0.02, 0.57, 0.33})),
            octree::Voxel::kOccupied);
  EXPECT_EQ(voxels->At(voxels->IndexOf({0.1, 0.1, 3.33})),
            octree::Voxel::kFree);

  ASSERT_TRUE(BeginMapBundle(folder_, /*overwrite=*/false).ok());
  ASSERT_TRUE(octree::WriteOctree(*voxels, Part(kBundleOctomap)).ok());
  ASSERT_TRUE(
      traversability::WriteTraversableMap(*levels, 0.3, Part(kBundleLevels))
          .ok());
  ASSERT_TRUE(WriteBundleTrajectory(folder_, {}).ok());
  MapBundleManifest manifest = Manifest();
  manifest.levels = 2;
  manifest.planar_heights_m = heights_m;
  ASSERT_TRUE(FinishMapBundle(folder_, manifest).ok());
  const auto bundle = LoadMapBundle(folder_);
  ASSERT_TRUE(bundle.ok()) << bundle.status();
  EXPECT_EQ(bundle->levels.levels[0].grid.cells, grid.cells);
  EXPECT_EQ(bundle->levels.levels[1].height_m[0], 3);
  EXPECT_EQ(bundle->voxels, *voxels);
}

TEST_F(MapBundleTest, VoxelsOfPlanarLevelsHaveTheirUnknownMarginsToo) {
  core::OccupancyGrid ground = core::OccupancyGrid::Filled(
      9, 8, 0.05, {.translation = {-0.5, 0.2}}, core::Occupancy::kUnknown);
  ground.Set({3, 4}, core::Occupancy::kOccupied);
  ground.Set({5, 2}, core::Occupancy::kFree);
  const auto levels = PlanarLevels({&ground, 1}, std::vector<double>{0});
  ASSERT_TRUE(levels.ok()) << levels.status();
  const auto voxels = PlanarVoxels(*levels, 0.33);
  ASSERT_TRUE(voxels.ok()) << voxels.status();
  ASSERT_TRUE(BeginMapBundle(folder_, /*overwrite=*/false).ok());
  ASSERT_TRUE(octree::WriteOctree(*voxels, Part(kBundleOctomap)).ok());
  ASSERT_TRUE(
      traversability::WriteTraversableMap(*levels, 0.3, Part(kBundleLevels))
          .ok());
  ASSERT_TRUE(WriteBundleTrajectory(folder_, {}).ok());
  MapBundleManifest manifest = Manifest();
  manifest.levels = 1;
  manifest.planar_heights_m = {0};
  ASSERT_TRUE(FinishMapBundle(folder_, manifest).ok());
  const auto bundle = LoadMapBundle(folder_);
  ASSERT_TRUE(bundle.ok()) << bundle.status();
  EXPECT_EQ(bundle->voxels, *voxels);
}

TEST_F(MapBundleTest, KeyframesAreARecordingToTrainOn) {
  camera::RgbdCalibration calibration;
  calibration.color = *camera::Camera::Parse("PINHOLE,16,16,8,6", 16, 12);
  calibration.depth = calibration.color;
  calibration.pose_sensor = camera::RgbdSensor::kColor;
  calibration.color_from_depth.translation = {0.1, 0, 0};
  auto writer = KeyframeWriter::Create(Part(kBundleKeyframes), calibration);
  ASSERT_TRUE(writer.ok()) << writer.status();
  const std::string color = *image::EncodePng(
      {.width = 16, .height = 12, .rgb = std::vector<uint8_t>(576, 90)});
  // 5000 to the metre: 1.5 m, and one pixel that was not measured.
  image::DepthImage depth{.width = 16,
                          .height = 12,
                          .values = std::vector<uint16_t>(192, 7500),
                          .unit_m = 0.0002};
  depth.values[3] = 0;
  const geometry::Rigid3 map_from_camera{
      geometry::Rotation3::FromAxisAngle({0, 0, 1}), {1, 2, 3}};
  ASSERT_TRUE(
      writer
          ->Write(color, *image::EncodeDepthPng(depth), 0.0002, map_from_camera)
          .ok());
  EXPECT_EQ(writer->count(), 1);
  EXPECT_FALSE(
      writer->Write("no picture", *image::EncodeDepthPng(depth), 0.0002, {})
          .ok());
  const geometry::Rigid3 nowhere{
      {}, {std::numeric_limits<double>::quiet_NaN(), 0, 0}};
  EXPECT_FALSE(
      writer->Write(color, *image::EncodeDepthPng(depth), 0.0002, nowhere)
          .ok());

  const auto dataset =
      dataset::Dataset::Open({.uri = "7scenes:" + Part(kBundleKeyframes),
                              .color_camera = calibration.color.ToString(),
                              .depth_camera = calibration.depth.ToString()});
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  ASSERT_EQ(dataset->size(), 1);
  // The layout's poses are the depth camera's.
  EXPECT_LT(geometry::Norm(dataset->frame(0).world_from_camera->translation -
                           map_from_camera * geometry::Vec3{0.1, 0, 0}),
            1e-9);
  const auto read = image::DecodeDepthPng(
      *base::ReadFile(dataset->frame(0).depth_path), 0.001);
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(read->values[0], 1500);
  EXPECT_EQ(read->values[3], 0);
  EXPECT_EQ(KeyframeWriter::Create(Part(kBundleKeyframes), calibration)
                .status()
                .code(),
            absl::StatusCode::kAlreadyExists);
}

}  // namespace
}  // namespace treeline::map_bundle
