#include "nav_agent/recording/log_correction.h"

#include <gtest/gtest.h>

#include <chrono>

namespace treeline::recording {
namespace {

using std::chrono::milliseconds;

constexpr core::SensorCorrection kSensors = {.left_scale = 0.5,
                                             .right_scale = 2,
                                             .laser_delay_s = 0.04,
                                             .camera_delay_s = -0.1};

template <typename T>
T Corrected(const LogCorrection& correction, T value) {
  LogEntry entry = std::move(value);
  Correct(correction, entry);
  return std::get<T>(entry);
}

TEST(LogCorrection, EachKindOfEntryIsCorrected) {
  const LogCorrection correction = {.sensors = kSensors, .robot = {}};
  const base::MonotonicTime at(milliseconds(500));
  const auto reading = Corrected(
      correction,
      core::BaseReading{.stamp = at, .left_wheel_m = 2, .right_wheel_m = 4});
  EXPECT_DOUBLE_EQ(reading.left_wheel_m, 1);
  EXPECT_DOUBLE_EQ(reading.right_wheel_m, 8);
  EXPECT_EQ(reading.stamp, at);
  core::LaserScan scan;
  scan.stamp = at;
  EXPECT_EQ(Corrected(correction, scan).stamp,
            base::MonotonicTime(milliseconds(460)));
  LogFrame frame;
  frame.stamp = at;
  EXPECT_EQ(Corrected(correction, frame).stamp,
            base::MonotonicTime(milliseconds(600)));
}

TEST(LogCorrection, TheRobotIsTheFilesOnlyIfTheFileSaysAllOfIt) {
  core::RobotModel of_log;
  of_log.wheel_track_m = 0.4;
  core::RobotModel of_file;
  of_file.wheel_track_m = 0.6;
  EXPECT_EQ(Corrected({.sensors = kSensors, .robot = {}}, of_log).wheel_track_m,
            0.4);
  EXPECT_EQ(Corrected({.sensors = {}, .robot = of_file}, of_log).wheel_track_m,
            0.6);
  EXPECT_TRUE(LogCorrection().IsNone());
  EXPECT_FALSE((LogCorrection{.sensors = kSensors, .robot = {}}.IsNone()));
}

}  // namespace
}  // namespace treeline::recording
