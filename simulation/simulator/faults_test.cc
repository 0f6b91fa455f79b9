// Each fault does what it says, for as long as it says.
#include <cmath>
#include <numbers>

#include "gtest/gtest.h"
#include "simulation/simulator/testing_simulator.h"

namespace treeline::simulator {
namespace {

using std::chrono::milliseconds;

class FaultsTest : public testing::Test {
 protected:
  FaultsTest() {
    SimulatorOptions options = StartAt(10, 10);
    options.sensors.has_laser = true;
    options.sensors.laser_latency_s = 0;
    options.sensors.odometry_latency_s = 0;
    simulator_ = MakeSimulator(Hall().Build(), options);
    simulator_->Step(milliseconds(1000));
    simulator_->laser().TakeScans();
    simulator_->odometry().TakeReadings();
  }

  void Inject(FaultTarget target, FaultKind kind, int for_ms,
              double amount = 1) {
    EXPECT_TRUE(simulator_
                    ->Inject({.target = target,
                              .kind = kind,
                              .start = SimTime(0),
                              .duration = milliseconds(for_ms),
                              .amount = amount})
                    .ok());
  }
  std::vector<core::LaserScan> ScansIn(int ms) {
    simulator_->Step(milliseconds(ms));
    return simulator_->laser().TakeScans();
  }
  std::vector<core::BaseReading> ReadingsIn(int ms) {
    simulator_->Step(milliseconds(ms));
    return simulator_->odometry().TakeReadings();
  }
  SimTime TimeOf(base::MonotonicTime stamp) { return stamp.time_since_epoch(); }

  std::unique_ptr<Simulator> simulator_;
};

TEST_F(FaultsTest, ASilentLaserIsLostAndComesBack) {
  EXPECT_EQ(simulator_->laser().Health().state, core::DeviceState::kRunning);
  Inject(FaultTarget::kLaser, FaultKind::kSilent, 500);
  // The scan that was being taken still comes.
  EXPECT_LE(ScansIn(500).size(), 1u);
  const core::DeviceHealth health = simulator_->laser().Health();
  EXPECT_EQ(health.state, core::DeviceState::kLost);
  EXPECT_EQ(health.losses, 1);
  EXPECT_FALSE(health.cause.ok());
  EXPECT_NEAR(static_cast<double>(ScansIn(500).size()), 20, 1);
  EXPECT_EQ(simulator_->laser().Health().state, core::DeviceState::kRunning);
  const auto began = EventsOf(*simulator_, SimEventKind::kFaultBegan);
  EXPECT_EQ(began.size(), 1u);
}

TEST_F(FaultsTest, ARearLaserFailsByItself) {
  SimulatorOptions options = StartAt(10, 10);
  options.sensors.has_laser = true;
  options.sensors.has_rear_laser = true;
  simulator_ = MakeSimulator(Hall().Build(), options);
  simulator_->Step(milliseconds(1000));
  Inject(FaultTarget::kRearLaser, FaultKind::kSilent, 500);
  simulator_->Step(milliseconds(400));
  EXPECT_EQ(simulator_->rear_laser()->Health().state, core::DeviceState::kLost);
  EXPECT_EQ(simulator_->laser().Health().state, core::DeviceState::kRunning);
  simulator_->Step(milliseconds(200));
  EXPECT_EQ(simulator_->rear_laser()->Health().state,
            core::DeviceState::kRunning);
}

TEST_F(FaultsTest, AFrozenLaserRepeatsItselfWithNewStamps) {
  Inject(FaultTarget::kLaser, FaultKind::kFrozen, 400);
  const auto scans = ScansIn(400);
  ASSERT_GE(scans.size(), 15u);
  EXPECT_EQ(scans[3].ranges_m, scans[12].ranges_m);
  EXPECT_EQ(TimeOf(scans[12].stamp) - TimeOf(scans[3].stamp),
            milliseconds(9 * 25));
  ScansIn(100);
  const auto later = ScansIn(100);
  EXPECT_NE(later[0].ranges_m, later[1].ranges_m);
}

TEST_F(FaultsTest, InvalidScansHaveThatShareOfNaN) {
  ScansIn(25);
  Inject(FaultTarget::kLaser, FaultKind::kInvalid, 1000, 0.25);
  int nan = 0;
  int all = 0;
  for (const core::LaserScan& scan : ScansIn(1000)) {
    for (const float range_m : scan.ranges_m) {
      nan += std::isnan(range_m) ? 1 : 0;
      ++all;
    }
  }
  // 40,000 beams: five deviations are 1.1 %.
  EXPECT_NEAR(static_cast<double>(nan) / all, 0.25, 0.011 + 0.01);
}

TEST_F(FaultsTest, StampsAreOffByWhatWasAsked) {
  ReadingsIn(10);
  Inject(FaultTarget::kOdometry, FaultKind::kStampOffset, 1000, -0.2);
  const auto readings = ReadingsIn(100);
  ASSERT_FALSE(readings.empty());
  EXPECT_EQ(TimeOf(readings.back().stamp),
            simulator_->now() - milliseconds(200));
}

TEST_F(FaultsTest, DelayedMeasurementsComeLaterWithTrueStamps) {
  Inject(FaultTarget::kOdometry, FaultKind::kDelay, 1000, 0.3);
  EXPECT_TRUE(ReadingsIn(290).empty());
  const SimTime before = simulator_->now();
  const auto readings = ReadingsIn(100);
  ASSERT_FALSE(readings.empty());
  EXPECT_LT(TimeOf(readings.front().stamp), before - milliseconds(200));
}

TEST_F(FaultsTest, AStuckWheelTurnsTheRobotAboutItself) {
  Inject(FaultTarget::kLeftWheel, FaultKind::kStuck, 10000);
  const geometry::Vec3 wheel =
      simulator_->state().world_from_base *
      geometry::Vec3{0, core::RobotModel().wheel_track_m / 2, 0};
  Drive(*simulator_, {.forward_mps = 0.4}, 3);
  EXPECT_GT(simulator_->state().turned_rad, 1);
  const geometry::Vec3 after =
      simulator_->state().world_from_base *
      geometry::Vec3{0, core::RobotModel().wheel_track_m / 2, 0};
  EXPECT_LT(Norm(after - wheel), 1e-6);
  // Its counter stands as well.
  EXPECT_EQ(simulator_->odometry().TakeReadings().back().left_wheel_m, 0);
}

TEST_F(FaultsTest, SlipIsNotSeenByTheCounters) {
  Inject(FaultTarget::kLeftWheel, FaultKind::kSlip, 10000, 0.5);
  Inject(FaultTarget::kRightWheel, FaultKind::kSlip, 10000, 0.5);
  Drive(*simulator_, {.forward_mps = 0.4}, 3);
  simulator_->Step(milliseconds(1000));
  const auto readings = simulator_->odometry().TakeReadings();
  EXPECT_NEAR(readings.back().left_wheel_m / 2, simulator_->state().distance_m,
              1e-9);
}

TEST_F(FaultsTest, ALostBaseRefusesCommandsAndStops) {
  Drive(*simulator_, {.forward_mps = 0.4}, 1);
  Inject(FaultTarget::kBase, FaultKind::kSilent, 1000);
  simulator_->Step(milliseconds(10));
  EXPECT_EQ(simulator_->base().SetVelocity({.forward_mps = 0.4}).code(),
            absl::StatusCode::kUnavailable);
  EXPECT_EQ(simulator_->base().Health().state, core::DeviceState::kLost);
  simulator_->Step(milliseconds(600));
  EXPECT_EQ(simulator_->state().forward_mps, 0);
  simulator_->Step(milliseconds(500));
  EXPECT_TRUE(simulator_->base().SetVelocity({.forward_mps = 0.4}).ok());
}

TEST_F(FaultsTest, CommandsThatAreNoNumbersStopTheBase) {
  Drive(*simulator_, {.forward_mps = 0.4}, 1);
  EXPECT_EQ(simulator_->base().SetVelocity({.forward_mps = NAN}).code(),
            absl::StatusCode::kInvalidArgument);
  simulator_->Step(milliseconds(10));
  EXPECT_LT(simulator_->state().forward_mps, 0.4);
}

TEST_F(FaultsTest, ADeadServerIsAFlag) {
  EXPECT_FALSE(simulator_->IsServerDead());
  Inject(FaultTarget::kServer, FaultKind::kSilent, 1000);
  EXPECT_TRUE(simulator_->IsServerDead());
  simulator_->Step(milliseconds(1000));
  EXPECT_FALSE(simulator_->IsServerDead());
}

TEST_F(FaultsTest, RepairEndsThem) {
  Inject(FaultTarget::kLaser, FaultKind::kSilent, 100000);
  ScansIn(200);
  simulator_->Repair(FaultTarget::kLaser);
  ScansIn(50);
  EXPECT_FALSE(ScansIn(100).empty());
}

TEST_F(FaultsTest, ResetCountersBeginAgain) {
  Drive(*simulator_, {.forward_mps = 0.4}, 2);
  Drive(*simulator_, {}, 1);
  simulator_->ResetOdometry();
  EXPECT_EQ(ReadingsIn(20).back().left_wheel_m, 0);
}

TEST_F(FaultsTest, FaultsThatDoNotExistAreRefused) {
  EXPECT_FALSE(
      simulator_
          ->Inject({.target = FaultTarget::kLaser, .kind = FaultKind::kStuck})
          .ok());
  EXPECT_FALSE(simulator_
                   ->Inject({.target = FaultTarget::kLaser,
                             .kind = FaultKind::kInvalid,
                             .amount = 2})
                   .ok());
  EXPECT_FALSE(ParseFaultKind("sleepy").ok());
}

}  // namespace
}  // namespace treeline::simulator
