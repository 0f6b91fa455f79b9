// A simulated robot, driven through the real drivers over real connections.
#include "simulation/emulators/simulated_robot.h"

#include <cmath>
#include <functional>
#include <thread>

#include "gtest/gtest.h"
#include "nav_agent/drivers/hokuyo/hokuyo_laser.h"
#include "nav_agent/drivers/segway/segway_base.h"
#include "nav_agent/drivers/stream/stream_address.h"
#include "simulation/emulators/emulator_server.h"
#include "simulation/emulators/hokuyo_emulator.h"
#include "simulation/emulators/segway_device.h"
#include "simulation/simulator/testing_places.h"

namespace treeline::emulators {
namespace {

// Straight ahead of the robot's laser; NaN while there is no such range.
double RangeAhead_m(const core::LaserScan& scan) {
  return scan.ranges_m.empty() ? NAN : scan.ranges_m[scan.ranges_m.size() / 2];
}

// Robot, emulators and drivers, wired as on the real machine: the laser over
// TCP, the base over a pseudo terminal.
class DrivenRobot {
 public:
  DrivenRobot() {
    simulator::SimulatorOptions options;
    options.start = {.position = {2, 10}, .yaw_rad = 0, .height_m = 0};
    options.sensors.has_laser = false;
    auto simulator =
        simulator::Simulator::Create(simulator::Hall().Build(), options);
    EXPECT_TRUE(simulator.ok()) << simulator.status();
    simulator_ = *std::move(simulator);
    const base::MonotonicTime start = clock_.Now();
    robot_ = *SimulatedRobot::Create(*simulator_, start);
    laser_device_ = std::make_unique<HokuyoEmulator>(HokuyoEmulatorOptions(),
                                                     *robot_, start);
    base_device_ =
        std::make_unique<SegwayDevice>(SegwayEmulatorOptions(), *robot_, start);
    laser_server_ = *EmulatorServer::Start(
        {.listen = *ParseDeviceAddress("tcp:0"), .faults = {}, .seed = 1},
        *laser_device_, clock_);
    base_server_ = *EmulatorServer::Start(
        {.listen = *ParseDeviceAddress("pty"), .faults = {}, .seed = 1},
        *base_device_, clock_);
    laser_ = *hokuyo::HokuyoLaser::Start(
        {}, *stream::ParseStreamAddress(laser_server_->address(), 115200),
        clock_);
    base_ = *segway::SegwayBase::Create(
        {},
        *stream::ParseStreamAddress(base_server_->address(),
                                    segway::kSegwayBaud),
        clock_);
  }

  // Polls until `is_done`, at most ten seconds.
  bool Until(const std::function<bool()>& is_done) {
    const base::MonotonicTime end = clock_.Now() + std::chrono::seconds(10);
    while (clock_.Now() < end) {
      for (core::LaserScan& scan : laser_->TakeScans()) scan_ = std::move(scan);
      for (const core::BaseReading& reading : base_->TakeReadings()) {
        reading_ = reading;
      }
      if (is_done()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }

  simulator::Simulator& simulator() { return *simulator_; }
  SimulatedRobot& devices() { return *robot_; }
  segway::SegwayBase& base() { return *base_; }
  const core::LaserScan& scan() const { return scan_; }
  const core::BaseReading& reading() const { return reading_; }

 private:
  base::SteadyClock clock_;
  std::unique_ptr<simulator::Simulator> simulator_;
  std::unique_ptr<SimulatedRobot> robot_;
  std::unique_ptr<HokuyoEmulator> laser_device_;
  std::unique_ptr<SegwayDevice> base_device_;
  std::unique_ptr<EmulatorServer> laser_server_;
  std::unique_ptr<EmulatorServer> base_server_;
  std::unique_ptr<hokuyo::HokuyoLaser> laser_;
  std::unique_ptr<segway::SegwayBase> base_;
  core::LaserScan scan_;
  core::BaseReading reading_;
};

TEST(SimulatedRobot, IsDrivenThroughTheRealDrivers) {
  DrivenRobot robot;
  ASSERT_TRUE(robot.Until([&] {
    return std::isfinite(RangeAhead_m(robot.scan())) &&
           robot.reading().stamp > base::MonotonicTime();
  }));
  const double range_before_m = RangeAhead_m(robot.scan());
  const double wheel_before_m = robot.reading().left_wheel_m;
  const simulator::TrueState before = robot.simulator().state();
  // The wall of the hall, seen from the laser of a robot at x = 2.
  EXPECT_NEAR(range_before_m,
              20 - 2 - core::RobotModel().base_from_laser.translation.x, 0.15);

  // And the one behind it, from one that looks back.
  const core::RangeSensorInfo info = {.angle_min_rad = -2.35619449,
                                      .angle_increment_rad = 0.00436332313,
                                      .beams = 1081,
                                      .range_min_m = 0.1,
                                      .range_max_m = 30,
                                      .beam_interval_s = 0,
                                      .scan_interval_s = 0.025};
  EXPECT_NEAR(RangeAhead_m(robot.devices().rear_laser().ScanAt(
                  robot.scan().stamp, info)),
              2 - 0.22, 0.15);

  ASSERT_TRUE(robot.Until([&] {
    return robot.base().SetVelocity({0.5, 0}).ok() &&
           robot.simulator().state().distance_m > 0.6;
  }));
  // Without commands it stands, within lifetime and braking.
  ASSERT_TRUE(robot.Until(
      [&] { return std::abs(robot.simulator().state().forward_mps) < 1e-3; }));
  const simulator::TrueState after = robot.simulator().state();
  const double driven_m = after.distance_m - before.distance_m;
  EXPECT_LT(driven_m, 1.2);
  ASSERT_TRUE(robot.Until([&] {
    return std::abs(range_before_m - RangeAhead_m(robot.scan()) - driven_m) <
           0.1;
  })) << "the laser sees "
      << RangeAhead_m(robot.scan()) << " m, " << range_before_m
      << " m before, and the robot drove " << driven_m;
  // Wheels slip and are not as round as they claim: by a few per cent.
  EXPECT_NEAR(robot.reading().left_wheel_m - wheel_before_m, driven_m,
              0.05 + 0.05 * driven_m);
}

}  // namespace
}  // namespace treeline::emulators
