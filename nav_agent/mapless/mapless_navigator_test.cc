#include "nav_agent/mapless/mapless_navigator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/behavior/testing_devices.h"
#include "nav_agent/mapless/dead_reckoning.h"
#include "nav_agent/mapless/testing_clutter.h"

namespace treeline::mapless {
namespace {

using ::testing::HasSubstr;

constexpr double kStep_s = 0.025;

// A robot among round posts, by fake devices.
class MaplessNavigatorTest : public ::testing::Test {
 protected:
  void Make(const MaplessOptions& options = {}) {
    auto navigator =
        MakeMaplessNavigator(SmallRobot(), devices_, options, clock_);
    ASSERT_TRUE(navigator.ok()) << navigator.status();
    navigator_ = *std::move(navigator);
    Step(3);
  }

  void Step(int steps) {
    for (int i = 0; i < steps; ++i) {
      Move();
      if (laser_works_ && ++steps_ % steps_of_scan_ == 0) {
        laser_.waiting.push_back(Scan());
      }
      navigator_->Step();
      for (const geometry::Vec2 post : posts_) {
        const geometry::Vec2 in_base = pose_.Inverse() * post;
        touched_ = touched_ || (std::abs(in_base.x) < 0.25 + kPost_m &&
                                std::abs(in_base.y) < 0.2 + kPost_m);
      }
    }
  }

  uint64_t SetGoal(geometry::Vec2 goal, double yaw_rad = 0) {
    const auto id = navigator_->SetGoal(
        {.poses = {{.map_from_base = {goal, yaw_rad}, .place = {}}}});
    EXPECT_TRUE(id.ok()) << id.status();
    return id.ok() ? *id : 0;
  }

  static constexpr double kPost_m = 0.1;
  std::vector<geometry::Vec2> posts_;
  bool laser_works_ = true;
  // A scan comes every so many steps.
  int steps_of_scan_ = 1;
  bool touched_ = false;
  geometry::Rigid2 pose_;
  behavior::ManualClock clock_;
  behavior::FakeLaser laser_;
  behavior::FakeOdometry odometry_;
  behavior::FakeBase base_;
  behavior::NavigatorDevices devices_{
      .laser = laser_, .odometry = odometry_, .base = base_};
  std::unique_ptr<behavior::Navigator> navigator_;

 private:
  void Move() {
    clock_.Advance_s(kStep_s);
    const core::VelocityCommand command = base_.commands.empty()
                                              ? core::VelocityCommand()
                                              : base_.commands.back();
    const auto toward = [](double from, double to, double step) {
      return from + std::clamp(to - from, -step, step);
    };
    forward_mps_ = toward(forward_mps_, command.forward_mps, 2 * kStep_s);
    turn_radps_ = toward(turn_radps_, command.yaw_rate_radps, 8 * kStep_s);
    pose_ = MovedOn(pose_, forward_mps_, turn_radps_, kStep_s);
    driven_m_ += forward_mps_ * kStep_s;
    core::BaseReading reading;
    reading.stamp = clock_.Now();
    reading.left_wheel_m = driven_m_;
    reading.right_wheel_m = driven_m_;
    reading.forward_mps = forward_mps_;
    reading.yaw_rate_radps = turn_radps_;
    // Readings that stay the same are a frozen device's.
    reading.pitch_rad = 1e-6 * static_cast<double>(++count_ % 7);
    odometry_.waiting.push_back(reading);
  }

  core::LaserScan Scan() {
    core::LaserScan scan = {
        .stamp = clock_.Now(), .ranges_m = {}, .intensities = {}};
    const core::RangeSensorInfo info = laser_.Info();
    const geometry::Vec2 from = pose_ * geometry::Vec2{0.22, 0};
    for (int i = 0; i < info.beams; ++i) {
      const double angle_rad = pose_.yaw_rad + info.AngleOf_rad(i);
      const geometry::Vec2 along = {std::cos(angle_rad), std::sin(angle_rad)};
      // A far wall all around, whose noise tells scans apart.
      double range_m = 9 + 1e-4 * static_cast<double>((count_ + i) % 11);
      for (const geometry::Vec2 post : posts_) {
        const geometry::Vec2 to = post - from;
        const double on_m = geometry::Dot(to, along);
        const double beside_m = geometry::Cross(along, to);
        if (on_m > 0 && std::abs(beside_m) < kPost_m) {
          range_m = std::min(range_m, on_m - std::sqrt(kPost_m * kPost_m -
                                                       beside_m * beside_m));
        }
      }
      scan.ranges_m.push_back(static_cast<float>(range_m));
    }
    return scan;
  }

  int steps_ = 0;
  double forward_mps_ = 0;
  double turn_radps_ = 0;
  double driven_m_ = 0;
  int64_t count_ = 0;
};

TEST_F(MaplessNavigatorTest, DrivesToAGoalAndTurnsThere) {
  Make();
  SetGoal({3, 0.5}, 1.5);
  Step(400);
  const behavior::GoalStatus goal = *navigator_->goal();
  EXPECT_EQ(goal.state, behavior::GoalState::kSucceeded) << goal.why;
  EXPECT_LT(geometry::Norm(pose_.translation - geometry::Vec2{3, 0.5}), 0.2);
  EXPECT_NEAR(pose_.yaw_rad, 1.5, 0.2);
  EXPECT_EQ(navigator_->mode(), behavior::NavigatorMode::kIdle);
}

TEST_F(MaplessNavigatorTest, GoesAroundWhatItSees) {
  for (int i = -4; i <= 4; ++i) posts_.push_back({2, 0.2 * i});
  Make();
  SetGoal({4, 0});
  Step(600);
  EXPECT_EQ(navigator_->goal()->state, behavior::GoalState::kSucceeded)
      << navigator_->goal()->why;
  EXPECT_FALSE(touched_);
  EXPECT_GT(navigator_->goal()->driven_m, 4.2);
  // They are on the map that it made.
  const behavior::NavigatorSnapshot snapshot = navigator_->Snapshot();
  EXPECT_GT(std::ranges::count(snapshot.costmap.cells, 2), 10);
}

TEST_F(MaplessNavigatorTest, WhatAMapKnowsIsThereBeforeItIsSeen) {
  MaplessOptions options;
  core::OccupancyGrid grid = core::OccupancyGrid::Filled(
      2, 40, 0.1, {{-2, -2}, 0}, core::Occupancy::kOccupied);
  options.known = {grid};
  Make(options);
  // Behind it: no beam goes there before it turns.
  SetGoal({-4, 0});
  Step(5);
  const behavior::NavigatorSnapshot snapshot = navigator_->Snapshot();
  ASSERT_FALSE(snapshot.path.empty());
  double max_m = 0;
  for (const core::LevelPose& pose : snapshot.path) {
    max_m = std::max(max_m, std::abs(pose.map_from_base.translation.y));
  }
  EXPECT_GT(max_m, 2);
}

TEST_F(MaplessNavigatorTest, StandsWhileTheLaserIsSilent) {
  Make();
  SetGoal({5, 0});
  Step(40);
  EXPECT_GT(base_.commands.back().forward_mps, 0.3);
  laser_works_ = false;
  Step(40);
  EXPECT_EQ(navigator_->mode(), behavior::NavigatorMode::kSafeStop);
  EXPECT_EQ(navigator_->Snapshot().cause, core::NavigationCause::kLaserLost);
  EXPECT_GT(base_.stops, 0);
  laser_works_ = true;
  Step(400);
  EXPECT_EQ(navigator_->goal()->state, behavior::GoalState::kSucceeded)
      << navigator_->goal()->why;
}

TEST_F(MaplessNavigatorTest, ASlowLaserIsNotSilent) {
  // Its scans are 0.4 s apart, more than MaplessOptions::laser_timeout_s.
  laser_.info.scan_interval_s = 0.2;
  steps_of_scan_ = 16;
  Make();
  Step(20);
  SetGoal({2, 0});
  Step(60);
  EXPECT_GT(base_.commands.back().forward_mps, 0.2);
  laser_works_ = false;
  Step(40);
  EXPECT_EQ(navigator_->Snapshot().cause, core::NavigationCause::kLaserLost);
}

TEST_F(MaplessNavigatorTest, PausesCancelsAndHalts) {
  Make();
  const uint64_t id = SetGoal({5, 0});
  Step(20);
  navigator_->Pause();
  Step(40);
  EXPECT_EQ(navigator_->mode(), behavior::NavigatorMode::kPaused);
  EXPECT_EQ(base_.commands.back(), core::VelocityCommand());
  navigator_->Resume();
  Step(20);
  EXPECT_GT(base_.commands.back().forward_mps, 0);
  EXPECT_FALSE(navigator_->CancelGoal(id + 1).ok());
  EXPECT_TRUE(navigator_->CancelGoal(id).ok());
  EXPECT_EQ(navigator_->goal()->state, behavior::GoalState::kCancelled);
  SetGoal({5, 0});
  navigator_->Halt();
  Step(40);
  EXPECT_EQ(base_.commands.back(), core::VelocityCommand());
}

TEST_F(MaplessNavigatorTest, AStopHoldsUntilItIsReleased) {
  Make();
  SetGoal({5, 0});
  Step(40);
  ASSERT_GT(base_.commands.back().forward_mps, 0.3);
  navigator_->Stop("a child");
  Step(1);
  EXPECT_GT(base_.stops, 0);
  EXPECT_EQ(base_.commands.back(), core::VelocityCommand());
  Step(100);
  EXPECT_EQ(base_.commands.back(), core::VelocityCommand());
  EXPECT_EQ(navigator_->mode(), behavior::NavigatorMode::kStopped);
  EXPECT_EQ(navigator_->goal()->cause, core::NavigationCause::kStopped);
  EXPECT_FALSE(
      navigator_
          ->SetGoal({.poses = {{.map_from_base = {{5, 0}, 0}, .place = {}}}})
          .ok());
  EXPECT_FALSE(
      navigator_->Drive({.forward_mps = 0.2, .yaw_rate_radps = 0}).ok());
  navigator_->Release();
  Step(40);
  EXPECT_EQ(navigator_->mode(), behavior::NavigatorMode::kIdle);
  EXPECT_EQ(base_.commands.back(), core::VelocityCommand());
}

TEST_F(MaplessNavigatorTest, IsDrivenByHandAndNotIntoWhatItSees) {
  posts_ = {{1.0, 0}};
  Make();
  for (int i = 0; i < 60; ++i) {
    ASSERT_TRUE(
        navigator_->Drive({.forward_mps = 0.5, .yaw_rate_radps = 0}).ok());
    Step(5);
    ASSERT_EQ(navigator_->mode(), behavior::NavigatorMode::kManual);
  }
  EXPECT_FALSE(touched_);
  EXPECT_GT(pose_.translation.x, 0.1);
  Step(20);
  EXPECT_EQ(navigator_->mode(), behavior::NavigatorMode::kIdle);
  EXPECT_EQ(base_.commands.back(), core::VelocityCommand());
}

TEST_F(MaplessNavigatorTest, AnotherPoseIsAnotherFrame) {
  Make();
  ASSERT_TRUE(
      navigator_->SetPose({.map_from_base = {{10, 0}, 0}, .place = {}}, {})
          .ok());
  Step(1);
  EXPECT_NEAR(navigator_->Snapshot().pose->pose.map_from_base.translation.x, 10,
              0.01);
  SetGoal({12, 0});
  Step(250);
  EXPECT_EQ(navigator_->goal()->state, behavior::GoalState::kSucceeded)
      << navigator_->goal()->why;
  EXPECT_NEAR(pose_.translation.x, 2, 0.2);
}

TEST_F(MaplessNavigatorTest, RefusesWhatMakesNoSense) {
  Make();
  EXPECT_FALSE(navigator_->SetGoal({}).ok());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(
      navigator_
          ->SetGoal({.poses = {{.map_from_base = {{nan, 0}, 0}, .place = {}}}})
          .ok());
  EXPECT_FALSE(
      navigator_->SetPose({.map_from_base = {{0, 0}, nan}, .place = {}}, {})
          .ok());
  MaplessOptions options;
  options.control_hz = 0;
  EXPECT_THAT(MakeMaplessNavigator(SmallRobot(), devices_, options, clock_)
                  .status()
                  .message(),
              HasSubstr("control_hz"));
}

TEST_F(MaplessNavigatorTest, AGoalThatIsWalledInFails) {
  for (int i = 0; i < 60; ++i) {
    const double angle_rad = 0.105 * i;
    posts_.push_back({0.2 + std::cos(angle_rad), std::sin(angle_rad)});
  }
  MaplessOptions options;
  options.patience_s = 5;
  Make(options);
  SetGoal({5, 0});
  Step(1600);
  EXPECT_EQ(navigator_->goal()->state, behavior::GoalState::kFailed);
  EXPECT_FALSE(touched_);
}

}  // namespace
}  // namespace treeline::mapless
