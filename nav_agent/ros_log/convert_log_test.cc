// An agent's log to MCAP and back; and what others record.
#include "nav_agent/ros_log/convert_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "common/base/file.h"
#include "common/base/testing_folder.h"
#include "common/image/decode.h"
#include "common/ros2/bag/open_bag.h"
#include "common/ros2/bag/testing_bags.h"
#include "common/ros2/conversions/geometry_values.h"
#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/nav_messages.h"
#include "common/ros2/messages/sensor_messages.h"

namespace treeline::ros_log {
namespace {

using recording::LogEntry;
using ::testing::Contains;
using ::testing::HasSubstr;

base::MonotonicTime At(int milliseconds) {
  return base::MonotonicTime(std::chrono::milliseconds(milliseconds));
}

std::string DepthPng() {
  return image::EncodeDepthPng(
             {.width = 4, .height = 2, .values = {0, 1, 2, 3, 400, 500, 6, 7}})
      .value();
}

// A robot that differs from the default in all that is told.
core::RobotModel Robot() {
  core::RobotModel robot;
  robot.front_m = 0.4;
  robot.wheel_track_m = 0.61;
  robot.wheel_radius_m = 0.17;
  robot.base_from_laser = {geometry::Rotation3::FromAxisAngle({0, 0, 0.25}),
                           {0.1, 0.02, 0.4}};
  return robot;
}

camera::RgbdCalibration Calibration() {
  camera::RgbdCalibration calibration;
  calibration.color =
      *camera::Camera::Parse("OPENCV,525,526,320,240,0.1,0,0,0.01", 640, 480);
  calibration.depth =
      *camera::Camera::Parse("PINHOLE,580,581,319,239", 640, 480);
  calibration.color_from_depth.translation = {0.025, 0, 0};
  return calibration;
}

std::vector<LogEntry> Entries() {
  std::vector<LogEntry> entries = {
      recording::LogInformation{"a test"},
      core::RangeSensorInfo{.angle_min_rad = -2,
                            .angle_increment_rad = 0.25,
                            .beams = 3,
                            .range_min_m = 0.125,
                            .range_max_m = 30,
                            .beam_interval_s = 0.0009765625,
                            .scan_interval_s = 0.03125},
      Calibration(), Robot()};
  for (int i = 0; i < 50; ++i) {
    entries.emplace_back(
        core::LaserScan{.stamp = At(25 * i + 1),
                        .ranges_m = {1.5f + static_cast<float>(i) / 2,
                                     core::kNoReturn, core::kTooNear},
                        .intensities = {100, 0, static_cast<uint16_t>(i)}});
    entries.emplace_back(core::BaseReading{.stamp = At(25 * i + 2),
                                           .left_wheel_m = 0.01 * i,
                                           .right_wheel_m = 0.013 * i,
                                           .forward_mps = 0.4,
                                           .yaw_rate_radps = 0.2,
                                           .pitch_rad = 0.01 * std::sin(i),
                                           .roll_rad = -0.02,
                                           .pitch_rate_radps = 0.5,
                                           .roll_rate_radps = 0.25,
                                           .battery_v = 24.5,
                                           .motors_enabled = i % 2 == 0});
    entries.emplace_back(recording::LogTruePose{
        At(25 * i + 3), {.rotation = {}, .translation = {0.01 * i, 2, 3}}});
    if (i % 10 == 0) {
      entries.emplace_back(recording::LogFrame{
          .stamp = At(25 * i + 4),
          .sequence = i / 10,
          .color = image::EncodeJpeg(
                       {.width = 2, .height = 1, .rgb = {1, 2, 3, 4, 5, 6}}, 90)
                       .value(),
          .depth = i == 20 ? "" : DepthPng()});
    }
  }
  entries.emplace_back(recording::LogEvent{At(2000), "collision: wall"});
  entries.emplace_back(recording::LogCommand{At(2001), {0.5, -0.25}});
  return entries;
}

template <typename T>
std::vector<T> Only(const std::vector<LogEntry>& entries) {
  std::vector<T> only;
  for (const LogEntry& entry : entries) {
    if (const T* value = std::get_if<T>(&entry)) only.push_back(*value);
  }
  return only;
}

class ConvertLogTest : public ::testing::Test {
 protected:
  std::string WriteLog(const std::vector<LogEntry>& entries) {
    std::string bytes = recording::AgentLogHeader();
    for (const LogEntry& entry : entries) {
      bytes += recording::EncodeLogRecord(entry);
    }
    const std::string path = folder_.Path("in.tlog");
    EXPECT_TRUE(base::WriteNewFile(path, bytes).ok());
    return path;
  }
  static std::vector<LogEntry> ReadLog(const std::string& path) {
    auto reader = recording::AgentLogReader::Open(path);
    EXPECT_TRUE(reader.ok()) << reader.status();
    std::vector<LogEntry> entries;
    while (auto entry = reader->Next()) entries.push_back(*std::move(entry));
    return entries;
  }
  // There and back again.
  std::vector<LogEntry> RoundTrip(const std::vector<LogEntry>& entries,
                                  mcap::Compression compression) {
    ConvertOptions options;
    options.compression = compression;
    const auto there =
        ConvertLog(WriteLog(entries), folder_.Path("a.mcap"), options);
    EXPECT_TRUE(there.ok()) << there.status();
    EXPECT_EQ(there->from, "agent log");
    const auto back =
        ConvertLog(folder_.Path("a.mcap"), folder_.Path("out.tlog"), {});
    EXPECT_TRUE(back.ok()) << back.status();
    EXPECT_EQ(back->from, "recording of ROS");
    return ReadLog(folder_.Path("out.tlog"));
  }

  const base::TestingFolder folder_;
};

TEST_F(ConvertLogTest, WhatBothCarryComesBackFromMcap) {
  const std::vector<LogEntry> in = Entries();
  const std::vector<LogEntry> out = RoundTrip(in, mcap::Compression::kLz4);

  // ---- exactly ----
  EXPECT_EQ(Only<recording::LogInformation>(out),
            Only<recording::LogInformation>(in));
  EXPECT_EQ(Only<core::RangeSensorInfo>(out), Only<core::RangeSensorInfo>(in));
  EXPECT_EQ(Only<camera::RgbdCalibration>(out),
            Only<camera::RgbdCalibration>(in));
  const auto same = [&]<typename T>(const T* /*of*/) {
    const std::vector<T> a = Only<T>(in);
    const std::vector<T> b = Only<T>(out);
    ASSERT_EQ(b.size(), a.size());
    for (size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(recording::EncodeLogRecord(b[i]),
                recording::EncodeLogRecord(a[i]))
          << i;
    }
  };
  same(static_cast<const core::LaserScan*>(nullptr));
  same(static_cast<const recording::LogTruePose*>(nullptr));
  same(static_cast<const recording::LogFrame*>(nullptr));
  same(static_cast<const recording::LogEvent*>(nullptr));
  same(static_cast<const recording::LogCommand*>(nullptr));
  const auto robots = Only<core::RobotModel>(out);
  ASSERT_EQ(robots.size(), 1U);
  EXPECT_EQ(robots[0].front_m, Robot().front_m);
  EXPECT_EQ(robots[0].wheel_track_m, Robot().wheel_track_m);
  EXPECT_LT(
      geometry::ErrorBetween(robots[0].base_from_laser, Robot().base_from_laser)
          .rotation_rad,
      1e-12);
  EXPECT_EQ(robots[0].base_from_laser.translation,
            Robot().base_from_laser.translation);
  EXPECT_LT(geometry::ErrorBetween(robots[0].base_from_camera,
                                   Robot().base_from_camera)
                .translation_m,
            1e-12);

  // ---- to rounding: the wheels in radians, tilt as a quaternion ----
  const auto a = Only<core::BaseReading>(in);
  const auto b = Only<core::BaseReading>(out);
  ASSERT_EQ(b.size(), a.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(b[i].stamp, a[i].stamp);
    EXPECT_NEAR(b[i].left_wheel_m, a[i].left_wheel_m, 1e-14);
    EXPECT_NEAR(b[i].right_wheel_m, a[i].right_wheel_m, 1e-14);
    EXPECT_EQ(b[i].forward_mps, a[i].forward_mps);
    EXPECT_EQ(b[i].yaw_rate_radps, a[i].yaw_rate_radps);
    EXPECT_NEAR(b[i].pitch_rad, a[i].pitch_rad, 1e-14);
    EXPECT_NEAR(b[i].roll_rad, a[i].roll_rad, 1e-14);
    EXPECT_EQ(b[i].pitch_rate_radps, a[i].pitch_rate_radps);
    EXPECT_EQ(b[i].roll_rate_radps, a[i].roll_rate_radps);
    EXPECT_EQ(b[i].battery_v, a[i].battery_v);
    EXPECT_EQ(b[i].motors_enabled, a[i].motors_enabled);
  }
}

TEST_F(ConvertLogTest, TheMcapHasTheTopicsThatToolsLookFor) {
  ASSERT_TRUE(
      base::WriteNewFile(folder_.Path("t.txt"), "1 1 2 0 0 0 0 1\n").ok());
  ConvertOptions options;
  options.trajectory = folder_.Path("t.txt");
  ASSERT_TRUE(
      ConvertLog(WriteLog(Entries()), folder_.Path("a.mcap"), options).ok());
  auto bag = bag::OpenBag(folder_.Path("a.mcap"));
  ASSERT_TRUE(bag.ok());
  std::vector<std::pair<std::string, std::string>> topics;
  for (const bag::BagTopic& topic : (*bag)->topics()) {
    topics.emplace_back(topic.name, topic.type);
  }
  for (const auto& [name, type] :
       std::vector<std::pair<std::string, std::string>>{
           {"/scan", "sensor_msgs/msg/LaserScan"},
           {"/odom", "nav_msgs/msg/Odometry"},
           {"/tf", "tf2_msgs/msg/TFMessage"},
           {"/tf_static", "tf2_msgs/msg/TFMessage"},
           {"/camera/color/image_raw/compressed",
            "sensor_msgs/msg/CompressedImage"},
           {"/camera/color/camera_info", "sensor_msgs/msg/CameraInfo"},
           {"/path", "nav_msgs/msg/Path"}}) {
    EXPECT_THAT(topics, Contains(std::pair(name, type)));
  }
}

// Depth in another unit than millimetres cannot be said in 16UC1.
TEST_F(ConvertLogTest, DepthInAnotherUnitIsRoundedAndSaid) {
  recording::LogFrame frame = Only<recording::LogFrame>(Entries())[0];
  frame.depth_unit_m = 0.0002;
  std::vector<LogEntry> entries = {Robot(), frame};
  const auto converted =
      ConvertLog(WriteLog(entries), folder_.Path("a.mcap"), {});
  ASSERT_TRUE(converted.ok()) << converted.status();
  EXPECT_THAT(converted->notes, Contains(HasSubstr("rounded to millimetres")));
  ASSERT_TRUE(
      ConvertLog(folder_.Path("a.mcap"), folder_.Path("b.tlog"), {}).ok());
  const auto frames =
      Only<recording::LogFrame>(ReadLog(folder_.Path("b.tlog")));
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(image::DecodeDepthPng(frames[0].depth, 0.001)->values,
            (std::vector<uint16_t>{0, 0, 0, 1, 80, 100, 1, 1}));
}

// A robot of somebody else's: /front/scan, /wheels, and nothing of ours. As
// ROS 1 records it, too.
class ForeignBagTest : public ConvertLogTest {
 protected:
  static std::vector<bag::TestingMessage> Recording() {
    std::vector<bag::TestingMessage> recording;
    const auto header = [](int64_t time_ns, const char* frame) {
      return messages::Header{messages::TimeOf(time_ns), frame};
    };
    messages::TransformStamped mount;
    mount.header = header(1'000'000'000, "base_footprint");
    mount.child_frame_id = "front_laser";
    mount.transform.translation.x = 0.5;
    recording.push_back(bag::Recorded("/tf_static", 1'000'000'000,
                                      messages::TFMessage{{mount}}));
    for (int i = 0; i < 10; ++i) {
      const int64_t time_ns = 2'000'000'000 + int64_t{100'000'000} * i;
      messages::Odometry odometry;
      odometry.header = header(time_ns, "odom");
      odometry.child_frame_id = "base_footprint";
      odometry.pose.pose.position.x = 0.05 * i;
      recording.push_back(bag::Recorded("/wheels", time_ns, odometry));
      messages::LaserScan scan;
      scan.header = header(time_ns + 1000, "front_laser");
      scan.angle_increment = 0.5;
      scan.range_max = 10;
      scan.ranges = {1, 2, 99};
      recording.push_back(bag::Recorded("/front/scan", time_ns + 1000, scan));
    }
    return recording;
  }

  void ExpectRead(const std::string& path) {
    const auto converted = ConvertLog(path, folder_.Path("b.tlog"), {});
    ASSERT_TRUE(converted.ok()) << converted.status();
    EXPECT_THAT(converted->notes,
                Contains(HasSubstr("those of the default robot")));
    const auto entries = ReadLog(folder_.Path("b.tlog"));
    const auto readings = Only<core::BaseReading>(entries);
    ASSERT_EQ(readings.size(), 10U);
    EXPECT_NEAR(readings[9].left_wheel_m, 0.45, 1e-9);
    EXPECT_NEAR(readings[9].right_wheel_m, 0.45, 1e-9);
    EXPECT_NEAR(readings[9].forward_mps, 0.5, 1e-9);
    const auto scans = Only<core::LaserScan>(entries);
    ASSERT_EQ(scans.size(), 10U);
    EXPECT_EQ(scans[3].ranges_m, (std::vector<float>{1, 2, core::kNoReturn}));
    const auto robots = Only<core::RobotModel>(entries);
    ASSERT_EQ(robots.size(), 1U);
    EXPECT_EQ(robots[0].base_from_laser.translation,
              (geometry::Vec3{0.5, 0, 0}));
  }
};

TEST_F(ForeignBagTest, ScansAndOdometryOfOthersAreRead) {
  bag::WriteBagFolder(Recording(), "sqlite3", folder_.Path("walk"));
  ExpectRead(folder_.Path("walk"));
}

TEST_F(ForeignBagTest, ThoseOfRos1Too) {
  bag::WriteRos1Bag(Recording(), "lz4", true, folder_.Path("walk.bag"));
  ExpectRead(folder_.Path("walk.bag"));
}

TEST_F(ForeignBagTest, ATopicThatIsNotThereIsAnErrorAndLeavesNoFile) {
  bag::WriteMcapBag(Recording(), "", folder_.Path("walk.mcap"));
  ConvertOptions options;
  options.bag.scan_topic = "/nowhere";
  const auto converted =
      ConvertLog(folder_.Path("walk.mcap"), folder_.Path("b.tlog"), options);
  EXPECT_THAT(std::string(converted.status().message()),
              AllOf(HasSubstr("there is no topic /nowhere"),
                    HasSubstr("/front/scan: 10 of sensor_msgs/msg/LaserScan")));
  EXPECT_FALSE(std::filesystem::exists(folder_.Path("b.tlog")));
}

TEST_F(ForeignBagTest, ARecordingThatBreaksOffSaysSo) {
  bag::WriteMcapBag(Recording(), "", folder_.Path("walk.mcap"));
  const auto bytes = base::ReadFile(folder_.Path("walk.mcap"));
  ASSERT_TRUE(bytes.ok());
  // Without its last chunk's end, with its first record alone.
  const auto read = [this, &bytes](size_t size, const std::string& name) {
    EXPECT_TRUE(
        base::WriteNewFile(folder_.Path(name), bytes->substr(0, size)).ok());
    return ConvertLog(folder_.Path(name), folder_.Path(name + ".tlog"), {});
  };
  const auto whole = read(bytes->size(), "whole.mcap");
  ASSERT_TRUE(whole.ok()) << whole.status();
  EXPECT_THAT(whole->notes, Not(Contains(HasSubstr("was not closed"))));
  const auto cut = read(bytes->size() - 20, "cut.mcap");
  ASSERT_TRUE(cut.ok()) << cut.status();
  EXPECT_THAT(cut->notes, Contains(HasSubstr("was not closed")));
  EXPECT_EQ(cut->entries, whole->entries);
  EXPECT_THAT(std::string(read(8, "head.mcap").status().message()),
              HasSubstr("no topics at all"));
}

TEST_F(ForeignBagTest, AsATemporaryLogThatGoesAway) {
  bag::WriteMcapBag(Recording(), "", folder_.Path("walk.mcap"));
  std::string path;
  {
    const auto log = AsAgentLog::Open(folder_.Path("walk.mcap"), false);
    ASSERT_TRUE(log.ok()) << log.status();
    path = log->path();
    EXPECT_EQ(Only<core::LaserScan>(ReadLog(path)).size(), 10U);
  }
  EXPECT_FALSE(std::filesystem::exists(path));
  const auto other = AsAgentLog::Open(WriteLog(Entries()), false);
  ASSERT_TRUE(other.ok());
  EXPECT_EQ(other->path(), folder_.Path("in.tlog"));
}

TEST_F(ConvertLogTest, ACorrectedLogIsATemporaryOneToo) {
  core::RobotModel robot = Robot();
  robot.wheel_track_m = 0.7;
  const recording::LogCorrection correction = {
      .sensors = {.left_scale = 0.5, .laser_delay_s = 0.1}, .robot = robot};
  const std::string original = WriteLog(Entries());
  const auto log = AsAgentLog::Open(original, true, correction);
  ASSERT_TRUE(log.ok()) << log.status();
  EXPECT_NE(log->path(), original);
  const std::vector<LogEntry> before = ReadLog(original);
  const std::vector<LogEntry> after = ReadLog(log->path());
  const auto old_scans = Only<core::LaserScan>(before);
  const auto scans = Only<core::LaserScan>(after);
  ASSERT_EQ(scans.size(), old_scans.size());
  EXPECT_EQ(old_scans[0].stamp - scans[0].stamp,
            std::chrono::milliseconds(100));
  const auto old_readings = Only<core::BaseReading>(before);
  const auto readings = Only<core::BaseReading>(after);
  ASSERT_EQ(readings.size(), old_readings.size());
  EXPECT_DOUBLE_EQ(readings.back().left_wheel_m,
                   old_readings.back().left_wheel_m / 2);
  for (const core::RobotModel& told : Only<core::RobotModel>(after)) {
    EXPECT_EQ(told.wheel_track_m, 0.7);
  }
}

TEST_F(ConvertLogTest, ALaserLogHasNothingToCorrect) {
  const std::string path = folder_.Path("drive.log");
  ASSERT_TRUE(
      base::WriteNewFile(path,
                         "FLASER 3 1.0 2.0 3.0 0 0 0 0 0 0 1.0 host 1.0\n"
                         "FLASER 3 1.0 2.0 3.0 0 0 0 0 0 0 2.0 host 2.0\n")
          .ok());
  const auto log = AsAgentLog::Open(
      path, true, {.sensors = {.left_scale = 0.5}, .robot = {}});
  EXPECT_EQ(log.status().code(), absl::StatusCode::kInvalidArgument)
      << log.status();
}

TEST_F(ConvertLogTest, ACarmenLogBecomesMcap) {
  recording::LaserLog log;
  log.laser = {.angle_min_rad = -1.5,
               .angle_increment_rad = 1.5,
               .beams = 3,
               .range_min_m = 0.02,
               .range_max_m = 80};
  log.base_from_laser = {{0.25, 0}, 0};
  for (int i = 0; i < 5; ++i) {
    log.scans.push_back(
        {.stamp = recording::RecordingTime(std::chrono::milliseconds(100 * i)),
         .odom_from_base = {{0.1 * i, 0}, 0},
         .ranges_m = {1, 2, 3}});
  }
  ASSERT_TRUE(base::WriteNewFile(folder_.Path("in.log"),
                                 recording::FormatCarmenLog(log))
                  .ok());
  const auto there =
      ConvertLog(folder_.Path("in.log"), folder_.Path("a.mcap"), {});
  ASSERT_TRUE(there.ok()) << there.status();
  EXPECT_EQ(there->from, "laser log");
  ASSERT_TRUE(
      ConvertLog(folder_.Path("a.mcap"), folder_.Path("b.tlog"), {}).ok());
  const auto entries = ReadLog(folder_.Path("b.tlog"));
  EXPECT_EQ(Only<core::LaserScan>(entries).size(), 5U);
  const auto readings = Only<core::BaseReading>(entries);
  ASSERT_EQ(readings.size(), 5U);
  EXPECT_NEAR(readings[4].left_wheel_m, 0.4, 1e-9);
  EXPECT_NEAR(Only<core::RobotModel>(entries)[0].base_from_laser.translation.x,
              0.25, 1e-6);
}

TEST_F(ConvertLogTest, WhatIsThereIsNotOverwritten) {
  const std::string log = WriteLog(Entries());
  EXPECT_TRUE(absl::IsAlreadyExists(ConvertLog(log, log, {}).status()));
}

}  // namespace
}  // namespace treeline::ros_log
