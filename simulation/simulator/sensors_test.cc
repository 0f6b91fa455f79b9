// What the sensors measure, when, and that it is the same each time.
#include <cmath>
#include <cstring>
#include <string>

#include "gtest/gtest.h"
#include "simulation/simulator/testing_simulator.h"

namespace treeline::simulator {
namespace {

using std::chrono::milliseconds;

SimTime TimeOf(base::MonotonicTime stamp) { return stamp.time_since_epoch(); }

template <typename T>
void Append(std::string& bytes, const std::vector<T>& values) {
  bytes.append(reinterpret_cast<const char*>(values.data()),
               sizeof(T) * values.size());
}

// All that a robot measures on a drive with errors, as bytes.
std::string DriveBytes(uint64_t seed, int threads, SimTime part,
                       double camera_hz) {
  SimulatorOptions options = StartAt(10, 10);
  options.errors = WheelOdometryErrors();
  options.sensors.has_laser = true;
  options.sensors.camera_hz = camera_hz;
  options.seed = seed;
  options.threads = threads;
  worlds::Motion walk;
  walk.keys = {{.time_s = 0, .world_from_body = {{14, 8, 0}, 0}},
               {.time_s = 5, .world_from_body = {{14, 13, 0}, 0}}};
  const auto simulator =
      MakeSimulator(Hall().Body("person", walk).Build(), options);
  std::string bytes;
  for (int command = 0; command < 10; ++command) {
    EXPECT_TRUE(simulator->base().SetVelocity({0.5, 0.2}).ok());
    SimTime left = milliseconds(100);
    while (left > SimTime(0)) {
      const SimTime now = std::min(left, part);
      simulator->Step(now);
      left -= now;
    }
  }
  for (const core::LaserScan& scan : simulator->laser().TakeScans()) {
    Append(bytes, std::vector<base::MonotonicTime>{scan.stamp});
    Append(bytes, scan.ranges_m);
    Append(bytes, scan.intensities);
  }
  for (const core::BaseReading& r : simulator->odometry().TakeReadings()) {
    Append(bytes,
           std::vector<double>{r.left_wheel_m, r.right_wheel_m, r.pitch_rad,
                               r.roll_rad, r.yaw_rate_radps});
  }
  for (const core::RgbdFrame& frame : simulator->camera().TakeFrames()) {
    Append(bytes, frame.frame.color.rgb);
    Append(bytes, frame.frame.depth->values);
  }
  const geometry::Vec3 at = PositionOf(*simulator);
  Append(bytes, std::vector<double>{at.x, at.y, at.z});
  return bytes;
}

TEST(Sensors, TheSameSeedGivesTheSameBytesHoweverTimeIsDivided) {
  const std::string bytes = DriveBytes(5, 1, milliseconds(100), 0);
  EXPECT_GT(bytes.size(), 100000u);
  EXPECT_TRUE(bytes == DriveBytes(5, 1, milliseconds(5), 0));
  EXPECT_TRUE(bytes == DriveBytes(5, 1, SimTime(1'700'001), 0));
  EXPECT_FALSE(bytes == DriveBytes(6, 1, milliseconds(100), 0));
}

TEST(Sensors, ThreadsDoNotChangeABit) {
  const std::string one = DriveBytes(5, 1, milliseconds(100), 2);
  EXPECT_GT(one.size(), 1'000'000u);
  EXPECT_TRUE(one == DriveBytes(5, 2, milliseconds(100), 2));
}

TEST(Sensors, ScansArriveWithTheirRateAndLatency) {
  SimulatorOptions options = StartAt(5, 10);
  options.sensors.has_laser = true;
  const auto simulator = MakeSimulator(Hall().Build(), options);
  simulator->Step(milliseconds(1000));
  const auto scans = simulator->laser().TakeScans();
  // The last one takes 18.75 ms and 5 ms to arrive.
  ASSERT_EQ(scans.size(), 40u);
  EXPECT_EQ(TimeOf(scans[7].stamp), milliseconds(7 * 25));
  // Ahead (beam 540) is a wall 15 m from the axle, the laser 0.22 m before it.
  ASSERT_EQ(scans[7].ranges_m.size(), 1081u);
  EXPECT_NEAR(scans[7].ranges_m[540], 14.78, 0.06);
  EXPECT_EQ(simulator->laser().Info().beams, 1081);
  // Nobody took the readings, and the last one is on its way.
  EXPECT_EQ(simulator->odometry().TakeReadings().size(),
            static_cast<size_t>(core::kMaxWaiting) - 1);
  EXPECT_GT(simulator->odometry().Health().dropped, 30);
}

TEST(Sensors, ARearLaserSeesWhatIsBehind) {
  SimulatorOptions options = StartAt(5, 10);
  options.sensors.has_laser = true;
  EXPECT_EQ(MakeSimulator(Hall().Build(), options)->rear_laser(), nullptr);
  const auto without = MakeSimulator(Hall().Build(), options);
  options.sensors.has_rear_laser = true;
  const auto simulator = MakeSimulator(Hall().Build(), options);
  without->Step(milliseconds(1000));
  simulator->Step(milliseconds(1000));
  ASSERT_NE(simulator->rear_laser(), nullptr);
  const auto scans = simulator->rear_laser()->TakeScans();
  ASSERT_EQ(scans.size(), 40u);
  // Straight back (beam 270 of 541) is a wall 5 m from the axle.
  ASSERT_EQ(scans[7].ranges_m.size(), 541u);
  EXPECT_NEAR(scans[7].ranges_m[270], 5 - 0.22, 0.06);
  // Ahead of the robot it does not look; sideways there is nothing in reach.
  EXPECT_EQ(scans[7].ranges_m[0], core::kNoReturn);
  // The first one is not changed by it.
  EXPECT_EQ(simulator->laser().TakeScans().back().ranges_m,
            without->laser().TakeScans().back().ranges_m);
}

TEST(Sensors, AMovingRobotSeesASkewedWorld) {
  SimulatorOptions options = StartAt(10, 10);
  options.sensors.has_laser = true;
  options.sensors.laser.noise_base_m = 0;
  options.sensors.laser.noise_per_m = 0;
  options.sensors.laser.random_loss = 0;
  options.sensors.laser.range_step_m = 0;
  const auto simulator = MakeSimulator(Hall().Build(), options);
  Drive(*simulator, {.yaw_rate_radps = 1.5}, 1);
  simulator->laser().TakeScans();
  Drive(*simulator, {.yaw_rate_radps = 1.5}, 0.1);
  const core::LaserScan scan = simulator->laser().TakeScans().front();
  const core::RangeSensorInfo info = simulator->laser().Info();
  // Each beam's end, with the pose at its own time, lies on a wall.
  double off_m = 0;
  double off_unskewed_m = 0;
  const auto distance_to_wall = [](geometry::Vec3 p) {
    return std::min(
        {std::abs(p.x), std::abs(p.x - 20), std::abs(p.y), std::abs(p.y - 20)});
  };
  const geometry::Rigid3 base_from_laser = core::RobotModel().base_from_laser;
  for (int beam = 0; beam < info.beams; beam += 20) {
    const double angle_rad = info.AngleOf_rad(beam);
    const double range_m = scan.ranges_m[static_cast<size_t>(beam)];
    const geometry::Vec3 in_laser = {range_m * std::cos(angle_rad),
                                     range_m * std::sin(angle_rad), 0};
    const SimTime first = TimeOf(scan.stamp);
    const SimTime at = first + FromSeconds(beam * info.beam_interval_s);
    off_m = std::max(off_m, distance_to_wall(simulator->WorldFromBaseAt(at) *
                                             base_from_laser * in_laser));
    off_unskewed_m = std::max(
        off_unskewed_m, distance_to_wall(simulator->WorldFromBaseAt(first) *
                                         base_from_laser * in_laser));
  }
  EXPECT_LT(off_m, 0.002);
  // 1.5 rad/s for 19 ms at 10 m are 0.28 m.
  EXPECT_GT(off_unskewed_m, 0.1);
}

TEST(Sensors, DepthIsTheSameWithoutLight) {
  std::vector<std::vector<uint16_t>> depths;
  for (const bool is_lit : {true, false}) {
    SimulatorOptions options = StartAt(10, 10);
    options.sensors.camera_hz = 10;
    options.sensors.camera_scale = 0.1;
    options.sensors.camera_is_lit = is_lit;
    const auto simulator = MakeSimulator(Hall().Build(), options);
    simulator->Step(milliseconds(100));
    const auto frames = simulator->camera().TakeFrames();
    ASSERT_FALSE(frames.empty());
    ASSERT_TRUE(frames[0].frame.depth.has_value());
    depths.push_back(frames[0].frame.depth->values);
  }
  EXPECT_GT(*std::ranges::max_element(depths[0]), 0);
  EXPECT_EQ(depths[0], depths[1]);
}

TEST(Sensors, PicturesAreTakenOnlyForWhoAsks) {
  SimulatorOptions options = StartAt(10, 10);
  options.sensors.camera_hz = 10;
  const auto simulator = MakeSimulator(Hall().Build(), options);
  simulator->Step(milliseconds(250));
  const auto frames = simulator->camera().TakeFrames();
  // At 0, 0.1 and 0.2 s; 40 ms later they are there.
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[2].sequence, 2);
  EXPECT_EQ(TimeOf(frames[2].stamp), milliseconds(200));
  EXPECT_EQ(frames[0].frame.color.width, 640);
  ASSERT_TRUE(frames[0].frame.depth.has_value());
  ASSERT_TRUE(
      simulator
          ->Inject({.target = FaultTarget::kCamera, .kind = FaultKind::kDark})
          .ok());
  ASSERT_TRUE(simulator
                  ->Inject({.target = FaultTarget::kCamera,
                            .kind = FaultKind::kInvalid})
                  .ok());
  simulator->Step(milliseconds(100));
  const auto dark = simulator->camera().TakeFrames();
  ASSERT_EQ(dark.size(), 1u);
  EXPECT_EQ(*std::ranges::max_element(dark[0].frame.color.rgb), 0);
  EXPECT_EQ(*std::ranges::max_element(dark[0].frame.depth->values), 0);
}

}  // namespace
}  // namespace treeline::simulator
