#include "nav_agent/mapless/rollout_controller.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/mapless/dead_reckoning.h"
#include "nav_agent/mapless/testing_clutter.h"

namespace treeline::mapless {
namespace {

// A robot that follows commands at once, within its accelerations.
class Drive {
 public:
  explicit Drive(geometry::Vec2 goal, std::vector<Mover> movers = {})
      : goal_(goal), movers_(std::move(movers)) {}

  // Until it is near the goal, or time is over. The least room it had, and the
  // least gap to what moves.
  double Until_s(double end_s, const EvidenceGrid& map) {
    double min_m = 1;
    for (double now_s = 0; now_s < end_s; now_s += 0.025) {
      const geometry::Vec2 at = motion_.map_from_base.translation;
      const ClearanceWindow clearance(map, at - geometry::Vec2{4, 4},
                                      at + geometry::Vec2{4, 4});
      min_m =
          std::min(min_m, body_.RoomAt_m(clearance, motion_.map_from_base, 1));
      for (Mover& mover : movers_) {
        min_gap_m_ =
            std::min(min_gap_m_,
                     body_.DistanceTo_m(motion_.map_from_base, mover.in_map) -
                         mover.radius_m);
        mover.in_map = mover.After(0.025);
      }
      if (geometry::Norm(at - goal_) < 0.15) {
        took_s_ = now_s;
        break;
      }
      if (steps_++ % 6 == 0) way_.Update(map, at, goal_);
      timed_way_.Update(way_, movers_, at);
      const core::VelocityCommand command =
          rollouts_.Best(motion_, {clearance, movers_}, way_, timed_way_)
              .value_or(core::VelocityCommand());
      const auto toward = [](double from, double to, double step) {
        return from + std::clamp(to - from, -step, step);
      };
      motion_.forward_mps =
          toward(motion_.forward_mps, command.forward_mps, 0.025 * 2);
      motion_.yaw_rate_radps =
          toward(motion_.yaw_rate_radps, command.yaw_rate_radps, 0.025 * 8);
      motion_.map_from_base =
          MovedOn(motion_.map_from_base, motion_.forward_mps,
                  motion_.yaw_rate_radps, 0.025);
    }
    return min_m;
  }

  std::optional<double> took_s() const { return took_s_; }
  double min_gap_m() const { return min_gap_m_; }
  RobotMotion& motion() { return motion_; }

 private:
  geometry::Vec2 goal_;
  std::vector<Mover> movers_;
  double min_gap_m_ = 100;
  BodyShape body_{SmallRobot(), 0};
  BodyShape wide_{SmallRobot(), kBodyMargin_m};
  WayField way_{wide_};
  TimedWay timed_way_{0.3, 1.5};
  RolloutController rollouts_{SmallRobot(), wide_, {1.5, 2}};
  RobotMotion motion_;
  int steps_ = 0;
  std::optional<double> took_s_;
};

TEST(RolloutController, DrivesStraightWhereNothingIs) {
  EvidenceGrid map;
  Drive drive({4, 0});
  drive.Until_s(10, map);
  ASSERT_TRUE(drive.took_s().has_value());
  // 0.75 s to 1.5 m/s, and as long to stop: 3.4 s at best.
  EXPECT_LT(*drive.took_s(), 6);
}

TEST(RolloutController, TurnsFirstIfTheGoalIsBehind) {
  EvidenceGrid map;
  Drive drive({-3, 0});
  drive.Until_s(12, map);
  EXPECT_TRUE(drive.took_s().has_value());
}

TEST(RolloutController, GetsThroughAGapWithoutATouch) {
  EvidenceGrid map;
  AddWall({2, -3}, {2, 0.6}, map);
  AddWall({2, 1.3}, {2, 4}, map);
  Drive drive({4, 0});
  // A cell may be nearer than the wall in it by half.
  EXPECT_GT(drive.Until_s(15, map), -kCell_m / 2);
  EXPECT_TRUE(drive.took_s().has_value());
}

TEST(RolloutController, StandsBeforeAWallThatAppears) {
  EvidenceGrid map;
  AddWall({1.2, -3}, {1.2, 3}, map);
  AddWall({-3, -3}, {1.2, -3}, map);
  AddWall({-3, 3}, {1.2, 3}, map);
  AddWall({-3, -3}, {-3, 3}, map);
  Drive drive({4, 0});
  drive.motion().forward_mps = 1.0;
  EXPECT_GT(drive.Until_s(4, map), -kCell_m / 2);
  EXPECT_FALSE(drive.took_s().has_value());
}

TEST(RolloutController, PassesWhatCrossesWithoutATouch) {
  EvidenceGrid map;
  // From the right, from the left, and towards it.
  Drive drive({8, 0},
              {{.in_map = {2, -2}, .velocity_mps = {0, 1.2}, .radius_m = 0.5},
               {.in_map = {4, 4}, .velocity_mps = {0, -1.2}, .radius_m = 0.5},
               {.in_map = {9, 0}, .velocity_mps = {-1, 0}, .radius_m = 0.5}});
  drive.Until_s(20, map);
  EXPECT_TRUE(drive.took_s().has_value());
  EXPECT_GT(drive.min_gap_m(), 0.03);
}

TEST(RolloutController, GivesWayBackwardsWhereNothingElseHelps) {
  EvidenceGrid map;
  // Walls on both sides; something as wide comes along between them.
  AddWall({-6, 0.6}, {6, 0.6}, map);
  AddWall({-6, -0.6}, {6, -0.6}, map);
  Drive drive({5, 0},
              {{.in_map = {2, 0}, .velocity_mps = {-0.3, 0}, .radius_m = 0.5}});
  drive.Until_s(6, map);
  EXPECT_GT(drive.min_gap_m(), 0);
  EXPECT_LT(drive.motion().map_from_base.translation.x, -0.2);
}

TEST(RolloutController, BacksOffFromADeadEnd) {
  EvidenceGrid map;
  AddWall({0.35, -0.3}, {0.35, 0.3}, map);
  AddWall({-0.6, 0.3}, {0.35, 0.3}, map);
  AddWall({-0.6, -0.3}, {0.35, -0.3}, map);
  const ClearanceWindow clearance(map, {-4, -4}, {4, 4});
  const BodyShape body(SmallRobot(), 0.01);
  RolloutController rollouts(SmallRobot(), body, {1.5, 2});
  EXPECT_LT(rollouts.BackOff({}, {clearance}).forward_mps, 0);
}

TEST(RolloutController, TurnsOnlyWhereThereIsRoom) {
  EvidenceGrid map;
  const BodyShape body(SmallRobot(), 0.01);
  const RolloutController rollouts(SmallRobot(), body, {1.5, 2});
  const ClearanceWindow free(map, {-4, -4}, {4, 4});
  EXPECT_GT(rollouts.Turn({}, {free}, 1).yaw_rate_radps, 0);
  EXPECT_LT(rollouts.Turn({}, {free}, -1).yaw_rate_radps, 0);
  AddWall({-1, 0.26}, {1, 0.26}, map);
  AddWall({-1, -0.26}, {1, -0.26}, map);
  const ClearanceWindow narrow(map, {-4, -4}, {4, 4});
  EXPECT_EQ(rollouts.Turn({}, {narrow}, 1.5).yaw_rate_radps, 0);
}

}  // namespace
}  // namespace treeline::mapless
