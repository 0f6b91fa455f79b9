#include "nav_agent/core/corrected_devices.h"

#include <vector>

#include "gtest/gtest.h"

namespace treeline::core {
namespace {

using std::chrono::milliseconds;

class OneReading final : public Odometry {
 public:
  std::vector<BaseReading> TakeReadings() override {
    return {{.stamp = base::MonotonicTime(milliseconds(500)),
             .left_wheel_m = 2,
             .right_wheel_m = 4,
             .forward_mps = 1}};
  }
  DeviceHealth Health() const override {
    return {.state = DeviceState::kRunning, .received = 7};
  }
};

class OneScan final : public RangeSensor {
 public:
  RangeSensorInfo Info() const override { return {.beams = 3}; }
  std::vector<LaserScan> TakeScans() override {
    return {{.stamp = base::MonotonicTime(milliseconds(500)),
             .ranges_m = {1, 2, 3},
             .intensities = {}}};
  }
  DeviceHealth Health() const override {
    return {.state = DeviceState::kRunning, .received = 9};
  }
};

constexpr SensorCorrection kCorrection = {
    .left_scale = 0.5, .right_scale = 2, .laser_delay_s = 0.04};

TEST(CorrectedDevices, WheelsRollAsFarAsTheyTrulyDo) {
  OneReading raw;
  CorrectedOdometry odometry(raw, kCorrection);
  const std::vector<BaseReading> readings = odometry.TakeReadings();
  ASSERT_EQ(readings.size(), 1u);
  EXPECT_DOUBLE_EQ(readings[0].left_wheel_m, 1);
  EXPECT_DOUBLE_EQ(readings[0].right_wheel_m, 8);
  EXPECT_EQ(readings[0].stamp, base::MonotonicTime(milliseconds(500)));
  EXPECT_EQ(odometry.Health().received, 7);
}

TEST(CorrectedDevices, TurnsAreScaledAndTheWayIsNot) {
  BaseReading reading = {.stamp = {},
                         .left_wheel_m = 1,
                         .right_wheel_m = 3,
                         .yaw_rate_radps = 0.5};
  Correct({.turn_scale = 1.5}, reading);
  EXPECT_DOUBLE_EQ(reading.left_wheel_m, 0.5);
  EXPECT_DOUBLE_EQ(reading.right_wheel_m, 3.5);
  EXPECT_DOUBLE_EQ(reading.yaw_rate_radps, 0.75);
}

class OneFrame final : public RgbdCamera {
 public:
  camera::RgbdCalibration Calibration() const override { return {}; }
  std::vector<RgbdFrame> TakeFrames() override {
    std::vector<RgbdFrame> frames(1);
    frames[0].stamp = base::MonotonicTime(milliseconds(500));
    return frames;
  }
  DeviceHealth Health() const override {
    return {.state = DeviceState::kRunning, .received = 5};
  }
};

TEST(CorrectedDevices, PicturesAreOnTheWheelsTime) {
  OneFrame raw;
  CorrectedCamera camera(raw, {.camera_delay_s = 0.1});
  const std::vector<RgbdFrame> frames = camera.TakeFrames();
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].stamp, base::MonotonicTime(milliseconds(400)));
  EXPECT_EQ(camera.Health().received, 5);
}

TEST(CorrectedDevices, ScansAreOnTheWheelsTime) {
  OneScan raw;
  CorrectedLaser laser(raw, kCorrection);
  const std::vector<LaserScan> scans = laser.TakeScans();
  ASSERT_EQ(scans.size(), 1u);
  EXPECT_EQ(scans[0].stamp, base::MonotonicTime(milliseconds(460)));
  EXPECT_EQ(scans[0].ranges_m.size(), 3u);
  EXPECT_EQ(laser.Info().beams, 3);
  EXPECT_EQ(laser.Health().received, 9);
}

}  // namespace
}  // namespace treeline::core
