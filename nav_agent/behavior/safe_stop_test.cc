#include "nav_agent/behavior/safe_stop.h"

#include <limits>

#include "nav_agent/behavior/testing_navigator.h"

namespace treeline::behavior {
namespace {

class SafeStopTest : public NavigatorFixture {
 protected:
  void Drive() {
    MakePlaced();
    Send({PoseAtPoint(7, 2)});
    Run(0.2);
    ASSERT_EQ(mode(), NavigatorMode::kDriving);
  }
  void ExpectStop(core::NavigationCause cause) {
    EXPECT_EQ(mode(), NavigatorMode::kSafeStop);
    EXPECT_EQ(navigator->Snapshot().cause, cause);
    EXPECT_FALSE(navigator->Snapshot().cause_text.empty());
    EXPECT_EQ(Last(), core::VelocityCommand{});
    EXPECT_GE(base.stops, 1);
    EXPECT_EQ(Goal().state, GoalState::kActive);
  }
  void ExpectGoesOn() {
    Run(0.5);
    EXPECT_EQ(mode(), NavigatorMode::kDriving);
    EXPECT_EQ(Count("resume", "all is well again"), 1);
  }
};

TEST_F(SafeStopTest, WhileItHoldsItRefusesWithTheReason) {
  EventLog log;
  SafeStop stop({}, log);
  EXPECT_TRUE(stop.Refuse("driving by hand").ok());
  stop.Update(
      {{.cause = core::NavigationCause::kLaserLost, .text = "no laser"}},
      clock.Now());
  EXPECT_EQ(
      stop.Refuse("driving by hand"),
      absl::FailedPreconditionError("driving by hand is refused: no laser"));
}

TEST_F(SafeStopTest, OfASilentLaser) {
  Drive();
  laser_runs = false;
  Run(0.25);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
  Run(0.1);
  ExpectStop(core::NavigationCause::kLaserLost);
  laser_runs = true;
  Run(0.2);
  EXPECT_EQ(mode(), NavigatorMode::kSafeStop);
  ExpectGoesOn();
}

TEST_F(SafeStopTest, OfASilentRearLaser) {
  has_rear_laser = true;
  Drive();
  EXPECT_GT(controller->rear_scans, 3);
  rear_laser_runs = false;
  Run(0.35);
  ExpectStop(core::NavigationCause::kLaserLost);
  EXPECT_TRUE(
      absl::StrContains(navigator->Snapshot().cause_text, "rear laser"));
  EXPECT_GT(navigator->Snapshot().rear_laser.used, 3);
  rear_laser_runs = true;
  Run(0.2);
  ExpectGoesOn();
}

TEST_F(SafeStopTest, NotOfARearLaserThatIsNotThere) {
  rear_laser_runs = false;
  Drive();
  Run(1);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
  EXPECT_EQ(controller->rear_scans, 0);
}

TEST_F(SafeStopTest, OfALaserThatSaysThatItIsLost) {
  Drive();
  laser.health.state = core::DeviceState::kLost;
  laser.health.cause = absl::UnavailableError("unplugged");
  Run(0.025);
  ExpectStop(core::NavigationCause::kLaserLost);
  EXPECT_TRUE(absl::StrContains(navigator->Snapshot().cause_text, "unplugged"));
  laser.health = {.state = core::DeviceState::kRunning};
  ExpectGoesOn();
}

TEST_F(SafeStopTest, OfScansWithoutRanges) {
  Drive();
  laser_runs = false;
  for (int i = 0; i < 20; ++i) {
    core::LaserScan scan;
    scan.stamp = clock.Now();
    scan.ranges_m.assign(31, core::kInvalidRange);
    laser.waiting.push_back(scan);
    Run(0.025);
  }
  ExpectStop(core::NavigationCause::kLaserLost);
  EXPECT_EQ(navigator->Snapshot().laser.broken, 20);
  EXPECT_TRUE(absl::StrContains(navigator->Snapshot().cause_text, "broken"));
}

TEST_F(SafeStopTest, OfStampsThatCannotBe) {
  Drive();
  laser_runs = false;
  const auto add = [&](double offset_s) {
    core::LaserScan scan;
    scan.stamp =
        clock.Now() + std::chrono::milliseconds(std::llround(1e3 * offset_s));
    scan.ranges_m.assign(31, 3.0f);
    laser.waiting.push_back(scan);
  };
  for (int i = 0; i < 20; ++i) {
    add(0.5);
    add(-0.9);
    Run(0.025);
  }
  ExpectStop(core::NavigationCause::kLaserLost);
  EXPECT_EQ(navigator->Snapshot().laser.future, 20);
  EXPECT_EQ(navigator->Snapshot().laser.late, 20);
  add(0);
  add(-0.02);
  add(-0.02);
  Run(0.025);
  EXPECT_EQ(navigator->Snapshot().laser.out_of_order, 2);
}

TEST_F(SafeStopTest, OfALaserThatIsFrozenWhileTheRobotMoves) {
  Drive();
  laser_runs = false;
  for (int i = 0; i < 20; ++i) {
    core::LaserScan scan;
    scan.stamp = clock.Now();
    scan.ranges_m.assign(31, 2.0f);
    laser.waiting.push_back(scan);
    Run(0.025);
  }
  // It stands: that everything looks the same is as it should be.
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
  for (int i = 0; i < 20; ++i) {
    core::LaserScan scan;
    scan.stamp = clock.Now();
    scan.ranges_m.assign(31, 2.0f);
    laser.waiting.push_back(scan);
    reading.left_wheel_m += 0.01;
    reading.right_wheel_m += 0.01;
    Run(0.025);
  }
  ExpectStop(core::NavigationCause::kLaserLost);
  laser_runs = true;
  ExpectGoesOn();
}

TEST_F(SafeStopTest, OfSilentOdometry) {
  Drive();
  odometry_runs = false;
  Run(0.3);
  ExpectStop(core::NavigationCause::kOdometryLost);
  odometry_runs = true;
  ExpectGoesOn();
}

TEST_F(SafeStopTest, OfOdometryThatIsFrozen) {
  Drive();
  odometry_runs = false;
  reading.forward_mps = 0.4;
  for (int i = 0; i < 30; ++i) {
    reading.stamp = clock.Now();
    odometry.waiting.push_back(reading);
    Run(0.025);
  }
  ExpectStop(core::NavigationCause::kOdometryLost);
  odometry_runs = true;
  ExpectGoesOn();
}

TEST_F(SafeStopTest, OfABaseThatRefuses) {
  Drive();
  base.answer = absl::UnavailableError("emergency stop");
  Run(0.05);
  EXPECT_EQ(mode(), NavigatorMode::kSafeStop);
  EXPECT_EQ(navigator->Snapshot().cause, core::NavigationCause::kBaseLost);
  base.answer = absl::OkStatus();
  ExpectGoesOn();
}

TEST_F(SafeStopTest, OfMotorsThatAreOff) {
  Drive();
  reading.motors_enabled = false;
  Run(0.025);
  ExpectStop(core::NavigationCause::kBaseLost);
  reading.motors_enabled = true;
  ExpectGoesOn();
}

TEST_F(SafeStopTest, OfTilt) {
  Drive();
  // Steep, but such ground it stands on.
  pitch = 0.27;
  Run(1);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
  pitch = 0.5;
  Run(0.05);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
  Run(0.3);
  ExpectStop(core::NavigationCause::kTilted);
  pitch = 0;
  ExpectGoesOn();
}

TEST_F(SafeStopTest, OfAnEstimateThatIsNotANumber) {
  Drive();
  tracker->pose = PoseAtPoint(std::numeric_limits<double>::quiet_NaN(), 0);
  Run(0.025);
  ExpectStop(core::NavigationCause::kEstimateLost);
  tracker->pose = PoseAtPoint(2, 2);
  ExpectGoesOn();
}

TEST_F(SafeStopTest, OfALoopThatStoodStill) {
  Drive();
  clock.Advance_s(0.4);
  Run(0.025);
  ExpectStop(core::NavigationCause::kControlLate);
  EXPECT_EQ(navigator->Snapshot().missed_deadlines, 1);
  EXPECT_NEAR(navigator->Snapshot().longest_step_gap_s, 0.425, 1e-6);
  ExpectGoesOn();
}

TEST_F(SafeStopTest, LateStepsAreCounted) {
  Drive();
  for (int i = 0; i < 5; ++i) {
    clock.Advance_s(0.02);
    Run(0.025);
  }
  EXPECT_EQ(navigator->Snapshot().missed_deadlines, 5);
  EXPECT_EQ(mode(), NavigatorMode::kDriving);
  EXPECT_EQ(Count("deadline", ""), 1);
}

// Being told to stand counts for more than being lost, and being lost for more
// than goals.
TEST_F(SafeStopTest, ComesBeforeEverythingElse) {
  Drive();
  lost->now_state = RelocalizationState::kSearching;
  lost->wanted.yaw_rate_radps = 0.5;
  Run(0.1);
  EXPECT_EQ(mode(), NavigatorMode::kRelocalizing);
  const int steps = lost->steps;
  laser_runs = false;
  Run(0.5);
  ExpectStop(core::NavigationCause::kLaserLost);
  EXPECT_LT(lost->steps, steps + 15);
  laser_runs = true;
  Run(0.5);
  EXPECT_EQ(mode(), NavigatorMode::kRelocalizing);
  navigator->Pause();
  Run(0.05);
  EXPECT_EQ(mode(), NavigatorMode::kPaused);
}

}  // namespace
}  // namespace treeline::behavior
