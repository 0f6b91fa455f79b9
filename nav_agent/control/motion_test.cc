// Limits, the collision guard, progress along a path, stuck_detector.
#include <cmath>
#include <limits>
#include <numbers>

#include "gtest/gtest.h"
#include "nav_agent/control/collision_guard.h"
#include "nav_agent/control/footprint.h"
#include "nav_agent/control/path_progress.h"
#include "nav_agent/control/stuck_detector.h"
#include "nav_agent/control/testing_floor.h"
#include "nav_agent/control/velocity_limits.h"

namespace treeline::control {
namespace {

const core::RobotModel kRobot;

// eband: no acceleration limit for differential drives.
TEST(VelocityLimits, AccelerationIsLimited) {
  const core::VelocityCommand start;
  const core::VelocityCommand next = LimitedVelocity(
      start, {.forward_mps = 5, .yaw_rate_radps = 9}, 0.025, kRobot);
  EXPECT_NEAR(next.forward_mps, 0.8 * 0.025, 1e-12);
  EXPECT_NEAR(next.yaw_rate_radps, 3.0 * 0.025, 1e-12);
  const core::VelocityCommand brakes = LimitedVelocity(
      {.forward_mps = 0.6, .yaw_rate_radps = 0}, {}, 0.025, kRobot);
  EXPECT_NEAR(brakes.forward_mps, 0.6 - 1.5 * 0.025, 1e-12);
  // Backwards only after it stood.
  EXPECT_EQ(
      LimitedVelocity({.forward_mps = 0.01, .yaw_rate_radps = 0},
                      {.forward_mps = -0.3, .yaw_rate_radps = 0}, 0.025, kRobot)
          .forward_mps,
      0);
  core::VelocityCommand fast = {.forward_mps = 0.8, .yaw_rate_radps = 0};
  for (int i = 0; i < 100; ++i) {
    fast = LimitedVelocity(fast, {.forward_mps = 5, .yaw_rate_radps = 0}, 0.025,
                           kRobot);
  }
  EXPECT_EQ(fast.forward_mps, kRobot.max_forward_mps);
  EXPECT_EQ(LimitedVelocity(
                {}, {.forward_mps = std::nan(""), .yaw_rate_radps = INFINITY},
                0.025, kRobot),
            core::VelocityCommand());
}

TEST(VelocityLimits, WhatBrakesTogetherStaysOnItsArc) {
  // It turns left as it creeps ahead, and its rear left corner hardly moves
  // back; if the way ahead ended first, it would by 1.4 cm a second.
  core::VelocityCommand command = {.forward_mps = 0.028,
                                   .yaw_rate_radps = 0.105};
  EXPECT_EQ(LimitedVelocity(command, {}, 0.025, kRobot).forward_mps, 0);
  for (int step = 0; step < 2; ++step) {
    const double corner_mps =
        command.forward_mps - command.yaw_rate_radps * kRobot.half_width_m;
    EXPECT_GT(corner_mps, -0.005);
    const core::VelocityCommand next =
        LimitedTogether(command, {}, 0.025, kRobot);
    EXPECT_NEAR(next.forward_mps * command.yaw_rate_radps,
                next.yaw_rate_radps * command.forward_mps, 1e-12);
    EXPECT_LE(command.yaw_rate_radps - next.yaw_rate_radps, 3.0 * 0.025 + 1e-9);
    command = next;
  }
  EXPECT_EQ(command, core::VelocityCommand());
  // The slower one sets the pace; backwards only after it stood.
  const core::VelocityCommand turns = LimitedTogether(
      {.forward_mps = 0.03, .yaw_rate_radps = 0},
      {.forward_mps = -0.03, .yaw_rate_radps = 0.05}, 0.025, kRobot);
  EXPECT_NEAR(turns.forward_mps, 0, 1e-12);
  EXPECT_NEAR(turns.yaw_rate_radps, 0.025, 1e-12);
  EXPECT_EQ(LimitedTogether({.forward_mps = NAN, .yaw_rate_radps = 0},
                            {.forward_mps = 0, .yaw_rate_radps = INFINITY},
                            0.025, kRobot),
            core::VelocityCommand());
}

TEST(LastCommands, LateMeasurementsDoNotHalveTheAcceleration) {
  LastCommands history;
  core::VelocityCommand command;
  // The base says what it did 50 ms ago.
  std::vector<core::VelocityCommand> told(2);
  double time_s = 0;
  for (int i = 0; i < 20; ++i, time_s += 0.025) {
    const auto start =
        history.StartAt(TestingTime(time_s), told[told.size() - 2], kRobot);
    command = LimitedVelocity(start.velocity,
                              {.forward_mps = 0.6, .yaw_rate_radps = 0},
                              start.interval_s, kRobot);
    history.Told(TestingTime(time_s), command);
    told.push_back(command);
  }
  EXPECT_NEAR(command.forward_mps, 20 * 0.8 * 0.025, 0.021);
  // Asked again in the same instant, it does not go up twice.
  const auto again = history.StartAt(TestingTime(time_s - 0.025),
                                     told[told.size() - 3], kRobot);
  EXPECT_LT(again.velocity.forward_mps, command.forward_mps);
  // What contradicts the measurement is not used.
  const auto pushed = history.StartAt(TestingTime(time_s), {}, kRobot);
  EXPECT_EQ(pushed.velocity.forward_mps, 0);
}

TEST(CollisionGuard, StopsBeforeAWallFromAnySpeedAndHeading) {
  const CollisionGuard guard(kRobot, {});
  const Footprint body = Footprint::Of(kRobot);
  for (const double heading_rad : {0.0, 0.4, -1.0}) {
    for (const double yaw_rate : {0.0, 0.5}) {
      geometry::Rigid2 at = {.translation = {0, 0}, .yaw_rad = heading_rad};
      core::VelocityCommand command;
      double nearest_m = 1;
      for (int step = 0; step < 400; ++step) {
        std::vector<GuardPoint> points;
        for (int i = -60; i <= 60; ++i) {
          const geometry::Vec2 post =
              at.Inverse() * geometry::Vec2{1.2, 0.02 * i};
          points.push_back({.in_base = post, .margin_m = 0.03});
          nearest_m = std::min(nearest_m, body.DistanceTo_m(post));
        }
        const core::VelocityCommand wanted = LimitedVelocity(
            command, {.forward_mps = 0.8, .yaw_rate_radps = yaw_rate}, 0.025,
            kRobot);
        const GuardVerdict verdict = guard.Check(wanted, points);
        command = verdict.is_limited
                      ? LimitedTogether(command, verdict.command, 0.025, kRobot)
                      : wanted;
        at = at * MotionIn(0.025, command);
      }
      EXPECT_GT(nearest_m, 0.01) << heading_rad << " " << yaw_rate;
    }
  }
}

TEST(CollisionGuard, AwayFromWhatTouchesTheMarginItMayAlwaysDrive) {
  const CollisionGuard guard(kRobot, {});
  // 1 cm before the front.
  const std::vector<GuardPoint> points = {
      {.in_base = {0.31, 0}, .margin_m = 0.03}};
  const core::VelocityCommand ahead = {.forward_mps = 0.1, .yaw_rate_radps = 0};
  EXPECT_EQ(guard.Check(ahead, points).command, core::VelocityCommand());
  const core::VelocityCommand back = {.forward_mps = -0.2, .yaw_rate_radps = 0};
  EXPECT_FALSE(guard.Check(back, points).is_limited);
  // The smallest command is too much, however often it is given.
  const core::VelocityCommand creep = {.forward_mps = 0.02,
                                       .yaw_rate_radps = 0};
  EXPECT_EQ(guard.Check(creep, points).command, core::VelocityCommand());
}

TEST(CollisionGuard, WhatMovesIsGivenMoreRoom) {
  const CollisionGuard guard(kRobot, {});
  const core::VelocityCommand ahead = {.forward_mps = 0.5, .yaw_rate_radps = 0};
  const GuardPoint stands = {.in_base = {0.8, 0}, .margin_m = 0.03};
  GuardPoint moves = stands;
  moves.approach_mps = 0.9;
  EXPECT_FALSE(guard.Check(ahead, {{stands}}).is_limited);
  const GuardVerdict verdict = guard.Check(ahead, {{moves}});
  EXPECT_TRUE(verdict.is_limited);
  EXPECT_TRUE(verdict.point_moves);
  EXPECT_LT(verdict.command.forward_mps, 0.35);
}

// Somebody's legs beside the front right corner: a turn to the left takes the
// corner away from them, and the front into the rest of whoever that is.
TEST(CollisionGuard, NoEdgeMovesOutBesideWhoMoves) {
  const CollisionGuard guard(kRobot, {});
  const GuardPoint legs = {.in_base = {0.34, -0.45},
                           .margin_m = 0.25,
                           .approach_mps = 0.9,
                           .is_of_body = true};
  EXPECT_EQ(guard.Check({0, 0.5}, {{legs}}).command, core::VelocityCommand());
  EXPECT_EQ(guard.Check({0, -0.5}, {{legs}}).command, core::VelocityCommand());
  EXPECT_EQ(guard.Check({0.2, 0}, {{legs}}).command, core::VelocityCommand());
  EXPECT_FALSE(guard.Check({-0.2, 0}, {{legs}}).is_limited);
  // Behind the rear left corner it may drive off, straight ahead.
  const GuardPoint behind = {.in_base = {-0.45, 0.45},
                             .margin_m = 0.35,
                             .approach_mps = 0.9,
                             .is_of_body = true};
  EXPECT_FALSE(guard.Check({0.3, 0}, {{behind}}).is_limited);
  EXPECT_EQ(guard.Check({0, 0.5}, {{behind}}).command, core::VelocityCommand());
  EXPECT_EQ(guard.Check({0, -0.5}, {{behind}}).command,
            core::VelocityCommand());
  EXPECT_EQ(guard.Check({-0.1, 0}, {{behind}}).command,
            core::VelocityCommand());
  // The same that stands still only keeps the robot from coming nearer.
  const GuardPoint stands = {.in_base = {0.34, -0.45}, .margin_m = 0.15};
  EXPECT_FALSE(guard.Check({0, 0.5}, {{stands}}).is_limited);
}

TEST(Footprint, OutwardSpeedIsOfTheEdgesNearAPoint) {
  const Footprint footprint = {
      .front_m = 0.3, .rear_m = 0.4, .half_width_m = 0.2};
  // Before the middle of the front, driving ahead and turning.
  EXPECT_NEAR(footprint.OutwardSpeed_mps({0.5, 0}, {0.4, 0}, 0.2), 0.5, 1e-12);
  EXPECT_EQ(footprint.OutwardSpeed_mps({-0.5, 0}, {0.4, 0}, 0.15), 0);
  EXPECT_NEAR(footprint.OutwardSpeed_mps({0, 1}, {0.4, 0}, 0.125), 0.075,
              1e-12);
  // Beside the rear: to the right it swings out to the left.
  EXPECT_NEAR(footprint.OutwardSpeed_mps({0, -1}, {-0.3, 0.3}, 0.1001), 0.3,
              0.01);
  EXPECT_EQ(footprint.OutwardSpeed_mps({0, 1}, {-0.3, 0.3}, 0.1001), 0);
  // Too far away.
  EXPECT_EQ(footprint.OutwardSpeed_mps({1, 1}, {0.6, 0}, 0.2), 0);
}

TEST(CollisionGuard, NaNStops) {
  const CollisionGuard guard(kRobot, {});
  const GuardVerdict verdict =
      guard.Check({.forward_mps = std::nan(""), .yaw_rate_radps = 0.1}, {});
  EXPECT_TRUE(verdict.is_limited);
  EXPECT_EQ(verdict.command, core::VelocityCommand());
}

TEST(PathProgress, StaysOnItsPartOfAPathThatComesByAgain) {
  std::vector<core::LevelPose> path;
  for (const geometry::Vec2 at :
       {geometry::Vec2{0, 0}, geometry::Vec2{4, 0}, geometry::Vec2{4, 0.4},
        geometry::Vec2{0, 0.4}}) {
    path.push_back({.map_from_base = {.translation = at}, .place = {}});
  }
  PathProgress progress;
  progress.SetPath(path);
  progress.Follow({.map_from_base = {.translation = {1, 0.25}}, .place = {}});
  EXPECT_NEAR(progress.along_m(), 1, 0.3);
  // Under it on another floor nothing happens.
  progress.Follow({.map_from_base = {.translation = {1.8, 0}},
                   .place = {.level = 1, .height_m = 3}});
  EXPECT_NEAR(progress.along_m(), 1, 0.3);
  EXPECT_NEAR(progress.length_m(), 8.4, 1e-9);
  EXPECT_NEAR(progress.At(5).map_from_base.translation.x, 3.4, 1e-9);
}

StuckDetectorInput StandingAt(double time_s) {
  StuckDetectorInput input;
  input.stamp = TestingTime(time_s);
  input.wants_to_move = true;
  return input;
}

TEST(StuckDetector, WaitsForWhatMovesButNotForever) {
  StuckDetector stuck_detector;
  bool waited = false;
  double blocked_s = 0;
  for (double time_s = 0; time_s < 10 && blocked_s == 0; time_s += 0.025) {
    StuckDetectorInput input = StandingAt(time_s);
    input.is_broken = true;
    input.obstacle_age_s = 0.1;
    const ControlState state = stuck_detector.Judge(input);
    waited |= state == ControlState::kWaiting;
    if (state == ControlState::kBlocked) blocked_s = time_s;
  }
  EXPECT_TRUE(waited);
  EXPECT_NEAR(blocked_s, 4.4, 0.2);
}

TEST(StuckDetector, WhatStandsBlocksAtOnceAndFlickeringDoesNot) {
  StuckDetector stuck_detector;
  double blocked_s = 0;
  for (double time_s = 0; time_s < 2 && blocked_s == 0; time_s += 0.025) {
    StuckDetectorInput input = StandingAt(time_s);
    input.is_broken = true;
    if (stuck_detector.Judge(input) == ControlState::kBlocked)
      blocked_s = time_s;
  }
  EXPECT_NEAR(blocked_s, 0.4, 0.05);
  StuckDetector flickers;
  for (int i = 0; i < 200; ++i) {
    StuckDetectorInput input = StandingAt(0.025 * i);
    // The robot gets on meanwhile.
    input.at.translation.x = 0.01 * i;
    input.is_broken = i % 20 < 2;
    input.obstacle_age_s = 0.1;
    EXPECT_EQ(flickers.Judge(input), ControlState::kDriving);
  }
}

TEST(StuckDetector, WhatHoldsItUnseenIsSaidInTheEnd) {
  StuckDetector stuck_detector;
  ControlState state = ControlState::kDriving;
  for (double time_s = 0; time_s < 12; time_s += 0.025) {
    state = stuck_detector.Judge(StandingAt(time_s));
  }
  EXPECT_EQ(state, ControlState::kBlocked);
}

}  // namespace
}  // namespace treeline::control
