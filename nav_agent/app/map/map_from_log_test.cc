// A drive in a box becomes a map bundle.
#include "nav_agent/app/map/map_from_log.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <variant>

#include "common/base/clock.h"
#include "common/base/file.h"
#include "common/camera/calibration_json.h"
#include "common/dataset/dataset.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/app/map/testing_drive.h"
#include "nav_agent/app/map/trajectory_files.h"
#include "nav_agent/recording/agent_log.h"
#include "nav_agent/ros_log/convert_log.h"

namespace treeline::map_app {
namespace {

using ::testing::HasSubstr;

class MapLogTest : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  MapLogOptions Options() const {
    MapLogOptions options;
    options.map.folder = bundle_;
    options.map.overwrite = true;
    options.drive.slam.synchronous = true;
    return options;
  }

  const std::string folder_ =
      testing::TempDir() + "/map-log-" + std::to_string(getpid());
  const std::string log_ = folder_ + "/drive.tlog";
  const std::string bundle_ = folder_ + "/box";
};

TEST_F(MapLogTest, ANameThatNoSceneMayHaveIsRefusedBeforeAnythingIsDone) {
  RecordBoxDrive(log_, {});
  MapLogOptions options = Options();
  options.map.folder = folder_ + "/first floor";
  const absl::Status status = MapLog(log_, options).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("'first floor'"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("--name"));
  EXPECT_FALSE(std::filesystem::exists(options.map.folder));

  options.map.name = "first-floor";
  EXPECT_TRUE(options.map.Validate().ok());
}

// A clock that stands: what is left out for it is the reason, and is told.
TEST_F(MapLogTest, WhatWasLeftOutIsToldWhereThereIsNoMapForIt) {
  const std::string moving = folder_ + "/moving.tlog";
  RecordBoxDrive(moving, {.frames_hz = 0});
  {
    const base::SteadyClock clock;
    auto reader = *recording::AgentLogReader::Open(moving);
    const auto writer =
        *recording::AgentLogWriter::Open(log_, /*append=*/false, clock);
    while (auto entry = reader.Next()) {
      if (auto* scan = std::get_if<core::LaserScan>(&*entry)) scan->stamp = {};
      ASSERT_TRUE(writer->Write(*entry).ok());
    }
    ASSERT_TRUE(writer->Flush().ok());
  }
  const absl::Status status = MapLog(log_, Options()).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), HasSubstr("too little for a map"));
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("scans were left out because"));
}

TEST_F(MapLogTest, FramesMakeAMapInSpaceAndARecordingToTrainOn) {
  RecordBoxDrive(log_, {});
  const auto result = MapLog(log_, Options());
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_TRUE(result->warnings.empty());
  // Nothing is noisy, and one voxel is 5 cm.
  ASSERT_TRUE(result->rmse_m.has_value());
  EXPECT_LT(*result->rmse_m, 0.01);
  EXPECT_EQ(result->summary.levels, 1);
  // Two in a second, for 12 seconds, begun with one.
  EXPECT_NEAR(result->summary.keyframes, 25, 1);

  const auto bundle = map_bundle::LoadMapBundle(bundle_);
  ASSERT_TRUE(bundle.ok()) << bundle.status();
  EXPECT_EQ(bundle->manifest.name, "box");
  const octree::VoxelMap& voxels = bundle->voxels;
  EXPECT_EQ(voxels.At(voxels.IndexOf({1, 0, 0.6})), octree::Voxel::kFree);
  EXPECT_EQ(voxels.At(voxels.IndexOf({0, 0, 5})), octree::Voxel::kUnknown);
  // Walls where they are, within a voxel.
  const auto is_wall = [&voxels](geometry::Vec3 point, geometry::Vec3 out) {
    for (const double step : {-0.05, 0.0, 0.05}) {
      if (voxels.At(voxels.IndexOf(point + step * out)) ==
          octree::Voxel::kOccupied) {
        return true;
      }
    }
    return false;
  };
  EXPECT_TRUE(is_wall({kBoxX_m, 0.3, 0.8}, {1, 0, 0}));
  EXPECT_TRUE(is_wall({0.4, -kBoxY_m, 0.8}, {0, 1, 0}));
  const core::OccupancyGrid& level = bundle->levels.levels[0].grid;
  EXPECT_EQ(level.At(level.CellOf({2.2, 0.5})), core::Occupancy::kFree);
  EXPECT_NE(level.At(level.CellOf({kBoxX_m + 0.02, 0.5})),
            core::Occupancy::kFree);

  const std::string keyframes = bundle_ + "/keyframes";
  const auto calibration = camera::CalibrationFromJson(
      *base::ReadFile(keyframes + "/calibration.json"));
  ASSERT_TRUE(calibration.ok()) << calibration.status();
  const auto dataset =
      dataset::Dataset::Open({.uri = "7scenes:" + keyframes,
                              .color_camera = calibration->color.ToString(),
                              .depth_camera = calibration->depth.ToString()});
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  EXPECT_EQ(dataset->size(), result->summary.keyframes);
  // The first camera is where it is on the robot.
  EXPECT_LT(geometry::Norm(dataset->frame(0).world_from_camera->translation -
                           core::RobotModel{}.base_from_camera.translation),
            0.01);
  const auto trajectory = ReadTrajectory(bundle_);
  ASSERT_TRUE(trajectory.ok()) << trajectory.status();
  EXPECT_EQ(trajectory->size(), static_cast<size_t>(bundle->manifest.poses));
}

// The same drive as MCAP: same scans, wheels and pictures, same map.
TEST_F(MapLogTest, AnMcapFileOfTheDriveMakesTheSameMap) {
  RecordBoxDrive(log_, {});
  const auto straight = MapLog(log_, Options());
  ASSERT_TRUE(straight.ok()) << straight.status();
  const std::string trajectory =
      base::ReadFile(bundle_ + "/trajectory.txt").value();
  const std::string mcap = folder_ + "/drive.mcap";
  const auto converted = ros_log::ConvertLog(log_, mcap, {});
  ASSERT_TRUE(converted.ok()) << converted.status();
  const auto log = ros_log::AsAgentLog::Open(mcap, true);
  ASSERT_TRUE(log.ok()) << log.status();
  const auto result = MapLog(log->path(), Options());
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->summary.keyframes, straight->summary.keyframes);
  EXPECT_EQ(result->summary.levels, straight->summary.levels);
  ASSERT_TRUE(result->rmse_m.has_value());
  EXPECT_NEAR(*result->rmse_m, *straight->rmse_m, 1e-4);
  // As many poses, at the same times.
  const std::string again = base::ReadFile(bundle_ + "/trajectory.txt").value();
  EXPECT_EQ(std::ranges::count(again, '\n'),
            std::ranges::count(trajectory, '\n'));
}

TEST_F(MapLogTest, ALaserAloneMakesAPlan) {
  RecordBoxDrive(log_, {.seconds = 6, .frames_hz = 0});
  const auto result = MapLog(log_, Options());
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->summary.keyframes, 0);
  const auto bundle = map_bundle::LoadMapBundle(bundle_);
  ASSERT_TRUE(bundle.ok()) << bundle.status();
  ASSERT_EQ(bundle->levels.levels.size(), 1U);
  const core::OccupancyGrid& level = bundle->levels.levels[0].grid;
  EXPECT_EQ(level.At(level.CellOf({1.5, 0.5})), core::Occupancy::kFree);
  // The box is 6 x 5 m; all of it was seen.
  EXPECT_NEAR(static_cast<double>(result->summary.free_cells),
              4 * kBoxX_m * kBoxY_m / (0.05 * 0.05), 700);
}

// As a killed recorder leaves it, and with a hole.
TEST_F(MapLogTest, WhatIsLeftOfADamagedLogIsMapped) {
  RecordBoxDrive(log_, {.seconds = 8, .frames_hz = 1});
  std::string bytes = *base::ReadFile(log_);
  bytes.resize(bytes.size() - 1000);
  bytes[bytes.size() / 2] = static_cast<char>(~bytes[bytes.size() / 2]);
  ASSERT_TRUE(base::WriteFileAtomically(log_, bytes).ok());
  const auto result = MapLog(log_, Options());
  ASSERT_TRUE(result.ok()) << result.status();
  ASSERT_FALSE(result->warnings.empty());
  EXPECT_GT(result->drive.damaged_bytes, 0);
  EXPECT_TRUE(map_bundle::LoadMapBundle(bundle_).ok());
}

TEST_F(MapLogTest, TheSameLogMakesTheSameMap) {
  RecordBoxDrive(log_, {.seconds = 6, .frames_hz = 1});
  ASSERT_TRUE(MapLog(log_, Options()).ok());
  const std::string octomap = *base::ReadFile(bundle_ + "/octomap.bt");
  const std::string trajectory = *base::ReadFile(bundle_ + "/trajectory.txt");
  ASSERT_TRUE(MapLog(log_, Options()).ok());
  EXPECT_EQ(*base::ReadFile(bundle_ + "/octomap.bt"), octomap);
  EXPECT_EQ(*base::ReadFile(bundle_ + "/trajectory.txt"), trajectory);
}

TEST_F(MapLogTest, InterruptedItLeavesNoBundle) {
  RecordBoxDrive(log_, {.seconds = 6, .frames_hz = 1});
  std::stop_source stop;
  MapLogOptions options = Options();
  options.stop = stop.get_token();
  options.progress = [&stop](const char* phase, double part) {
    if (std::string(phase) == "fusing" && part > 0.5) stop.request_stop();
  };
  EXPECT_EQ(MapLog(log_, options).status().code(),
            absl::StatusCode::kCancelled);
  EXPECT_EQ(map_bundle::LoadMapBundle(bundle_).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

TEST_F(MapLogTest, WhatIsNoLogIsRefused) {
  ASSERT_TRUE(base::WriteFileAtomically(log_, "not a log").ok());
  EXPECT_EQ(MapLog(log_, Options()).status().code(),
            absl::StatusCode::kInvalidArgument);
  MapLogOptions options = Options();
  options.map.fusion.resolution_m = 0;
  const absl::Status refused = MapLog(log_, options).status();
  EXPECT_EQ(refused.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(refused.message()), HasSubstr("resolution"));
}

}  // namespace
}  // namespace treeline::map_app
