#include "nav_agent/control/local_controller.h"

#include <cmath>
#include <limits>

#include "gtest/gtest.h"
#include "nav_agent/control/footprint.h"
#include "nav_agent/control/testing_floor.h"

namespace treeline::control {
namespace {

// A robot that does exactly what it is told, on a testing floor.
class Drive {
 public:
  Drive(const TestingFloor& floor, const ControlPose& start,
        std::function<bool(geometry::Vec2)> is_solid, bool looks_back = false)
      : controller_(*LocalController::Make(
            floor.Map(), core::RobotModel(),
            {.front = TestingLaser(),
             .rear = looks_back ? std::optional(TestingLaser()) : std::nullopt},
            {})),
        looks_back_(looks_back),
        pose_(start),
        is_solid_(std::move(is_solid)) {}

  LocalController& controller() { return *controller_; }
  ControlPose& pose() { return pose_; }
  void Goto(geometry::Vec2 goal, double yaw_rad = 0) {
    core::LevelPose end;
    end.map_from_base = {.translation = goal, .yaw_rad = yaw_rad};
    controller_->SetPath({pose_.pose, end});
  }
  // Time passes, and the lasers scan.
  void Look() {
    pose_.stamp += std::chrono::milliseconds(25);
    EXPECT_TRUE(
        controller_->AddScan(pose_, TestingScan(pose_, is_solid_)).ok());
    if (!looks_back_) return;
    const core::LaserScan rear =
        TestingScan(pose_, is_solid_, core::LaserMount::kRear);
    EXPECT_TRUE(controller_->AddRearScan(pose_, rear).ok());
  }
  // A recovery's command, as far as it is allowed.
  void Guarded(const core::VelocityCommand& wanted) {
    Look();
    Obey(controller_->Guard(pose_, wanted));
  }
  // The same; approach: null, or what it drives up to.
  void Creep(const CloseApproach* approach,
             const core::VelocityCommand& wanted) {
    Look();
    Obey(approach == nullptr
             ? controller_->Guard(pose_, wanted)
             : controller_->GuardUpTo(*approach, pose_, wanted));
  }
  ControlResult Step() {
    Look();
    const ControlResult result = controller_->Step(pose_);
    const double dv = result.command.forward_mps - pose_.forward_mps;
    EXPECT_LE(dv, 0.8 * 0.025 + 1e-9);
    EXPECT_GE(dv, -1.5 * 0.025 - 1e-9);
    EXPECT_LE(std::abs(result.command.yaw_rate_radps - pose_.yaw_rate_radps),
              3.0 * 0.025 + 1e-9);
    Obey(result.command);
    return result;
  }
  // Until this state, or not.
  bool Until(ControlState state, double seconds) {
    for (int i = 0; i < static_cast<int>(40 * seconds); ++i) {
      last_ = Step();
      if (last_.state == state) return true;
    }
    return false;
  }
  const ControlResult& last() const { return last_; }

 private:
  void Obey(const core::VelocityCommand& command) {
    pose_.forward_mps = command.forward_mps;
    pose_.yaw_rate_radps = command.yaw_rate_radps;
    pose_.pose.map_from_base =
        pose_.pose.map_from_base * MotionIn(0.025, command);
  }

  std::unique_ptr<LocalController> controller_;
  bool looks_back_;
  ControlPose pose_;
  std::function<bool(geometry::Vec2)> is_solid_;
  ControlResult last_;
};

TEST(LocalController, DrivesToAGoalAndStandsThere) {
  Drive drive(TestingFloor(), TestingPose(3, 6), NothingThere);
  drive.Goto({7, 6.5}, 1.0);
  EXPECT_TRUE(drive.Until(ControlState::kArrived, 12));
  const geometry::Rigid2 at = drive.pose().pose.map_from_base;
  EXPECT_LT(geometry::Norm(at.translation - geometry::Vec2{7, 6.5}), 0.1);
  EXPECT_LT(std::abs(at.yaw_rad - 1.0), 0.15);
  EXPECT_EQ(drive.pose().forward_mps, 0);
}

// eband: the goal was reached however fast the robot still was.
TEST(LocalController, AGoalIsNotReachedWhileItMoves) {
  Drive drive(TestingFloor(), TestingPose(3, 6), NothingThere);
  drive.Goto({4, 6});
  drive.pose().pose.map_from_base.translation = {3.99, 6};
  drive.pose().forward_mps = 0.5;
  EXPECT_NE(drive.Step().state, ControlState::kArrived);
  EXPECT_TRUE(drive.Until(ControlState::kArrived, 8));
  EXPECT_LT(std::abs(drive.pose().forward_mps), 0.02);
  EXPECT_LT(geometry::Norm(drive.pose().pose.map_from_base.translation -
                           geometry::Vec2{4, 6}),
            0.1);
}

// Creeps on for 10 s; how near the front has come to a thing at x = 5 m.
double GapAfterCreeping_m(Drive& drive, const CloseApproach* approach) {
  for (int i = 0; i < 400; ++i) {
    drive.Creep(approach, {.forward_mps = 0.1, .yaw_rate_radps = 0});
  }
  return 5 - 0.3 - drive.pose().pose.map_from_base.translation.x;
}

// A dock: a box that no map has. Without leave it is kept off as all new things
// are.
TEST(LocalController, ComesUpToItsDockAndDoesNotTouchIt) {
  const auto dock = TestingBox({5, 5.7}, {5.3, 6.3});
  const CloseApproach approach = {.map_from_docked = {{4.7, 6}, 0}};
  Drive kept_off(TestingFloor(), TestingPose(4, 6), dock);
  EXPECT_GT(GapAfterCreeping_m(kept_off, nullptr), 0.1);
  Drive close(TestingFloor(), TestingPose(4, 6), dock);
  const double gap_m = GapAfterCreeping_m(close, &approach);
  EXPECT_LT(gap_m, 0.02);
  EXPECT_GE(gap_m, 0);
}

TEST(LocalController, SomebodyBeforeItsDockIsKeptOffAsEverywhere) {
  const auto dock = TestingBox({5, 5.7}, {5.3, 6.3});
  const auto legs = TestingBox({4.75, 5.9}, {4.85, 6.1});
  const CloseApproach approach = {.map_from_docked = {{4.7, 6}, 0}};
  Drive drive(TestingFloor(), TestingPose(3.8, 6),
              [&](geometry::Vec2 at) { return dock(at) || legs(at); });
  EXPECT_GT(GapAfterCreeping_m(drive, &approach), 0.25 + 0.1);
}

TEST(LocalController, DrivesAroundACrateOnItsPath) {
  Drive drive(TestingFloor(), TestingPose(3, 6),
              TestingBox({5, 5.7}, {5.5, 6.2}));
  drive.Goto({8, 6});
  double nearest_m = 1;
  for (int i = 0; i < 40 * 25; ++i) {
    const ControlResult result = drive.Step();
    for (const geometry::Vec2 corner :
         {geometry::Vec2{5, 5.7}, geometry::Vec2{5, 6.2},
          geometry::Vec2{5.5, 5.7}, geometry::Vec2{5.5, 6.2}}) {
      nearest_m =
          std::min(nearest_m,
                   Footprint::Of(core::RobotModel())
                       .DistanceTo_m(drive.pose().pose.map_from_base.Inverse() *
                                     corner));
    }
    if (result.state == ControlState::kArrived) break;
    EXPECT_NE(result.state, ControlState::kBlocked);
  }
  EXPECT_GT(nearest_m, 0.02);
  EXPECT_LT(geometry::Norm(drive.pose().pose.map_from_base.translation -
                           geometry::Vec2{8, 6}),
            0.1);
}

// What is behind the robot no sensor shows.
TEST(LocalController, AmongPeopleItsRearEdgeDoesNotSweepBack) {
  double time_s = 0;
  Drive* robot = nullptr;
  // Somebody walks to and fro 1.6 m before it, wherever that is.
  const auto somebody = [&](geometry::Vec2 at) {
    const geometry::Rigid2& map_from_base = robot->pose().pose.map_from_base;
    return geometry::Norm(map_from_base.Inverse() * at -
                          geometry::Vec2{1.6, 0.8 * std::sin(time_s)}) < 0.15;
  };
  Drive drive(TestingFloor(), TestingPose(6, 6), somebody);
  robot = &drive;
  for (; time_s < 1; time_s += 0.025) drive.Step();
  EXPECT_LT(drive.controller().QuietFor_s(drive.pose().stamp), 0.1);
  drive.Goto({4, 6.2}, 3.14);
  double turned_rad = 0;
  double swept_m = 0;
  for (int i = 0; i < 40 * 6; ++i, time_s += 0.025) {
    drive.Step();
    const double turn_radps = std::abs(drive.pose().yaw_rate_radps);
    turned_rad += 0.025 * turn_radps;
    swept_m +=
        0.025 * std::max(0.0, core::RobotModel().half_width_m * turn_radps -
                                  drive.pose().forward_mps);
  }
  EXPECT_GT(turned_rad, 1.5);
  // A turn on the spot: 0.31 m for each radian.
  EXPECT_LT(swept_m, 0.05);
}

// How far the robot's rear edge is from somebody who comes up from 3 m behind
// at 0.8 m/s, up to `until_m` behind its middle, when it has backed up for 5 s.
double GapAfterBackingUp_m(bool looks_back) {
  double middle_m = -3;
  Drive drive(
      TestingFloor(), TestingPose(6, 6),
      [&](geometry::Vec2 at) {
        return geometry::Norm(at - geometry::Vec2{6 + middle_m, 6}) < 0.15;
      },
      looks_back);
  double gap_m = 3;
  for (int i = 0; i < 40 * 5; ++i) {
    middle_m = std::min(-1.3, middle_m + 0.8 * 0.025);
    drive.Guarded({.forward_mps = -0.2, .yaw_rate_radps = 0});
    const double rear_m = drive.pose().pose.map_from_base.translation.x -
                          core::RobotModel().rear_m;
    gap_m = std::min(gap_m, rear_m - (6 + middle_m + 0.15));
  }
  return gap_m;
}

TEST(LocalController, ARearLaserShowsWhoComesUpBehind) {
  const double gap_m = GapAfterBackingUp_m(true);
  EXPECT_GT(gap_m, 0.1);
  EXPECT_LT(gap_m, 0.4);
  EXPECT_LT(GapAfterBackingUp_m(false), 0);
}

TEST(LocalController, WhoSeesBehindTurnsOnTheSpotAmongPeople) {
  double time_s = 0;
  Drive* robot = nullptr;
  const auto somebody = [&](geometry::Vec2 at) {
    const geometry::Rigid2& map_from_base = robot->pose().pose.map_from_base;
    return geometry::Norm(map_from_base.Inverse() * at -
                          geometry::Vec2{1.6, 0.8 * std::sin(time_s)}) < 0.15;
  };
  Drive drive(TestingFloor(), TestingPose(6, 6), somebody, true);
  robot = &drive;
  for (; time_s < 1; time_s += 0.025) drive.Step();
  EXPECT_EQ(drive.controller().QuietFor_s(drive.pose().stamp),
            std::numeric_limits<double>::infinity());
  drive.Goto({4, 6.2}, 3.14);
  for (int i = 0; i < 40; ++i, time_s += 0.025) {
    EXPECT_LT(drive.Step().command.forward_mps, 0.01);
  }
  EXPECT_GT(drive.pose().pose.map_from_base.yaw_rad, 0.5);
}

TEST(LocalController, ARearLaserThatIsSilentStopsIt) {
  Drive drive(TestingFloor(), TestingPose(3, 6), NothingThere, true);
  drive.Goto({9, 6});
  for (int i = 0; i < 80; ++i) drive.Step();
  EXPECT_GT(drive.pose().forward_mps, 0.5);
  ControlPose pose = drive.pose();
  for (int i = 0; i < 40; ++i) {
    pose.stamp += std::chrono::milliseconds(25);
    ASSERT_TRUE(
        drive.controller().AddScan(pose, TestingScan(pose, NothingThere)).ok());
    pose.forward_mps = drive.controller().Step(pose).command.forward_mps;
  }
  EXPECT_EQ(pose.forward_mps, 0);
}

// Whatever a driver states of its laser.
TEST(LocalController, DrivesByNoScanThatIsOlderThanASecond) {
  core::RangeSensorInfo absurd = TestingLaser();
  absurd.scan_interval_s = 1000;
  const auto controller = *LocalController::Make(
      TestingFloor().Map(), core::RobotModel(), {.front = absurd}, {});
  ControlPose pose = TestingPose(3, 6);
  core::LevelPose goal;
  goal.map_from_base.translation = {9, 6};
  controller->SetPath({pose.pose, goal});
  ASSERT_TRUE(controller->AddScan(pose, TestingScan(pose, NothingThere)).ok());
  double fastest_mps = 0;
  const auto step = [&] {
    pose.stamp += std::chrono::milliseconds(25);
    const core::VelocityCommand command = controller->Step(pose).command;
    pose.forward_mps = command.forward_mps;
    pose.yaw_rate_radps = command.yaw_rate_radps;
    pose.pose.map_from_base =
        pose.pose.map_from_base * MotionIn(0.025, command);
    fastest_mps = std::max(fastest_mps, command.forward_mps);
    return command;
  };
  for (int i = 0; i < 36; ++i) step();
  EXPECT_GT(fastest_mps, 0.1);
  core::VelocityCommand last;
  for (int i = 0; i < 60; ++i) last = step();
  EXPECT_EQ(last, core::VelocityCommand());
}

// Of a laser that turns five times a second a scan is 0.2 s old when it comes,
// and 0.4 s when the next one does.
TEST(LocalController, ASlowLaserDoesNotMakeItStandBetweenScans) {
  core::RangeSensorInfo slow = TestingLaser();
  slow.scan_interval_s = 0.2;
  const auto controller = *LocalController::Make(
      TestingFloor().Map(), core::RobotModel(), {.front = slow}, {});
  ControlPose pose = TestingPose(3, 6);
  core::LevelPose goal;
  goal.map_from_base.translation = {9, 6};
  controller->SetPath({pose.pose, goal});
  constexpr int kStepsAScan = 8;
  ControlPose then = pose;
  double slowest_mps = 1;
  const auto step = [&](int i) {
    pose.stamp += std::chrono::milliseconds(25);
    if (i % kStepsAScan == 0) {
      EXPECT_TRUE(
          controller->AddScan(then, TestingScan(then, NothingThere)).ok());
      then = pose;
    }
    const core::VelocityCommand command = controller->Step(pose).command;
    pose.forward_mps = command.forward_mps;
    pose.yaw_rate_radps = command.yaw_rate_radps;
    pose.pose.map_from_base =
        pose.pose.map_from_base * MotionIn(0.025, command);
    return command.forward_mps;
  };
  int i = 0;
  for (; i < 120; ++i) step(i);
  for (; i < 240; ++i) slowest_mps = std::min(slowest_mps, step(i));
  EXPECT_GT(slowest_mps, 0.4);
  // It is silent: 2.5 scans later the robot brakes.
  for (int silent = 0; silent < 60; ++silent) {
    if (i % kStepsAScan == 0) ++i;
    slowest_mps = step(i);
  }
  EXPECT_EQ(slowest_mps, 0);
}

TEST(LocalController, ScansOfARearLaserThatIsNotThereAreRefused) {
  Drive drive(TestingFloor(), TestingPose(3, 6), NothingThere);
  EXPECT_EQ(
      drive.controller()
          .AddRearScan(drive.pose(), TestingScan(drive.pose(), NothingThere,
                                                 core::LaserMount::kRear))
          .code(),
      absl::StatusCode::kInvalidArgument);
}

TEST(LocalController, TurnsOnTheSpotWhereNobodyIs) {
  Drive drive(TestingFloor(), TestingPose(6, 6), NothingThere);
  drive.Goto({4, 6.2}, 3.14);
  for (int i = 0; i < 40; ++i)
    EXPECT_LT(drive.Step().command.forward_mps, 0.01);
  EXPECT_GT(drive.pose().pose.map_from_base.yaw_rad, 0.5);
}

TEST(LocalController, SaysWhereAClosedWayIsBlocked) {
  TestingFloor floor;
  floor.Fill({0, 0}, {12, 5}, core::Occupancy::kOccupied)
      .Fill({0, 7}, {12, 12}, core::Occupancy::kOccupied);
  Drive drive(floor, TestingPose(3, 6), TestingBox({6, 5.4}, {6.4, 6.6}));
  drive.Goto({9, 6});
  EXPECT_TRUE(drive.Until(ControlState::kBlocked, 15));
  EXPECT_NEAR(drive.last().obstacle_in_map.x, 6.05, 0.25);
  EXPECT_NEAR(drive.last().obstacle_in_map.y, 6, 0.3);
  EXPECT_GT(drive.last().obstacle_radius_m, 0.3);
  EXPECT_LT(drive.pose().pose.map_from_base.translation.x, 5.7);
  EXPECT_GT(drive.pose().pose.map_from_base.translation.x, 4.5);
}

TEST(LocalController, OldScansAndBadPosesStopIt) {
  Drive drive(TestingFloor(), TestingPose(3, 6), NothingThere);
  drive.Goto({9, 6});
  for (int i = 0; i < 80; ++i) drive.Step();
  EXPECT_GT(drive.pose().forward_mps, 0.5);
  ControlPose pose = drive.pose();
  ControlResult result;
  for (int i = 0; i < 40; ++i) {
    pose.stamp += std::chrono::milliseconds(25);
    result = drive.controller().Step(pose);
    pose.forward_mps = result.command.forward_mps;
  }
  EXPECT_EQ(result.command.forward_mps, 0);
  EXPECT_TRUE(result.is_stopped_by_guard);
  Drive other(TestingFloor(), TestingPose(3, 6), NothingThere);
  other.Goto({9, 6});
  other.Step();
  ControlPose nowhere = other.pose();
  nowhere.pose.map_from_base.yaw_rad = std::nan("");
  EXPECT_EQ(other.controller().Step(nowhere).command, core::VelocityCommand());
  EXPECT_EQ(other.controller().Guard(other.pose(), {.forward_mps = std::nan(""),
                                                    .yaw_rate_radps = 0}),
            core::VelocityCommand());
}

TEST(LocalController, GuardStopsARecoveryBeforeADrop) {
  TestingFloor floor;
  floor.Fill({0, 0}, {2.5, 12}, core::Occupancy::kOccupied);
  Drive drive(floor, TestingPose(3.2, 6), NothingThere);
  drive.Step();
  ControlPose pose = drive.pose();
  for (int i = 0; i < 120; ++i) {
    pose.stamp += std::chrono::milliseconds(25);
    ASSERT_TRUE(
        drive.controller().AddScan(pose, TestingScan(pose, NothingThere)).ok());
    const core::VelocityCommand command = drive.controller().Guard(
        pose, {.forward_mps = -0.3, .yaw_rate_radps = 0});
    pose.forward_mps = command.forward_mps;
    pose.pose.map_from_base.translation.x += 0.025 * command.forward_mps;
  }
  // Its rear is 0.3 m behind.
  EXPECT_GT(pose.pose.map_from_base.translation.x, 2.5 + 0.3);
  EXPECT_LT(pose.pose.map_from_base.translation.x, 2.95);
  EXPECT_EQ(pose.forward_mps, 0);
}

TEST(LocalController, GuardHeedsTheMapWhereALostRobotSupposesThatItIs) {
  TestingFloor floor;
  floor.Fill({0, 0}, {12, 2.5}, core::Occupancy::kOccupied);
  // The frame is that of the wheels: backwards in it is down in the map's.
  const geometry::Rigid2 map_from_odom =
      TestingPose(6, 3.2).pose.map_from_base *
      geometry::Rigid2{{}, std::numbers::pi / 2};
  const auto backs_up_m = [&](bool supposes) {
    Drive drive(floor, TestingPose(6, 6), NothingThere);
    ControlPose pose = drive.pose();
    pose.pose.map_from_base = geometry::Rigid2();
    pose.map_is_unknown = true;
    for (int i = 0; i < 120; ++i) {
      pose.stamp += std::chrono::milliseconds(25);
      if (supposes) {
        pose.supposed = {
            {.map_from_base = map_from_odom * pose.pose.map_from_base,
             .place = pose.pose.place}};
      }
      EXPECT_TRUE(drive.controller()
                      .AddScan(pose, TestingScan(pose, NothingThere))
                      .ok());
      const core::VelocityCommand command = drive.controller().Guard(
          pose, {.forward_mps = -0.3, .yaw_rate_radps = 0});
      pose.forward_mps = command.forward_mps;
      pose.pose.map_from_base.translation.x += 0.025 * command.forward_mps;
    }
    return -pose.pose.map_from_base.translation.x;
  };
  // There are 0.7 m to the edge, and its rear is 0.3 m behind.
  EXPECT_GT(backs_up_m(true), 0.25);
  EXPECT_LT(backs_up_m(true), 0.4);
  EXPECT_GT(backs_up_m(false), 0.8);
}

TEST(LocalController, KnowsItsRoom) {
  TestingFloor floor;
  floor.Fill({4, 0}, {4.05, 12}, core::Occupancy::kOccupied);
  Drive drive(floor, TestingPose(3, 6), NothingThere);
  drive.Step();
  EXPECT_TRUE(drive.controller().CanTurn(drive.pose()));
  EXPECT_NEAR(drive.controller().FreeWay_m(drive.pose(), 1.0), 0.68, 0.03);
  EXPECT_NEAR(drive.controller().FreeWay_m(drive.pose(), -0.5), -0.5, 1e-9);
  drive.pose().pose.map_from_base.translation.x = 3.65;
  drive.Step();
  EXPECT_FALSE(drive.controller().CanTurn(drive.pose()));
}

TEST(LocalController, WithoutAPathItIsIdle) {
  Drive drive(TestingFloor(), TestingPose(3, 6), NothingThere);
  EXPECT_EQ(drive.Step().state, ControlState::kIdle);
  drive.Goto({5, 6});
  drive.Step();
  EXPECT_GT(drive.controller().Bubbles().size(), 3u);
  const CostmapView view = drive.controller().Costmap();
  EXPECT_EQ(view.width, 80);
  EXPECT_EQ(view.cells.size(), 6400u);
  EXPECT_EQ(view.distance_m.size(), 6400u);
  drive.controller().SetPath({});
  EXPECT_EQ(drive.Step().state, ControlState::kIdle);
}

TEST(LocalController, OptionsAreChecked) {
  LocalControllerOptions options;
  options.goal_tolerance_m = 0;
  EXPECT_FALSE(LocalController::Make(TestingFloor().Map(), core::RobotModel(),
                                     {.front = TestingLaser()}, options)
                   .ok());
  options = {};
  options.costmap_length_m = 0.2;
  EXPECT_FALSE(LocalController::Make(TestingFloor().Map(), core::RobotModel(),
                                     {.front = TestingLaser()}, options)
                   .ok());
  // The issue's own measures.
  options = {};
  options.costmap_length_m = 3;
  EXPECT_TRUE(LocalController::Make(TestingFloor().Map(), core::RobotModel(),
                                    {.front = TestingLaser()}, options)
                  .ok());
}

}  // namespace
}  // namespace treeline::control
