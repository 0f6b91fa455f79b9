// Each velocity regulator alone, and their order.
#include "nav_agent/control/velocity_regulators.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/control/acceleration_regulator.h"
#include "nav_agent/control/collision_regulator.h"
#include "nav_agent/control/escape_regulator.h"
#include "nav_agent/control/pursuit_regulator.h"
#include "nav_agent/control/rounded_turn_regulator.h"
#include "nav_agent/control/sensor_regulator.h"
#include "nav_agent/control/speed_zone_regulator.h"
#include "nav_agent/control/testing_floor.h"
#include "nav_agent/control/wait_regulator.h"

namespace treeline::control {
namespace {

const core::RobotModel kRobot;

// A robot at (6, 6) on a floor, and what it may look at.
class Stage {
 public:
  explicit Stage(const TestingFloor& floor = {})
      : costmap_(*LocalCostmap::Make(floor.Map(), kRobot,
                                     {.front = TestingLaser()}, {})),
        guard_(kRobot, {}),
        pose_(TestingPose(6, 6)) {
    costmap_.MoveTo(pose_);
    costmap_.Update(pose_.stamp);
  }

  ControlPose& pose() { return pose_; }
  std::vector<GuardPoint>& points() { return points_; }
  const CollisionGuard& guard() const { return guard_; }
  RegulatorInput Input() const {
    return {.pose = pose_,
            .costmap = costmap_,
            .guard = guard_,
            .points = points_,
            .start = {.velocity = {.forward_mps = pose_.forward_mps,
                                   .yaw_rate_radps = pose_.yaw_rate_radps},
                      .interval_s = 0.025},
            .sees = true};
  }

 private:
  LocalCostmap costmap_;
  CollisionGuard guard_;
  ControlPose pose_;
  std::vector<GuardPoint> points_;
};

RegulatedVelocity Of(const core::VelocityCommand& velocity) {
  return {.velocity = velocity, .wanted = velocity};
}

// Along x from (6, 6).
std::vector<TrackPoint> TrackAhead() {
  std::vector<TrackPoint> track;
  for (int i = 0; i <= 40; ++i) track.push_back({.in_map = {6 + 0.05 * i, 6}});
  return track;
}

const std::vector<GuardPoint> kPostAhead = {
    {.in_base = {0.33, 0}, .margin_m = 0.04}};

TEST(VelocityRegulators, WorkInTheirStatedOrder) {
  const std::vector<std::string> order = {
      "approach",   "pursuit", "escape",       "rounded_turn", "wait",
      "speed_zone", "sensors", "acceleration", "collision"};
  EXPECT_EQ(VelocityRegulators(kRobot, {}).Names(), order);
}

TEST(VelocityRegulators, EachCanBeSwitchedOff) {
  const std::vector<std::string> order = VelocityRegulators(kRobot, {}).Names();
  const std::vector<bool VelocityRegulatorSwitches::*> switches = {
      &VelocityRegulatorSwitches::approach,
      &VelocityRegulatorSwitches::pursuit,
      &VelocityRegulatorSwitches::escape,
      &VelocityRegulatorSwitches::rounded_turn,
      &VelocityRegulatorSwitches::wait,
      &VelocityRegulatorSwitches::speed_zone,
      &VelocityRegulatorSwitches::sensors,
      &VelocityRegulatorSwitches::acceleration,
      &VelocityRegulatorSwitches::collision};
  ASSERT_EQ(switches.size(), order.size());
  for (size_t i = 0; i < switches.size(); ++i) {
    VelocityRegulatorsOptions options;
    options.switches.*switches[i] = false;
    std::vector<std::string> others = order;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    EXPECT_EQ(VelocityRegulators(kRobot, options).Names(), others);
  }
}

TEST(VelocityRegulators, DriveAlongATrackAndStopBeforeAPost) {
  Stage stage;
  const std::vector<TrackPoint> track = TrackAhead();
  RegulatorInput input = stage.Input();
  input.track = track;
  VelocityRegulators regulators(kRobot, {});
  RegulatedVelocity regulated = regulators.Drive(input);
  EXPECT_EQ(regulated.wanted.forward_mps, 0.6);
  EXPECT_NEAR(regulated.velocity.forward_mps, 0.8 * 0.025, 1e-12);
  EXPECT_FALSE(regulated.is_limited);
  input.points = kPostAhead;
  regulated = regulators.Drive(input);
  EXPECT_EQ(regulated.velocity, core::VelocityCommand());
  EXPECT_TRUE(regulated.is_limited);
  VelocityRegulatorsOptions careless;
  careless.switches.collision = false;
  regulated = VelocityRegulators(kRobot, careless).Drive(input);
  EXPECT_GT(regulated.velocity.forward_mps, 0);
}

TEST(VelocityRegulators, AllowACommandOfSomebodyElse) {
  Stage stage;
  VelocityRegulators regulators(kRobot, {});
  const core::VelocityCommand back = {.forward_mps = -0.2, .yaw_rate_radps = 0};
  EXPECT_NEAR(regulators.Allow(stage.Input(), back).velocity.forward_mps,
              -0.8 * 0.025, 1e-12);
  stage.points() = kPostAhead;
  const core::VelocityCommand ahead = {.forward_mps = 0.2, .yaw_rate_radps = 0};
  EXPECT_EQ(regulators.Allow(stage.Input(), ahead).velocity,
            core::VelocityCommand());
}

TEST(ApproachRegulator, ArrivesWithinTheTolerancesFromManyPlaces) {
  for (const double x : {-0.15, -0.05, 0.08}) {
    for (const double y : {-0.1, 0.0, 0.15}) {
      for (const double yaw : {-3.0, -0.5, 0.0, 1.6}) {
        Stage stage;
        ApproachRegulator approach(kRobot,
                                   {.tolerance_m = 0.1, .tolerance_rad = 0.15});
        const geometry::Rigid2 goal = {.translation = {6, 6}, .yaw_rad = 0.3};
        geometry::Rigid2& at = stage.pose().pose.map_from_base;
        at = {.translation = {6 + x, 6 + y}, .yaw_rad = yaw};
        RegulatedVelocity regulated;
        for (int step = 0; step < 800; ++step) {
          RegulatorInput input = stage.Input();
          input.goal = GoalAhead{.map_from_goal = goal, .left_m = 0.1};
          const core::VelocityCommand before = regulated.velocity;
          regulated = {};
          approach.Regulate(input, regulated);
          ASSERT_TRUE(regulated.is_near_goal);
          regulated.velocity =
              LimitedVelocity(before, regulated.velocity, 0.025, kRobot);
          at = at * MotionIn(0.025, regulated.velocity);
        }
        EXPECT_TRUE(regulated.is_at_goal) << x << " " << y << " " << yaw;
        EXPECT_LT(geometry::Norm(at.translation - goal.translation), 0.1);
        EXPECT_LT(std::abs(geometry::NormalizedAngle_rad(at.yaw_rad - 0.3)),
                  0.15);
        EXPECT_EQ(regulated.velocity, core::VelocityCommand());
      }
    }
  }
}

TEST(ApproachRegulator, FarFromTheGoalItChangesNothing) {
  const Stage stage;
  ApproachRegulator approach(kRobot, {});
  RegulatorInput input = stage.Input();
  RegulatedVelocity regulated = Of({.forward_mps = 0.4, .yaw_rate_radps = 0});
  approach.Regulate(input, regulated);
  // It comes by the goal, which is a long way off along the path.
  input.goal =
      GoalAhead{.map_from_goal = {.translation = {6.1, 6}}, .left_m = 5};
  approach.Regulate(input, regulated);
  EXPECT_EQ(regulated.velocity.forward_mps, 0.4);
  EXPECT_FALSE(regulated.is_near_goal);
}

TEST(PursuitRegulator, TurnsOnTheSpotTowardsALineBehindIt) {
  Stage stage;
  stage.pose().pose.map_from_base.yaw_rad = std::numbers::pi - 0.1;
  const std::vector<TrackPoint> track = TrackAhead();
  RegulatorInput input = stage.Input();
  input.track = track;
  PursuitRegulator pursuit(kRobot, {});
  RegulatedVelocity regulated;
  pursuit.Regulate(input, regulated);
  EXPECT_EQ(regulated.velocity.forward_mps, 0);
  EXPECT_LT(regulated.velocity.yaw_rate_radps, -0.5);
  // Off by more than it would begin to turn for, and less than it ends at.
  stage.pose().pose.map_from_base.yaw_rad = 0.6;
  regulated = {};
  pursuit.Regulate(input, regulated);
  EXPECT_EQ(regulated.velocity.forward_mps, 0);
  pursuit.Reset();
  pursuit.Regulate(input, regulated);
  EXPECT_GT(regulated.velocity.forward_mps, 0);
}

TEST(PursuitRegulator, LeavesARobotNearItsGoalAlone) {
  const Stage stage;
  const std::vector<TrackPoint> track = TrackAhead();
  RegulatorInput input = stage.Input();
  input.track = track;
  RegulatedVelocity regulated;
  regulated.is_near_goal = true;
  PursuitRegulator(kRobot, {}).Regulate(input, regulated);
  EXPECT_EQ(regulated.velocity, core::VelocityCommand());
}

// A bench beside its rear right corner: it may not turn left, where its track
// leads, nor may it back up; 20 cm further ahead it may turn.
TEST(EscapeRegulator, DrivesOnToWhereItMayTurn) {
  TestingFloor floor;
  floor.Fill({4.5, 5.2}, {5.85, 5.65}, core::Occupancy::kOccupied);
  Stage stage(floor);
  for (double x_m = -1; x_m < -0.16; x_m += 0.05) {
    stage.points().push_back({.in_base = {x_m, -0.345}, .margin_m = 0.035});
  }
  std::vector<TrackPoint> track;
  for (double s_m = 0; s_m < 1.5; s_m += 0.1) {
    track.push_back({.in_map = {6 + 0.75 * s_m, 6 + 0.65 * s_m}});
  }
  RegulatorInput input = stage.Input();
  input.track = track;
  const core::VelocityCommand wanted = {.forward_mps = 0,
                                        .yaw_rate_radps = 1.0};
  ASSERT_TRUE(stage.guard().Check({0, 0.35}, stage.points()).is_limited);
  EscapeRegulator escape{core::RobotModel()};
  RegulatedVelocity regulated = Of(wanted);
  escape.Regulate(input, regulated);
  EXPECT_EQ(regulated.velocity, wanted);
  EXPECT_FALSE(regulated.escapes);
  input.should_escape = true;
  escape.Regulate(input, regulated);
  EXPECT_TRUE(regulated.escapes);
  EXPECT_GT(regulated.velocity.forward_mps, 0);
  EXPECT_FALSE(
      stage.guard().Check(regulated.velocity, stage.points()).is_limited);
}

// A post beside its rear right corner: to the left, where its track leads, it
// drives past it with a whole arc, but the arc's first centimetre is nearer.
TEST(EscapeRegulator, TakesNoMoveThatMayNotBegin) {
  TestingFloor floor;
  floor.Fill({5.6, 5.6}, {5.7, 5.66}, core::Occupancy::kOccupied);
  Stage stage(floor);
  stage.points().push_back({.in_base = {-0.312, -0.358}, .margin_m = 0.06});
  const core::VelocityCommand arc = {.forward_mps = 0.15,
                                     .yaw_rate_radps = 0.349};
  const core::VelocityCommand first =
      LimitedTogether({}, arc, 0.025, core::RobotModel());
  ASSERT_FALSE(stage.guard().Check(arc, stage.points()).is_limited);
  ASSERT_TRUE(stage.guard().Check(first, stage.points()).is_limited);
  std::vector<TrackPoint> track;
  for (double s_m = 0; s_m < 1.5; s_m += 0.1) {
    track.push_back({.in_map = {6 + 0.4 * s_m, 6 + 0.9 * s_m}});
  }
  RegulatorInput input = stage.Input();
  input.track = track;
  input.should_escape = true;
  EscapeRegulator escape{core::RobotModel()};
  RegulatedVelocity regulated = Of({.forward_mps = 0, .yaw_rate_radps = 1.0});
  escape.Regulate(input, regulated);
  EXPECT_NE(regulated.velocity, arc);
  EXPECT_GT(regulated.velocity.forward_mps, 0);
  EXPECT_FALSE(stage.guard()
                   .Check(LimitedTogether({}, regulated.velocity, 0.025,
                                          core::RobotModel()),
                          stage.points())
                   .is_limited);
}

TEST(RoundedTurnRegulator, SweepsNothingBackAmongPeople) {
  const Stage stage;
  RoundedTurnRegulator rounded(kRobot);
  const core::VelocityCommand turn = {.forward_mps = 0, .yaw_rate_radps = 0.5};
  RegulatorInput input = stage.Input();
  RegulatedVelocity regulated = Of(turn);
  rounded.Regulate(input, regulated);
  EXPECT_EQ(regulated.velocity, turn);
  input.people_are_about = true;
  rounded.Regulate(input, regulated);
  EXPECT_GE(regulated.velocity.forward_mps,
            kRobot.half_width_m * regulated.velocity.yaw_rate_radps);
  EXPECT_GT(regulated.velocity.yaw_rate_radps, 0);
  // It has to turn at its goal, and while it escapes.
  for (bool RegulatedVelocity::*reason :
       {&RegulatedVelocity::is_turning_at_goal, &RegulatedVelocity::escapes}) {
    regulated = Of(turn);
    regulated.*reason = true;
    rounded.Regulate(input, regulated);
    EXPECT_EQ(regulated.velocity, turn);
  }
}

TEST(RoundedTurnRegulator, TurnsOnTheSpotWhereThereIsNoRoom) {
  TestingFloor floor;
  floor.Fill({6.4, 0}, {6.45, 12}, core::Occupancy::kOccupied);
  const Stage stage(floor);
  RegulatorInput input = stage.Input();
  input.people_are_about = true;
  const core::VelocityCommand turn = {.forward_mps = 0, .yaw_rate_radps = 0.5};
  RegulatedVelocity regulated = Of(turn);
  RoundedTurnRegulator(kRobot).Regulate(input, regulated);
  EXPECT_EQ(regulated.velocity, turn);
}

TEST(WaitRegulator, WhoWaitsStandsAndStillWants) {
  const Stage stage;
  RegulatorInput input = stage.Input();
  const core::VelocityCommand ahead = {.forward_mps = 0.4,
                                       .yaw_rate_radps = 0.1};
  RegulatedVelocity regulated = Of(ahead);
  WaitRegulator().Regulate(input, regulated);
  EXPECT_EQ(regulated.velocity, ahead);
  input.should_wait = true;
  WaitRegulator().Regulate(input, regulated);
  EXPECT_EQ(regulated.velocity, core::VelocityCommand());
  EXPECT_EQ(regulated.wanted, ahead);
  EXPECT_TRUE(regulated.waits);
  regulated = {};
  regulated.is_at_goal = true;
  WaitRegulator().Regulate(input, regulated);
  EXPECT_FALSE(regulated.waits);
}

TEST(SpeedZoneRegulator, SlowsAnyCommandDownAlongItsArc) {
  const Stage stage;
  RegulatorInput input = stage.Input();
  RegulatedVelocity regulated = Of({.forward_mps = 0.6, .yaw_rate_radps = 0.3});
  SpeedZoneRegulator().Regulate(input, regulated);
  EXPECT_EQ(regulated.velocity.forward_mps, 0.6);
  input.max_mps = 0.2;
  SpeedZoneRegulator().Regulate(input, regulated);
  EXPECT_NEAR(regulated.velocity.forward_mps, 0.2, 1e-12);
  EXPECT_NEAR(regulated.velocity.yaw_rate_radps, 0.1, 1e-12);
  regulated = Of({.forward_mps = -0.4, .yaw_rate_radps = 0});
  SpeedZoneRegulator().Regulate(input, regulated);
  EXPECT_NEAR(regulated.velocity.forward_mps, -0.2, 1e-12);
  // It turns on the spot as it likes.
  regulated = Of({.forward_mps = 0, .yaw_rate_radps = 1});
  SpeedZoneRegulator().Regulate(input, regulated);
  EXPECT_EQ(regulated.velocity.yaw_rate_radps, 1);
}

TEST(SensorRegulator, WhoDoesNotSeeStops) {
  const Stage stage;
  RegulatorInput input = stage.Input();
  const core::VelocityCommand ahead = {.forward_mps = 0.4, .yaw_rate_radps = 0};
  RegulatedVelocity regulated = Of(ahead);
  SensorRegulator().Regulate(input, regulated);
  EXPECT_EQ(regulated.velocity, ahead);
  EXPECT_FALSE(regulated.must_stop);
  input.sees = false;
  SensorRegulator().Regulate(input, regulated);
  EXPECT_EQ(regulated.velocity, core::VelocityCommand());
  EXPECT_TRUE(regulated.must_stop);
  EXPECT_TRUE(regulated.is_limited);
  input.sees = true;
  regulated = Of({.forward_mps = std::nan(""), .yaw_rate_radps = 0});
  SensorRegulator().Regulate(input, regulated);
  EXPECT_TRUE(regulated.must_stop);
}

TEST(AccelerationRegulator, BrakesAlongItsArcWhereItMustStop) {
  Stage stage;
  stage.pose().forward_mps = 0.3;
  stage.pose().yaw_rate_radps = 0.3;
  AccelerationRegulator acceleration(kRobot);
  RegulatedVelocity regulated = Of({.forward_mps = 5, .yaw_rate_radps = 0});
  acceleration.Regulate(stage.Input(), regulated);
  EXPECT_NEAR(regulated.velocity.forward_mps, 0.3 + 0.8 * 0.025, 1e-12);
  EXPECT_NEAR(regulated.velocity.yaw_rate_radps, 0.3 - 3.0 * 0.025, 1e-12);
  regulated = {};
  regulated.must_stop = true;
  acceleration.Regulate(stage.Input(), regulated);
  // 1.5 m/s^2 is slower than 3 rad/s^2 for the same share.
  EXPECT_NEAR(regulated.velocity.forward_mps, 0.3 - 1.5 * 0.025, 1e-12);
  EXPECT_NEAR(regulated.velocity.yaw_rate_radps, regulated.velocity.forward_mps,
              1e-12);
}

TEST(CollisionRegulator, SaysWhatForbidsACommand) {
  Stage stage;
  stage.points() = kPostAhead;
  CollisionRegulator collision(kRobot);
  RegulatedVelocity regulated = Of({.forward_mps = 0.1, .yaw_rate_radps = 0});
  collision.Regulate(stage.Input(), regulated);
  EXPECT_EQ(regulated.velocity, core::VelocityCommand());
  EXPECT_TRUE(regulated.is_limited);
  ASSERT_TRUE(regulated.point_in_map.has_value());
  EXPECT_NEAR(regulated.point_in_map->x, 6.33, 1e-9);
  EXPECT_FALSE(regulated.point_moves);
  regulated = Of({.forward_mps = -0.1, .yaw_rate_radps = 0});
  collision.Regulate(stage.Input(), regulated);
  EXPECT_EQ(regulated.velocity.forward_mps, -0.1);
  EXPECT_FALSE(regulated.is_limited);
}

// Turning is accelerated faster, so an arc begins as a tighter one.
TEST(CollisionRegulator, KeepsToAnArcWhereATighterOneHasNoRoom) {
  Stage stage;
  // The right rear corner would swing into it; along the arc it moves away.
  stage.points().push_back({.in_base = {-0.29, -0.34}, .margin_m = 0.04});
  AccelerationRegulator acceleration(kRobot);
  CollisionRegulator collision(kRobot);
  const RegulatorInput input = stage.Input();
  RegulatedVelocity regulated =
      Of({.forward_mps = 0.6, .yaw_rate_radps = 0.05});
  acceleration.Regulate(input, regulated);
  ASSERT_TRUE(
      stage.guard().Check(regulated.velocity, stage.points()).is_limited);
  collision.Regulate(input, regulated);
  EXPECT_FALSE(regulated.is_limited);
  EXPECT_GT(regulated.velocity.forward_mps, 0);
  EXPECT_NEAR(
      regulated.velocity.yaw_rate_radps / regulated.velocity.forward_mps,
      0.05 / 0.6, 1e-9);
}

TEST(CollisionRegulator, LooksWhetherOneThatWaitsCouldSetOff) {
  Stage stage;
  CollisionRegulator collision(kRobot);
  RegulatedVelocity regulated = Of({.forward_mps = 0.6, .yaw_rate_radps = 0});
  regulated.waits = true;
  regulated.velocity = {};
  collision.Regulate(stage.Input(), regulated);
  EXPECT_FALSE(regulated.is_limited);
  stage.points() = kPostAhead;
  collision.Regulate(stage.Input(), regulated);
  EXPECT_TRUE(regulated.is_limited);
  EXPECT_TRUE(regulated.point_in_map.has_value());
  // At its full speed it could not stop before this one; at a slow one it can.
  regulated = Of({.forward_mps = 0.6, .yaw_rate_radps = 0});
  regulated.waits = true;
  regulated.velocity = {};
  stage.points() = {{.in_base = {0.5, 0}, .margin_m = 0.04}};
  EXPECT_TRUE(stage.guard().Check(regulated.wanted, stage.points()).is_limited);
  collision.Regulate(stage.Input(), regulated);
  EXPECT_FALSE(regulated.is_limited);
}

}  // namespace
}  // namespace treeline::control
