#include "nav_agent/mapping/pose_graph.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "gtest/gtest.h"

namespace treeline::mapping {
namespace {

constexpr Covariance3 kSure = {1e-4, 0, 0, 0, 1e-4, 0, 0, 0, 1e-4};

// A square of 4 poses that each turn by 90 degrees.
geometry::Rigid2 Side() { return {{2, 0}, std::numbers::pi / 2}; }

std::vector<PoseConstraint> SquareOf(const geometry::Rigid2& side) {
  std::vector<PoseConstraint> constraints;
  for (int i = 0; i < 3; ++i) {
    constraints.push_back(
        {.from = i, .to = i + 1, .from_from_to = side, .covariance = kSure});
  }
  return constraints;
}

std::vector<geometry::Rigid2> Drive(const geometry::Rigid2& side) {
  std::vector<geometry::Rigid2> poses = {{}};
  for (int i = 0; i < 3; ++i) poses.push_back(poses.back() * side);
  return poses;
}

TEST(PoseGraph, SpreadsALoopsErrorOverIt) {
  // Each side is 1 cm too long and turns 0.01 rad too far; the loop knows
  // better.
  const geometry::Rigid2 measured = Side() * geometry::Rigid2{{0, -0.01}, 0.01};
  std::vector<PoseConstraint> constraints = SquareOf(measured);
  std::vector<geometry::Rigid2> poses = Drive(measured);
  constraints.push_back(
      {.from = 3, .to = 0, .from_from_to = Side(), .covariance = kSure});
  const double before = SquaredError(constraints.back(), poses);
  ASSERT_TRUE(OptimizePoseGraph(constraints, {}, &poses).ok());
  EXPECT_EQ(poses[0], geometry::Rigid2{});
  double sum = 0;
  for (const PoseConstraint& c : constraints) sum += SquaredError(c, poses);
  EXPECT_LT(sum, 0.3 * before);
  // All turn by the same.
  EXPECT_NEAR(
      geometry::NormalizedAngle_rad(poses[1].yaw_rad - std::numbers::pi / 2),
      0.0025, 0.002);
}

TEST(PoseGraph, LetsAWrongLoopPullBoundedly) {
  std::vector<PoseConstraint> constraints = SquareOf(Side());
  constraints.push_back({.from = 0,
                         .to = 3,
                         .from_from_to = Drive(Side())[3],
                         .covariance = kSure,
                         .may_be_wrong = true});
  constraints.push_back({.from = 0,
                         .to = 3,
                         .from_from_to = {{5, 5}, 0},
                         .covariance = kSure,
                         .may_be_wrong = true});
  std::vector<geometry::Rigid2> poses = Drive(Side());
  ASSERT_TRUE(OptimizePoseGraph(constraints, {}, &poses).ok());
  // Cauchy's kernel of 2 sigmas: the pull of an error e is 4 / e, in sigmas,
  // here 4 / 500 of them: far below a millimetre.
  EXPECT_LT(geometry::Norm(poses[3].translation - Drive(Side())[3].translation),
            0.002);
  EXPECT_GT(SquaredError(constraints.back(), poses), 1000);
}

TEST(PoseGraph, TakesTheShortWayRound) {
  std::vector<geometry::Rigid2> poses = {{{0, 0}, 3.1}, {{0, 0}, -3.1}};
  const std::vector<PoseConstraint> constraints = {
      {.from = 0, .to = 1, .from_from_to = {{0, 0}, 0.1}, .covariance = kSure}};
  ASSERT_TRUE(OptimizePoseGraph(constraints, {}, &poses).ok());
  EXPECT_NEAR(poses[1].yaw_rad, 3.2 - 2 * std::numbers::pi, 1e-6);
}

TEST(PoseGraph, RefusesWhatIsNotSane) {
  std::vector<geometry::Rigid2> poses = Drive(Side());
  const std::vector<geometry::Rigid2> before = poses;
  PoseConstraint constraint = {
      .from = 0, .to = 4, .from_from_to = {}, .covariance = kSure};
  EXPECT_FALSE(OptimizePoseGraph({&constraint, 1}, {}, &poses).ok());
  constraint.to = 1;
  constraint.covariance[4] = -1;
  EXPECT_FALSE(OptimizePoseGraph({&constraint, 1}, {}, &poses).ok());
  constraint.covariance = kSure;
  constraint.from_from_to.yaw_rad = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(OptimizePoseGraph({&constraint, 1}, {}, &poses).ok());
  EXPECT_EQ(poses, before);
}

TEST(PoseGraph, TurnsCovariances) {
  const Covariance3 along_x = {4, 0, 0, 0, 1, 0, 0, 0, 9};
  const Covariance3 turned = Turned(along_x, std::numbers::pi / 2);
  EXPECT_NEAR(turned[0], 1, 1e-12);
  EXPECT_NEAR(turned[4], 4, 1e-12);
  EXPECT_NEAR(turned[8], 9, 1e-12);
}

TEST(PoseGraph, HeightsAgreeWhereALoopSaysSo) {
  // Up and down again, 4 cm short; the loop says that it is the same floor. A
  // wrong one says that the top is, too.
  std::vector<PoseConstraint> constraints;
  std::vector<double> heights_m = {0};
  for (const double climb_m : {0.0, 1.0, 1.6, 0.0, -1.6, -0.96}) {
    const int from = static_cast<int>(heights_m.size()) - 1;
    constraints.push_back({.from = from,
                           .to = from + 1,
                           .from_from_to = {},
                           .climb_m = climb_m,
                           .climb_sigma_m = 0.001 + 0.02 * std::abs(climb_m)});
    heights_m.push_back(heights_m.back() + climb_m);
  }
  constraints.push_back({.from = 1,
                         .to = 6,
                         .from_from_to = {},
                         .may_be_wrong = true,
                         .climb_m = 0,
                         .climb_sigma_m = 0.01});
  constraints.push_back({.from = 0,
                         .to = 3,
                         .from_from_to = {},
                         .may_be_wrong = true,
                         .climb_m = 0,
                         .climb_sigma_m = 0.01});
  // Nothing is known of this one.
  constraints.push_back(
      {.from = 0, .to = 4, .from_from_to = {}, .may_be_wrong = true});
  ASSERT_TRUE(OptimizeHeights(constraints, {}, &heights_m).ok());
  EXPECT_EQ(heights_m[0], 0);
  EXPECT_NEAR(heights_m[6], heights_m[1], 0.01);
  // Half of the 4 cm belong to the way up.
  EXPECT_NEAR(heights_m[3], 2.58, 0.02);
  constraints[0].climb_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(OptimizeHeights(constraints, {}, &heights_m).ok());
}

}  // namespace
}  // namespace treeline::mapping
