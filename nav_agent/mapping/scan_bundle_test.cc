#include "nav_agent/mapping/scan_bundle.h"

#include <cmath>
#include <vector>

#include "common/base/random.h"
#include "gtest/gtest.h"
#include "nav_agent/mapping/testing_plan.h"

namespace treeline::mapping {
namespace {

constexpr double kNoise_m = 0.01;

// A corridor of 12 m with two pillars, and its ends.
std::vector<TestWall> Corridor() {
  std::vector<TestWall> walls;
  AddBox({0, -1}, {12, 1}, &walls);
  AddBox({4, -1}, {4.4, -0.6}, &walls);
  AddBox({8, 0.6}, {8.4, 1}, &walls);
  return walls;
}

std::vector<geometry::Rigid2> Truth() {
  std::vector<geometry::Rigid2> truth;
  for (int i = 0; i < 30; ++i) truth.push_back({{1 + 0.2 * i, 0.0}, 0});
  return truth;
}

ScanOutline See(const geometry::Rigid2& from, uint64_t stream) {
  const core::RangeSensorInfo laser = TestLaser(20);
  return MakeScanOutline(CastScan(Corridor(), from, laser, kNoise_m, stream),
                         laser, {});
}

std::vector<ScanSurfels> SeeAll(const std::vector<geometry::Rigid2>& truth) {
  std::vector<ScanSurfels> scans;
  for (const geometry::Rigid2& pose : truth) {
    scans.emplace_back(SurfelsOf(See(pose, scans.size()), {}));
  }
  return scans;
}

// Steps of the true way, that may be 3 cm and half a degree off.
std::vector<PoseConstraint> Steps(const std::vector<geometry::Rigid2>& truth) {
  std::vector<PoseConstraint> steps;
  for (int i = 1; i < static_cast<int>(truth.size()); ++i) {
    const auto slot = static_cast<size_t>(i);
    steps.push_back({.from = i - 1,
                     .to = i,
                     .from_from_to = truth[slot - 1].Inverse() * truth[slot],
                     .covariance = {9e-4, 0, 0, 0, 9e-4, 0, 0, 0, 1e-4},
                     .may_be_wrong = true});
  }
  return steps;
}

std::vector<ScanPair> PairsOf(int scans) {
  std::vector<ScanPair> pairs;
  for (int i = 1; i < scans; ++i) {
    for (const int back : {1, 2, 5}) {
      if (i >= back) pairs.push_back({.a = i - back, .b = i});
    }
  }
  return pairs;
}

double Largest_m(const std::vector<geometry::Rigid2>& poses,
                 const std::vector<geometry::Rigid2>& truth) {
  double largest_m = 0;
  for (size_t i = 0; i < poses.size(); ++i) {
    largest_m = std::max(
        largest_m, geometry::Norm(poses[i].translation - truth[i].translation));
  }
  return largest_m;
}

// The first stays where it is.
std::vector<geometry::Rigid2> Shaken(std::vector<geometry::Rigid2> poses) {
  base::Random random(3, 0);
  for (size_t i = 1; i < poses.size(); ++i) {
    poses[i].translation.x += random.NextUniform(-0.04, 0.04);
    poses[i].translation.y += random.NextUniform(-0.04, 0.04);
    poses[i].yaw_rad += random.NextUniform(-0.02, 0.02);
  }
  return poses;
}

TEST(ScanSurfels, LieOnTheSurfaceAndFaceTheRobot) {
  const std::vector<Surfel> surfels = SurfelsOf(See({{6, 0}, 0}, 1), {});
  ASSERT_GT(surfels.size(), 40u);
  int on_walls = 0;
  for (const Surfel& surfel : surfels) {
    EXPECT_LT(surfel.x * surfel.normal_x + surfel.y * surfel.normal_y, 0);
    EXPECT_NEAR(std::hypot(surfel.normal_x, surfel.normal_y), 1, 1e-5);
    // Three standard deviations of the mean of three returns.
    if (std::abs(std::abs(surfel.y) - 1) < 3 * kNoise_m / std::sqrt(3.0)) {
      ++on_walls;
    }
  }
  EXPECT_GT(on_walls, 25);
}

TEST(ScanSurfels, AreFoundByPlace) {
  const ScanSurfels scan({{.x = 2, .y = 1, .normal_x = 0, .normal_y = -1}});
  ASSERT_NE(scan.Near({2.1, 1.05}), nullptr);
  EXPECT_EQ(scan.Near({2.1, 1.05})->x, 2);
  EXPECT_EQ(scan.Near({2.5, 1}), nullptr);
  EXPECT_EQ(ScanSurfels({}).Near({2, 1}), nullptr);
}

// As at the foot of a ramp that climbs along x.
TEST(ScanBundle, LeavesWhatAPairCannotTell) {
  const std::vector<geometry::Rigid2> truth = {{{4, 0}, 0}, {{4.2, 0}, 0}};
  const std::vector<ScanSurfels> scans = SeeAll(truth);
  const std::vector<geometry::Rigid2> start = {truth[0], {{4.22, 0.03}, 0.01}};
  const std::vector<PoseConstraint> odometry = {
      {.from = 0,
       .to = 1,
       .from_from_to = start[0].Inverse() * start[1],
       .covariance = {1e-2, 0, 0, 0, 1e-2, 0, 0, 0, 1e-2}}};
  std::vector<geometry::Rigid2> poses = start;
  const ScanPair climbs = {.a = 0, .b = 1, .untold = {1, 0}};
  ASSERT_TRUE(AdjustBundle(scans, {&climbs, 1}, odometry, {}, &poses));
  EXPECT_NEAR(poses[1].translation.x, 4.22, 0.002);
  EXPECT_NEAR(poses[1].translation.y, 0, 0.008);
  EXPECT_NEAR(poses[1].yaw_rad, 0, 0.004);
  poses = start;
  const ScanPair level = {.a = 0, .b = 1};
  ASSERT_TRUE(AdjustBundle(scans, {&level, 1}, odometry, {}, &poses));
  EXPECT_NEAR(poses[1].translation.x, 4.2, 0.008);
}

TEST(ScanBundle, LaysScansUponEachOther) {
  const std::vector<geometry::Rigid2> truth = Truth();
  const std::vector<ScanSurfels> scans = SeeAll(truth);
  std::vector<geometry::Rigid2> poses = Shaken(truth);
  ASSERT_GT(Largest_m(poses, truth), 0.03);
  ASSERT_TRUE(AdjustBundle(scans, PairsOf(30), Steps(truth), {}, &poses));
  EXPECT_EQ(poses[0], truth[0]);
  // Each is held by dozens of surfels of 1 cm, and that 30 scans in a row.
  EXPECT_LT(Largest_m(poses, truth), 0.01);
}

TEST(ScanBundle, AnswersTheSameForAnyNumberOfThreads) {
  const std::vector<geometry::Rigid2> truth = Truth();
  const std::vector<ScanSurfels> scans = SeeAll(truth);
  std::vector<std::vector<geometry::Rigid2>> answers;
  for (const int threads : {1, 2, 8}) {
    answers.push_back(Shaken(truth));
    ASSERT_TRUE(AdjustBundle(scans, PairsOf(30), Steps(truth),
                             {.threads = threads}, &answers.back()));
  }
  EXPECT_EQ(answers[1], answers[0]);
  EXPECT_EQ(answers[2], answers[0]);
}

TEST(ScanBundle, OdometryThatSlippedIsOverruled) {
  const std::vector<geometry::Rigid2> truth = Truth();
  const std::vector<ScanSurfels> scans = SeeAll(truth);
  std::vector<PoseConstraint> steps = Steps(truth);
  // Ten standard deviations.
  steps[15].from_from_to.translation.x += 0.3;
  std::vector<geometry::Rigid2> poses = Shaken(truth);
  ASSERT_TRUE(AdjustBundle(scans, PairsOf(30), steps, {}, &poses));
  EXPECT_LT(Largest_m(poses, truth), 0.01);
}

TEST(ScanBundle, OdometryDecidesWhereNothingIsSeen) {
  const std::vector<geometry::Rigid2> truth = Truth();
  const std::vector<ScanSurfels> blind(truth.size(), ScanSurfels({}));
  std::vector<geometry::Rigid2> poses = Shaken(truth);
  ASSERT_TRUE(
      AdjustBundle(blind, PairsOf(30), Steps(truth), {.rounds = 20}, &poses));
  EXPECT_LT(Largest_m(poses, truth), 0.002);
}

TEST(ScanBundle, AlignsOneScanWithThoseAroundIt) {
  const std::vector<geometry::Rigid2> truth = Truth();
  const std::vector<ScanSurfels> scans = SeeAll(truth);
  const geometry::Rigid2 here = {{4.1, 0.05}, 0.1};
  std::vector<PlacedSurfels> others;
  for (const size_t i : {13u, 15u, 17u}) {
    others.push_back({.scan = &scans[i], .map_from_scan = truth[i]});
  }
  const geometry::Rigid2 guess = {{4.14, 0.02}, 0.12};
  const std::vector<Surfel> seen = SurfelsOf(See(here, 99), {});
  const geometry::Rigid2 found =
      AlignWithBundle(seen, others, guess, 0.1, 0.1, {});
  EXPECT_LT(geometry::Norm(found.translation - here.translation), 0.01);
  EXPECT_NEAR(found.yaw_rad, here.yaw_rad, 0.003);
  EXPECT_EQ(AlignWithBundle(seen, {}, guess, 0.1, 0.1, {}), guess);
}

}  // namespace
}  // namespace treeline::mapping
