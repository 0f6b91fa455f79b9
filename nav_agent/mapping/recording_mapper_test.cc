#include "nav_agent/mapping/recording_mapper.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/dataset/trajectory_error.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/mapping/testing_plan.h"
#include "nav_agent/recording/agent_log.h"
#include "nav_agent/recording/laser_log.h"

namespace treeline::mapping {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr int kScans = 80;
constexpr double kForward_mps = 0.4;
constexpr double kTurn_radps = 0.15;

base::MonotonicTime At(int64_t milliseconds) {
  return base::MonotonicTime(std::chrono::milliseconds(1000 + milliseconds));
}

// Along an arc in a room of 9 x 7 m, from its lower left.
geometry::Rigid2 TruthAt(int64_t milliseconds) {
  const double angle_rad =
      1e-3 * kTurn_radps * static_cast<double>(milliseconds);
  const double radius_m = kForward_mps / kTurn_radps;
  return {
      {radius_m * std::sin(angle_rad), radius_m * (1 - std::cos(angle_rad))},
      angle_rad};
}

std::vector<TestWall> Room() {
  std::vector<TestWall> walls;
  AddBox({-2, -2}, {7, 5}, &walls);
  AddBox({4.5, -1.5}, {5.2, -0.6}, &walls);
  AddBox({1.0, 3.6}, {2.2, 4.1}, &walls);
  AddBox({-1.5, 1.2}, {-1.1, 2.4}, &walls);
  return walls;
}

core::RangeSensorInfo Laser() {
  core::RangeSensorInfo laser = TestLaser(20);

  laser.scan_interval_s = 0.1;
  return laser;
}

core::LaserScan ScanAt(int64_t milliseconds) {
  const core::RobotModel robot;
  const geometry::Vec3 mount = robot.base_from_laser.translation;
  return {.stamp = At(milliseconds),
          .ranges_m = CastScan(
              Room(),
              TruthAt(milliseconds) * geometry::Rigid2{{mount.x, mount.y}, 0},
              Laser(), 0.01, static_cast<uint64_t>(milliseconds)),
          .intensities = {}};
}

// Wheels that count 1 % too much, and once spin by 12 cm on the spot.
core::BaseReading ReadingAt(int64_t milliseconds) {
  const double s = 1e-3 * static_cast<double>(milliseconds);
  const double half_m =
      0.5 * kTurn_radps * s * core::RobotModel().wheel_track_m;
  const double spin_m = 0.12 * std::clamp((s - 3.0) / 0.4, 0.0, 1.0);
  core::BaseReading reading;
  reading.stamp = At(milliseconds);
  reading.left_wheel_m = 1.01 * (kForward_mps * s - half_m) + spin_m;
  reading.right_wheel_m = 1.01 * (kForward_mps * s + half_m) + spin_m;
  reading.yaw_rate_radps = kTurn_radps;
  return reading;
}

// What the robot would have written; one entry after another.
std::vector<recording::LogEntry> Entries() {
  std::vector<recording::LogEntry> entries = {
      recording::LogInformation{"a room"}, core::RobotModel(), Laser()};
  for (int i = 0; i < kScans; ++i) {
    for (int k = 0; k < 5; ++k) {
      const int64_t time = 100 * i + 20 * k;
      entries.emplace_back(ReadingAt(time));
      const geometry::Rigid2 truth = TruthAt(time);
      entries.emplace_back(recording::LogTruePose{
          .stamp = At(time),
          .world_from_base = {
              .rotation =
                  geometry::Rotation3::FromAxisAngle({0, 0, truth.yaw_rad}),
              .translation = {truth.translation.x, truth.translation.y, 0}}});
      if (k == 0) entries.emplace_back(ScanAt(100 * i + 10));
    }
  }
  return entries;
}

std::string Bytes(const std::vector<recording::LogEntry>& entries) {
  std::string bytes = recording::AgentLogHeader();
  for (const recording::LogEntry& entry : entries)
    bytes += recording::EncodeLogRecord(entry);
  return bytes;
}

absl::StatusOr<RecordingMap> Map(const std::string& bytes,
                                 RecordingMapOptions options = {}) {
  const std::string path =
      absl::StrCat(testing::TempDir(), "/drive_mapping_", getpid());
  std::ofstream(path, std::ios::binary) << bytes;
  options.slam.synchronous = true;
  auto mapping = MapRecording(path, options);
  unlink(path.c_str());
  return mapping;
}

// The scans' noise of 1 cm is averaged over 180 beams; a cell is 4 cm.
constexpr double kGood_m = 0.03;

constexpr dataset::TrajectoryScoreOptions kFromTheFirstPose = {
    .max_difference_s = 0,
    .alignment = dataset::TrajectoryAlignment::kFirstPoseUpright};

dataset::TrajectoryError Score(const RecordingMap& mapping) {
  const auto score = dataset::ScoreTrajectory(mapping.map_from_base,
                                              mapping.truth, kFromTheFirstPose);
  EXPECT_TRUE(score.ok()) << score.status();
  return score.ok() ? score->absolute : dataset::TrajectoryError{};
}

TEST(MapRecording, FollowsTheTruthBetterThanWheels) {
  int64_t told = 0;
  RecordingMapOptions options;
  options.progress = [&told](const RecordingMapProgress& progress) {
    told = progress.scans;
    EXPECT_GT(progress.part, 0);
    EXPECT_LE(progress.part, 1);
  };
  const auto mapping = Map(Bytes(Entries()), options);
  ASSERT_TRUE(mapping.ok()) << mapping.status();
  EXPECT_EQ(mapping->format, RecordingFormat::kAgentLog);
  EXPECT_THAT(mapping->map_from_base, SizeIs(kScans));
  EXPECT_EQ(mapping->map_from_base[3].time, 1'310'000'000);
  EXPECT_EQ(mapping->information, "a room");
  EXPECT_TRUE(mapping->robot.has_value());
  EXPECT_THAT(mapping->warnings, IsEmpty());
  EXPECT_GT(told, 0);
  const auto wheels = dataset::ScoreTrajectory(
      mapping->odom_from_base, mapping->truth, kFromTheFirstPose);
  ASSERT_TRUE(wheels.ok());
  EXPECT_GT(wheels->absolute.position_m.rmse, 2 * kGood_m);
  EXPECT_LT(Score(*mapping).position_m.rmse, kGood_m);
  // All of it on one floor.
  ASSERT_THAT(mapping->floors, SizeIs(1));
  EXPECT_EQ(mapping->floors[0].height_m, 0);
  const core::OccupancyGrid& grid = mapping->floors[0].grid;
  EXPECT_EQ(grid.AtOrUnknown(grid.CellOf({1, 0.2})), core::Occupancy::kFree);
}

TEST(MapRecording, LeavesOutWhatIsBrokenAndSaysSo) {
  std::vector<recording::LogEntry> entries = Entries();
  core::LaserScan few = ScanAt(2011);
  few.ranges_m.resize(90);
  core::LaserScan blind = ScanAt(2012);
  blind.ranges_m.assign(blind.ranges_m.size(), core::kInvalidRange);
  core::LaserScan early = ScanAt(500);
  core::BaseReading mad = ReadingAt(2012);
  mad.pitch_rad = std::nan("");
  core::BaseReading past = ReadingAt(100);
  core::RangeSensorInfo other = Laser();
  other.angle_increment_rad *= 0.5;
  std::vector<recording::LogEntry> broken(entries.begin(),
                                          entries.begin() + 230);
  // After the scan at 2010 ms, the first of these comes in order.
  broken.insert(broken.end(),
                {few, blind, early, mad, past, other, ScanAt(2020), Laser()});
  broken.insert(broken.end(), entries.begin() + 230, entries.end());
  std::string bytes = Bytes(broken);
  bytes.insert(bytes.size() / 2, "a few bytes that are nothing");
  bytes.resize(bytes.size() - 20);
  const auto mapping = Map(bytes);
  ASSERT_TRUE(mapping.ok()) << mapping.status();
  EXPECT_EQ(mapping->refused_scans, 3);
  EXPECT_EQ(mapping->refused_readings, 2);
  EXPECT_GT(mapping->damaged_bytes, 28);
  EXPECT_THAT(mapping->warnings, Contains(HasSubstr("number of beams")));
  EXPECT_THAT(mapping->warnings, Contains(HasSubstr("clock jumped back")));
  EXPECT_THAT(mapping->warnings, Contains(HasSubstr("not finite")));
  EXPECT_THAT(mapping->warnings, Contains(HasSubstr("another laser")));
  EXPECT_THAT(mapping->warnings, Contains(HasSubstr("damaged")));
  EXPECT_GE(mapping->map_from_base.size(), kScans - 2u);
  EXPECT_LT(Score(*mapping).position_m.rmse, kGood_m);
}

TEST(MapRecording, GivesUpScansThatTheWheelsDoNotCover) {
  std::vector<recording::LogEntry> entries = Entries();
  for (int i = 0; i < 10; ++i) entries.emplace_back(ScanAt(20000 + 100 * i));
  const auto mapping = Map(Bytes(entries));
  ASSERT_TRUE(mapping.ok()) << mapping.status();
  EXPECT_EQ(mapping->refused_scans, 10);
  EXPECT_THAT(mapping->warnings, Contains(HasSubstr("no wheel readings")));
  EXPECT_THAT(mapping->map_from_base, SizeIs(kScans));
}

template <typename T>
std::vector<recording::LogEntry> Without() {
  std::vector<recording::LogEntry> entries = Entries();
  std::erase_if(entries, [](const recording::LogEntry& entry) {
    return std::holds_alternative<T>(entry);
  });
  return entries;
}

TEST(MapRecording, NamesWhatIsMissing) {
  const auto message = [](const std::vector<recording::LogEntry>& entries) {
    const absl::Status status = Map(Bytes(entries)).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition) << status;
    return std::string(status.message());
  };
  EXPECT_THAT(message(Without<core::LaserScan>()), HasSubstr("no laser scans"));
  EXPECT_THAT(message(Without<core::BaseReading>()),
              HasSubstr("no wheel readings"));
  EXPECT_THAT(message(Without<core::RangeSensorInfo>()),
              HasSubstr("laser scanner"));
  EXPECT_THAT(message({}), HasSubstr("no laser scans"));
  EXPECT_TRUE(Map(Bytes(Without<core::RobotModel>())).ok());
  EXPECT_EQ(MapRecording("/nowhere/drive.tlog").status().code(),
            absl::StatusCode::kNotFound);
  EXPECT_EQ(Map("neither this nor that").status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(MapRecording, ReadsPublicLogsToo) {
  recording::LaserLog log;
  log.laser = TestLaser(20);
  for (int i = 0; i < kScans; ++i) {
    geometry::Rigid2 wheels = TruthAt(100 * i);
    wheels.translation = 1.04 * wheels.translation;
    log.scans.push_back(
        {.stamp = recording::RecordingTime(std::chrono::milliseconds(100 * i)),
         .odom_from_base = wheels,
         .ranges_m = CastScan(Room(), TruthAt(100 * i), log.laser, 0.01,
                              static_cast<uint64_t>(i))});
  }
  const auto mapping = Map(recording::FormatCarmenLog(log));
  ASSERT_TRUE(mapping.ok()) << mapping.status();
  EXPECT_EQ(mapping->format, RecordingFormat::kLaserLog);
  ASSERT_THAT(mapping->map_from_base, SizeIs(kScans));
  EXPECT_EQ(mapping->map_from_base.back().time, 7'900'000'000);
  const geometry::Vec3 end =
      mapping->map_from_base.back().world_from_camera.translation;
  const geometry::Vec2 truth = TruthAt(7900).translation;
  EXPECT_NEAR(end.x, truth.x, 2 * kGood_m);
  EXPECT_NEAR(end.y, truth.y, 2 * kGood_m);
  EXPECT_EQ(end.z, 0);
  EXPECT_THAT(mapping->floors, SizeIs(1));
}

TEST(MapRecording, TellsWhereScansMatchedNothing) {
  recording::LaserLog log;
  log.laser = TestLaser(20);
  for (int i = 0; i < kScans; ++i) {
    log.scans.push_back(
        {.stamp = recording::RecordingTime(std::chrono::milliseconds(100 * i)),
         .odom_from_base = TruthAt(100 * i),
         .ranges_m = CastScan(Room(), TruthAt(100 * i), log.laser, 0.01,
                              static_cast<uint64_t>(i))});
  }
  EXPECT_THAT(Map(recording::FormatCarmenLog(log))->warnings, IsEmpty());
  // For two seconds it sees nothing.
  for (size_t i = 30; i < 50; ++i) {
    log.scans[i].ranges_m.assign(181, core::kNoReturn);
  }
  const auto mapping = Map(recording::FormatCarmenLog(log));
  ASSERT_TRUE(mapping.ok()) << mapping.status();
  EXPECT_THAT(mapping->warnings, Contains(HasSubstr("matched nothing")));
  EXPECT_GT(mapping->statistics.unmatched_sigma_m, 0);
}

TEST(MapRecording, StopsWhenAskedTo) {
  std::stop_source stop;
  stop.request_stop();
  RecordingMapOptions options;
  options.stop = stop.get_token();
  EXPECT_EQ(Map(Bytes(Entries()), options).status().code(),
            absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace treeline::mapping
