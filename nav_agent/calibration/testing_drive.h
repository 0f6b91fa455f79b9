// A drive through a furnished room, with a robot whose measures are known.
#ifndef NAV_AGENT_CALIBRATION_TESTING_DRIVE_H_
#define NAV_AGENT_CALIBRATION_TESTING_DRIVE_H_

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "common/base/random.h"
#include "nav_agent/calibration/drive.h"
#include "nav_agent/calibration/setup.h"
#include "nav_agent/mapping/testing_plan.h"

namespace treeline::calibration {

struct TestDriveOptions {
  uint64_t seed = 1;
  // What the robot truly is, and what the recording says of it.
  Setup truth;
  Setup assumed;
  // Where the robot goes, again and again, for how long.
  std::vector<geometry::Vec2> way = {{-4, -3}, {4, -3}, {3, 1}, {-3, 2},
                                     {-4, -3}, {-3, 2}, {3, 1}, {4, -3}};
  double seconds = 75;
  // Of each wheel, a metre (1 sigma): it grows with the root of the way.
  double wheel_noise = 0.004;
  double range_noise_m = 0.01;
  double yaw_rate_scale = 1;
  double yaw_rate_bias_radps = 0;
};

inline std::vector<mapping::TestWall> FurnishedRoom() {
  std::vector<mapping::TestWall> walls;
  mapping::AddBox({-6, -4.5}, {6, 4.5}, &walls);
  mapping::AddBox({-1, -0.6}, {0.2, 0.4}, &walls);
  mapping::AddBox({4.6, 1.8}, {5.4, 3.9}, &walls);
  mapping::AddBox({-5.6, -1}, {-5, 0.7}, &walls);
  mapping::AddBox({1.2, 3.3}, {2.9, 4.1}, &walls);
  mapping::AddBox({-0.5, -4.3}, {0.9, -3.8}, &walls);
  return walls;
}

// Speeds that turn on the spot towards a point and then go there, with
// accelerations of 1 m/s^2 and 3 rad/s^2.
class TestDriver {
 public:
  explicit TestDriver(std::vector<geometry::Vec2> way) : way_(std::move(way)) {}

  void Step(const geometry::Rigid2& pose, double interval_s) {
    const geometry::Vec2 to = pose.Inverse() * way_[next_ % way_.size()];
    const double heading_rad = std::atan2(to.y, to.x);
    double want_mps = 0;
    double want_radps = std::clamp(2.5 * heading_rad, -0.9, 0.9);
    if (geometry::Norm(to) < 0.3) {
      ++next_;
    } else if (std::abs(heading_rad) < 0.3) {
      want_mps = 0.6;
    }
    forward_mps += std::clamp(want_mps - forward_mps, -interval_s, interval_s);
    turn_radps +=
        std::clamp(want_radps - turn_radps, -3 * interval_s, 3 * interval_s);
  }

  double forward_mps = 0;
  double turn_radps = 0;

 private:
  std::vector<geometry::Vec2> way_;
  size_t next_ = 1;
};

// Entries as a log has them: 50 readings and 10 scans a second.
inline std::vector<recording::LogEntry> TestDriveEntries(
    const TestDriveOptions& options) {
  const core::RangeSensorInfo laser = mapping::TestLaser(12);
  const std::vector<mapping::TestWall> walls = FurnishedRoom();
  core::RobotModel robot;
  robot.wheel_track_m = options.assumed.wheels.track_m;
  robot.base_from_laser = {
      .rotation = geometry::Rotation3::FromAxisAngle(
          {0, 0, options.assumed.base_from_laser.yaw_rad}),
      .translation = {options.assumed.base_from_laser.translation.x,
                      options.assumed.base_from_laser.translation.y, 0.35}};
  std::vector<recording::LogEntry> entries = {robot, laser};
  base::Random random(options.seed, 5);
  TestDriver driver(options.way);
  geometry::Rigid2 map_from_base = {options.way[0], 0};
  core::BaseReading reading;
  constexpr double kStep_s = 0.01;
  const auto stamp = [](double time_s) {
    return base::MonotonicTime(
        std::chrono::nanoseconds(static_cast<int64_t>(time_s * 1e9)));
  };
  const Wheels& truth = options.truth.wheels;
  const int steps = static_cast<int>(options.seconds / kStep_s);
  for (int i = 0; i < steps; ++i) {
    driver.Step(map_from_base, kStep_s);
    const double way_m = driver.forward_mps * kStep_s;
    const double turn_rad = driver.turn_radps * kStep_s;
    map_from_base =
        map_from_base * geometry::Rigid2{{way_m * std::cos(turn_rad / 2),
                                          way_m * std::sin(turn_rad / 2)},
                                         turn_rad};
    const auto roll = [&](double side, double scale) {
      const double rolled_m = way_m + side * turn_rad * truth.track_m / 2;
      return (rolled_m + options.wheel_noise * std::sqrt(std::abs(rolled_m)) *
                             random.NextGaussian()) /
             scale;
    };
    reading.left_wheel_m += roll(-1, truth.left_scale);
    reading.right_wheel_m += roll(1, truth.right_scale);
    const double time_s = (i + 1) * kStep_s;
    if (i % 2 == 0) {
      reading.stamp = stamp(time_s);
      reading.yaw_rate_radps =
          (driver.turn_radps - options.yaw_rate_bias_radps) /
              options.yaw_rate_scale +
          0.002 * random.NextGaussian();
      entries.emplace_back(reading);
    }
    if (i % 10 == 0) {
      entries.emplace_back(core::LaserScan{
          .stamp = stamp(time_s + options.truth.laser_delay_s),
          .ranges_m = mapping::CastScan(
              walls, map_from_base * options.truth.base_from_laser, laser,
              options.range_noise_m,
              options.seed * 1000003 + static_cast<uint64_t>(i)),
          .intensities = {}});
    }
  }
  return entries;
}

inline absl::StatusOr<Drive> BuildDrive(
    const std::vector<recording::LogEntry>& entries) {
  DriveBuilder builder;
  for (const recording::LogEntry& entry : entries) builder.Take(entry);
  return builder.Build();
}

}  // namespace treeline::calibration

#endif  // NAV_AGENT_CALIBRATION_TESTING_DRIVE_H_
