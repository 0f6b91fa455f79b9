#include "nav_agent/app/map/live_mapper.h"

#include <gtest/gtest.h>

#include <chrono>
#include <utility>
#include <variant>
#include <vector>

#include "common/base/testing_folder.h"
#include "nav_agent/recording/agent_log.h"

namespace treeline::map_app {
namespace {

using std::chrono::milliseconds;

// Devices that say what a test has put into them.
class PlayedLaser final : public core::RangeSensor {
 public:
  core::RangeSensorInfo Info() const override {
    core::RangeSensorInfo info;
    info.beams = 181;
    info.angle_min_rad = -1.57;
    info.angle_increment_rad = 3.14 / 180;
    info.range_max_m = 30;
    return info;
  }
  std::vector<core::LaserScan> TakeScans() override {
    return std::exchange(scans, {});
  }
  core::DeviceHealth Health() const override {
    return {.state = core::DeviceState::kRunning};
  }
  std::vector<core::LaserScan> scans;
};

class PlayedWheels final : public core::Odometry {
 public:
  std::vector<core::BaseReading> TakeReadings() override {
    return std::exchange(readings, {});
  }
  core::DeviceHealth Health() const override {
    return {.state = core::DeviceState::kRunning};
  }
  std::vector<core::BaseReading> readings;
};

// In the open, where no scan sees anything: the wheels alone say where it is.
TEST(LiveMapperTest, WhatIsFollowedIsCorrectedAndWhatIsRecordedIsNot) {
  const base::TestingFolder folder;
  PlayedLaser laser;
  PlayedWheels wheels;
  const base::SteadyClock clock;
  LiveMapOptions options;
  options.log_path = folder.Path("drive.tlog");
  options.drive.slam.synchronous = true;
  const auto mapper = LiveMapper::Create(
      {.laser = laser,
       .odometry = wheels,
       .robot = {},
       .correction = {.left_scale = 0.5, .right_scale = 0.5}},
      options, clock);
  ASSERT_TRUE(mapper.ok()) << mapper.status();
  for (int i = 0; i <= 100; ++i) {
    wheels.readings.push_back(
        {.stamp = base::MonotonicTime(milliseconds(20 * i)),
         .left_wheel_m = 0.02 * i,
         .right_wheel_m = 0.02 * i,
         .forward_mps = 1});
    core::LaserScan scan;
    scan.stamp = base::MonotonicTime(milliseconds(20 * i));
    scan.ranges_m.assign(181, 0);
    laser.scans.push_back(std::move(scan));
    ASSERT_TRUE((*mapper)->Poll().ok());
  }
  ASSERT_TRUE((*mapper)->Finish().ok());
  const auto at = (*mapper)->Status().map_from_base;
  ASSERT_TRUE(at.has_value());
  // The last scans wait for wheels.
  EXPECT_NEAR(at->world_from_camera.translation.x, 1.0, 0.1);
  auto log = recording::AgentLogReader::Open(options.log_path);
  ASSERT_TRUE(log.ok()) << log.status();
  double left_m = 0;
  while (const auto entry = log->Next()) {
    if (const auto* reading = std::get_if<core::BaseReading>(&*entry)) {
      left_m = reading->left_wheel_m;
    }
  }
  EXPECT_DOUBLE_EQ(left_m, 2);
}

}  // namespace
}  // namespace treeline::map_app
