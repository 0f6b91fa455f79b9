#include "nav_agent/app/localize/localization_run.h"

#include <unistd.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "simulation/runs/localize_world.h"
#include "simulation/runs/simulation_run.h"
#include "simulation/simulator/scenario_player.h"
#include "simulation/simulator/scenario_reader.h"

namespace treeline::localize_app {
namespace {

using testing::HasSubstr;

// The lab, and fifteen seconds in it: up and down its slope.
struct Lab {
  octree::VoxelMap voxels;
  traversability::TraversableMap levels;
  RecordedDrive drive;
};

const Lab& TheLab() {
  static const Lab lab = [] {
    const std::string path =
        absl::StrCat(testing::TempDir(), "/localization_run_", getpid());
    unlink(path.c_str());
    worlds::World world = *worlds::MakeWorld(
        "lab", {.with_people = false, .threads = 1, .paint = false});
    Lab made;
    made.voxels = *runs::VoxelsOfWorld(world, 0.05);
    made.levels = *traversability::ExtractTraversableMap(made.voxels);
    runs::SimulationRunOptions run;
    run.scenario = *simulator::ParseScenario(
        "world: lab\nseed: 4\npeople: false\nduration_s: 15\n", "test");
    run.tour = simulator::TourAction();
    run.record_path = path;
    run.scenario.options.start = *simulator::StartOf(run.scenario, world);
    auto simulator =
        *simulator::Simulator::Create(std::move(world), run.scenario.options);
    EXPECT_TRUE(runs::RunSimulation(*simulator, run, [](double) {}, {}).ok());
    made.drive = *ReadDrive(path);
    unlink(path.c_str());
    return made;
  }();
  return lab;
}

LocalizationMap LabMap() {
  LocalizationMap map;
  for (const traversability::TraversableLevel& level : TheLab().levels.levels) {
    map.grids.push_back(localization::LaserSlice(TheLab().voxels, level, 0.35));
  }
  map.levels = std::make_shared<const localization::LaserLevelMap>(
      *localization::LaserLevelMap::Make(TheLab().voxels, TheLab().levels));
  return map;
}

LocalizationRunOptions FromTruth() {
  const geometry::Rigid3 truth = *TheLab().drive.scans.front().world_from_base;
  const geometry::Vec3 ahead = truth.rotation * geometry::Vec3{1, 0, 0};
  LocalizationRunOptions options;
  options.initial_map_from_base = geometry::Rigid2{
      {truth.translation.x, truth.translation.y}, std::atan2(ahead.y, ahead.x)};
  options.initial_height_m = truth.translation.z;
  return options;
}

TEST(VoxelsOfWorld, IsOccupiedWhereSurfacesAreAndFreeOnTheTour) {
  const octree::VoxelMap& voxels = TheLab().voxels;
  const worlds::World world = *worlds::MakeWorld(
      "lab", {.with_people = false, .threads = 1, .paint = false});
  EXPECT_GT(voxels.CountOccupied(), 10000);
  for (const worlds::Float3& corner : world.tour) {
    const geometry::Vec3 above = {corner.x, corner.y, corner.z + 0.3};
    EXPECT_EQ(voxels.At(voxels.IndexOf(above)), octree::Voxel::kFree);
    // The floor is below its surface.
    const geometry::Vec3 below = {corner.x, corner.y, corner.z - 0.02};
    EXPECT_EQ(voxels.At(voxels.IndexOf(below)), octree::Voxel::kOccupied);
  }
  EXPECT_EQ(runs::VoxelsOfWorld(worlds::World(), 0.05).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(LocalizeDrive, IsWithinCentimetresOnSlopes) {
  const auto result =
      LocalizeDrive(LabMap(), TheLab().drive, FromTruth(), {}, {});
  ASSERT_TRUE(result.ok()) << result.status();
  ASSERT_TRUE(result->errors.has_value());
  EXPECT_LT(result->errors->position_m.rmse, 0.05);
  EXPECT_LT(result->errors->position_m.max, 0.2);
  // One degree, over fifteen seconds that begin with fifteen degrees of doubt.
  EXPECT_LT(result->errors->heading_rad.rmse, 0.0175);
  EXPECT_EQ(result->errors->right_level, 1);
  EXPECT_GT(result->agreement, 0.9);

  const auto json = nlohmann::json::parse(LocalizationJson(*result));
  EXPECT_EQ(json["poses"].size(), TheLab().drive.scans.size());
  EXPECT_EQ(json["errors"]["position_m"]["rmse"],
            result->errors->position_m.rmse);
}

TEST(LocalizeDrive, ManagesWithASliceAboveTheGroundOfOneLevel) {
  LocalizationMap flat = LabMap();
  flat.levels = nullptr;
  flat.grids.resize(1);
  const auto result = LocalizeDrive(flat, TheLab().drive, FromTruth(), {}, {});
  ASSERT_TRUE(result.ok()) << result.status();
  ASSERT_TRUE(result->errors.has_value());
  EXPECT_LT(result->errors->position_m.rmse, 0.1);
  EXPECT_GT(result->agreement, 0.9);
}

TEST(LocalizeDrive, NamesWhatIsWrong) {
  EXPECT_THAT(LocalizeDrive({}, TheLab().drive, {}, {}, {}).status().message(),
              HasSubstr("needs one map"));
  std::stop_source stopped;
  stopped.request_stop();
  EXPECT_EQ(LocalizeDrive(LabMap(), TheLab().drive, {}, {}, stopped.get_token())
                .status()
                .code(),
            absl::StatusCode::kCancelled);
  RecordedDrive wrong = TheLab().drive;
  wrong.scans[3].ranges_m.pop_back();
  EXPECT_THAT(
      LocalizeDrive(LabMap(), wrong, FromTruth(), {}, {}).status().message(),
      HasSubstr("a scan of 1080 beams; the sensor has 1081"));
}

TEST(LocalizeDrive, GoesOnWithScansOfNothing) {
  RecordedDrive blind = TheLab().drive;
  blind.scans.resize(40);
  for (DriveScan& scan : blind.scans) {
    scan.ranges_m.assign(scan.ranges_m.size(), core::kInvalidRange);
  }
  const auto result = LocalizeDrive(LabMap(), blind, FromTruth(), {}, {});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->agreement, 0);
  EXPECT_EQ(result->scans.size(), 40u);
}

}  // namespace
}  // namespace treeline::localize_app
