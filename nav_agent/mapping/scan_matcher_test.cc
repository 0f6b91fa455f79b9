#include "nav_agent/mapping/scan_matcher.h"

#include <cmath>
#include <limits>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/mapping/testing_plan.h"

namespace treeline::mapping {
namespace {

constexpr double kNoise_m = 0.01;

// A room of 8 x 6 m with a pillar, and a cupboard in a corner.
std::vector<TestWall> Room() {
  std::vector<TestWall> walls;
  AddBox({-4, -3}, {4, 3}, &walls);
  AddBox({1.5, 0.5}, {2.0, 1.0}, &walls);
  AddBox({3.0, -3}, {4, -2.2}, &walls);
  return walls;
}

std::vector<TestWall> Corridor() {
  return {{{-60, -1}, {60, -1}}, {{-60, 1}, {60, 1}}};
}

ScanOutline Scan(const std::vector<TestWall>& walls,
                 const geometry::Rigid2& pose, uint64_t stream) {
  const core::RangeSensorInfo laser = TestLaser(10);
  return MakeScanOutline(CastScan(walls, pose, laser, kNoise_m, stream), laser,
                         {});
}

ScanMatch Match(const ScanOutline& reference,
                const geometry::Rigid2& map_from_reference,
                const ScanOutline& scan, const geometry::Rigid2& guess,
                const MatchSearch& search) {
  const ScanMatcherOptions options;
  const std::vector<PlacedScan> references = {
      {.scan = &reference, .target_from_scan = map_from_reference}};
  const SurfaceGrid grid =
      MakeSurfaceGrid(references, scan, guess, search, options);
  return MatchScan(grid, scan, guess, search, options);
}

// About 150 points with 1 cm of noise, on walls of two directions: along each
// axis the mean is good to 1 cm / sqrt(75), in both scans. What remains is
// that a piece of surface between two noisy points is off by their noise: 5
// standard deviations of the sum are 1 cm. Yaw: the same over arms of 3 m.
TEST(ScanMatcher, FindsKnownPosesInARoom) {
  const std::vector<TestWall> walls = Room();
  const geometry::Rigid2 reference_pose = {{-1.0, -0.4}, 0.2};
  const ScanOutline reference = Scan(walls, reference_pose, 1);
  base::Random random(3, 1);
  for (uint64_t i = 0; i < 40; ++i) {
    const geometry::Rigid2 offset = {
        {random.NextUniform(-0.4, 0.4), random.NextUniform(-0.4, 0.4)},
        random.NextUniform(-0.35, 0.35)};
    const geometry::Rigid2 truth = reference_pose * offset;
    const ScanOutline scan = Scan(walls, truth, 100 + i);
    const ScanMatch match =
        Match(reference, reference_pose, scan, reference_pose,
              {.half_extent_m = 0.6, .half_angle_rad = 0.4});
    const geometry::Rigid2 error = truth.Inverse() * match.target_from_scan;
    EXPECT_LT(geometry::Norm(error.translation), 0.01) << i;
    EXPECT_LT(std::abs(error.yaw_rad), 0.004) << i;
    EXPECT_GT(match.response, 0.75) << i;
    // It knows that it is sure, and is right about it. By the formulas: 75
    // points an axis, at 0.3 each, of 5 cm: 1 cm, once from the spread and once
    // from the peak; twice that as yaw is not known; and two axes.
    const double sigma_m = std::sqrt(match.covariance[0] + match.covariance[4]);
    EXPECT_LT(sigma_m, 0.04) << i;
    EXPECT_LT(geometry::Norm(error.translation), 4 * sigma_m) << i;
  }
}

TEST(ScanMatcher, FindsPosesFarFromTheGuess) {
  const std::vector<TestWall> walls = Room();
  const geometry::Rigid2 reference_pose = {{-1.0, -0.4}, 0.2};
  const ScanOutline reference = Scan(walls, reference_pose, 1);
  const geometry::Rigid2 truth =
      reference_pose * geometry::Rigid2{{0.5, -0.3}, -0.5};
  const ScanOutline scan = Scan(walls, truth, 2);
  const geometry::Rigid2 guess =
      reference_pose * geometry::Rigid2{{-1.0, 0.9}, 0.3};
  const ScanMatch match = Match(reference, reference_pose, scan, guess,
                                {.half_extent_m = 2.0, .half_angle_rad = 1.0});
  const geometry::Rigid2 error = truth.Inverse() * match.target_from_scan;
  EXPECT_LT(geometry::Norm(error.translation), 0.01);
  EXPECT_LT(std::abs(error.yaw_rad), 0.004);
}

TEST(ScanMatcher, SaysThatThePeakMayLieBeyondTheSearch) {
  const std::vector<TestWall> walls = Room();
  const ScanOutline reference = Scan(walls, {{-1, -0.4}, 0}, 1);
  const ScanOutline scan = Scan(walls, {{-0.5, -0.4}, 0}, 2);
  const geometry::Rigid2 guess = {{-1, -0.4}, 0};
  EXPECT_TRUE(Match(reference, guess, scan, guess,
                    {.half_extent_m = 0.4, .half_angle_rad = 0.1})
                  .is_at_border);
  EXPECT_FALSE(Match(reference, guess, scan, guess,
                     {.half_extent_m = 0.7, .half_angle_rad = 0.1})
                   .is_at_border);
}

// Branch and bound must find what trying every pose finds: the best score.
TEST(ScanMatcher, LooksAtEveryPose) {
  const std::vector<TestWall> walls = Room();
  const geometry::Rigid2 reference_pose = {{-1.0, -0.4}, 0.2};
  const ScanOutline reference = Scan(walls, reference_pose, 1);
  const std::vector<PlacedScan> references = {
      {.scan = &reference, .target_from_scan = reference_pose}};
  const ScanMatcherOptions options;
  for (uint64_t i = 0; i < 5; ++i) {
    const geometry::Rigid2 truth =
        reference_pose *
        geometry::Rigid2{{0.1 * static_cast<double>(i), 0.2}, 0.0};
    const ScanOutline scan = Scan(walls, truth, 50 + i);
    const MatchSearch search = {.half_extent_m = 0.5, .half_angle_rad = 0.0};
    const geometry::Rigid2 guess = reference_pose;
    SurfaceGrid with_levels =
        MakeSurfaceGrid(references, scan, guess, search, options);
    SurfaceGrid without = with_levels;
    without.BuildPyramid(1);
    const ScanMatch fast = MatchScan(with_levels, scan, guess, search, options);
    const ScanMatch slow = MatchScan(without, scan, guess, search, options);
    EXPECT_GT(with_levels.levels(), 2);
    EXPECT_EQ(fast.target_from_scan, slow.target_from_scan) << i;
  }
}

TEST(ScanMatcher, IsUnsureAlongACorridorOnly) {
  constexpr int kScans = 20;
  const std::vector<TestWall> walls = Corridor();
  const geometry::Rigid2 reference_pose = {{0, 0.1}, 0.0};
  const MatchSearch search = {.half_extent_m = 0.5, .half_angle_rad = 0.2};
  double tilt2 = 0;
  for (uint64_t i = 0; i < kScans; ++i) {
    const ScanOutline reference = Scan(walls, reference_pose, 2 * i);
    const ScanOutline scan = Scan(walls, {{0.2, 0.0}, 0.02}, 2 * i + 1);
    const ScanMatch match =
        Match(reference, reference_pose, scan, reference_pose, search);
    EXPECT_NEAR(match.target_from_scan.translation.y, 0.0, 0.02);
    EXPECT_NEAR(match.target_from_scan.yaw_rad, 0.02, 0.005);
    // Nothing bounds it along the corridor: only how far was searched does. How
    // sure it is across is told along the other axis of the ellipse, not along
    // y: 16 m along and a corridor that is known to 2 mrad are 3.5 cm of y.
    const double along2 = match.covariance[0];
    const double tilt = match.covariance[1] / along2;
    tilt2 += tilt * tilt / kScans;
    EXPECT_LT(std::sqrt(match.covariance[4] - tilt * match.covariance[1]),
              0.03);
    EXPECT_GT(std::sqrt(along2), 0.1);
    EXPECT_GT(along2, 25 * match.covariance[4]);
  }
  EXPECT_LT(std::sqrt(tilt2), 0.01);
}

TEST(ScanMatcher, BelievesTheGuessWhereNothingElseTells) {
  const std::vector<TestWall> walls = Corridor();
  const ScanOutline reference = Scan(walls, {}, 1);
  const ScanOutline scan = Scan(walls, {{0.2, 0.05}, 0}, 2);
  const geometry::Rigid2 guess = {{0.2, 0}, 0};
  const ScanMatch match = Match(reference, {}, scan, guess,
                                {.half_extent_m = 0.3,
                                 .half_angle_rad = 0.1,
                                 .guess_sigma_m = 0.03,
                                 .guess_sigma_rad = 0.03});
  // Along the corridor pieces of surface end where the laser's reach did, which
  // pulls a little: well within what the guess is said to be wrong by.
  EXPECT_NEAR(match.target_from_scan.translation.x, 0.2, 0.03);
  EXPECT_NEAR(match.target_from_scan.translation.y, 0.05, 0.02);
  EXPECT_NEAR(std::sqrt(match.covariance[0]), 0.03, 0.02);
}

TEST(ScanMatcher, SaysThatAnEmptyScanTellsNothing) {
  const ScanOutline reference = Scan(Room(), {}, 1);
  const geometry::Rigid2 guess = {{0.3, 0.1}, 0.1};
  const ScanMatch match = Match(reference, {}, ScanOutline{}, guess, {});
  EXPECT_EQ(match.target_from_scan, guess);
  EXPECT_EQ(match.response, 0);
  EXPECT_GT(match.covariance[0], 0.01);
}

}  // namespace
}  // namespace treeline::mapping
