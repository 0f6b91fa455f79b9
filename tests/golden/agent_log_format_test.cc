// An agent log of each format version that was ever released is still read,
// and the current version is still written, byte for byte.
//
// If a change of the format is intended, raise kAgentLogVersion, add the next
// golden file, and keep the old ones readable.
#include <string>
#include <vector>

#include "common/base/file.h"
#include "gtest/gtest.h"
#include "nav_agent/recording/agent_log.h"

namespace treeline {
namespace {

std::string GoldenPath(int version) {
  return std::string(TREELINE_GOLDEN_FOLDER) + "/agent-log-v" +
         std::to_string(version) + ".bin";
}

base::MonotonicTime StampAt(int64_t nanoseconds) {
  return base::MonotonicTime(
      std::chrono::duration_cast<base::MonotonicTime::duration>(
          std::chrono::nanoseconds(nanoseconds)));
}

// One entry of each kind.
std::vector<recording::LogEntry> GoldenEntries() {
  core::RobotModel robot;
  robot.front_m = 0.25;
  robot.rear_m = 0.375;
  robot.half_width_m = 0.3125;
  robot.base_from_laser = {.rotation = {}, .translation = {0.25, 0, 0.5}};
  robot.base_from_camera = {.rotation = {.w = 0, .x = 1, .y = 0, .z = 0},
                            .translation = {0.125, 0, 1}};
  camera::RgbdCalibration calibration;
  calibration.color_from_depth.translation = {-0.025, 0, 0.0078125};
  calibration.pose_sensor = camera::RgbdSensor::kDepth;
  return {recording::LogInformation{"golden"},
          robot,
          core::RangeSensorInfo{.angle_min_rad = -0.5,
                                .angle_increment_rad = 0.5,
                                .beams = 3,
                                .range_min_m = 0.125,
                                .range_max_m = 30,
                                .beam_interval_s = 0.0009765625,
                                .scan_interval_s = 0.0234375},
          calibration,
          core::LaserScan{.stamp = StampAt(25000000),
                          .ranges_m = {1.5f, core::kNoReturn, core::kTooNear},
                          .intensities = {100, 0, 65535}},
          core::BaseReading{.stamp = StampAt(30000001),
                            .left_wheel_m = 1.25,
                            .right_wheel_m = -2,
                            .forward_mps = 0.5,
                            .yaw_rate_radps = -0.25,
                            .pitch_rad = 0.0625,
                            .roll_rad = -0.03125,
                            .pitch_rate_radps = 1,
                            .roll_rate_radps = -1,
                            .battery_v = 72,
                            .motors_enabled = false},
          recording::LogFrame{.stamp = StampAt(33333333),
                              .sequence = 7,
                              .depth_unit_m = 0.001,
                              .color = "colour",
                              .depth = "depth"},
          recording::LogTruePose{StampAt(40000000),
                                 {.rotation = {}, .translation = {1, 2, 3}}},
          recording::LogEvent{StampAt(41000000), "collision"},
          recording::LogCommand{StampAt(42000000), {0.5, -0.25}}};
}

TEST(AgentLogFormatTest, Version1IsRead) {
  auto reader = recording::AgentLogReader::Open(GoldenPath(1));
  ASSERT_TRUE(reader.ok()) << reader.status();
  for (const recording::LogEntry& expected : GoldenEntries()) {
    const auto entry = reader->Next();
    ASSERT_TRUE(entry.has_value());
    EXPECT_EQ(recording::EncodeLogRecord(*entry),
              recording::EncodeLogRecord(expected));
  }
  EXPECT_FALSE(reader->Next().has_value());
  EXPECT_EQ(reader->damaged_bytes(), 0);
}

TEST(AgentLogFormatTest, Version1IsWritten) {
  std::string bytes = recording::AgentLogHeader();
  for (const recording::LogEntry& entry : GoldenEntries())
    bytes += recording::EncodeLogRecord(entry);
  const auto golden = base::ReadFile(GoldenPath(1));
  ASSERT_TRUE(golden.ok()) << golden.status();
  EXPECT_TRUE(bytes == *golden);
  if (bytes != *golden) {
    ASSERT_TRUE(
        base::WriteFileAtomically(testing::TempDir() + "/agent-log.bin", bytes)
            .ok());
  }
}

}  // namespace
}  // namespace treeline
