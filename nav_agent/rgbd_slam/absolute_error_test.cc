#include "nav_agent/rgbd_slam/absolute_error.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "gtest/gtest.h"

namespace treeline::rgbd_slam {
namespace {

constexpr dataset::Time_ns kTenth = 100'000'000;

// A helix, ten poses a second.
std::vector<dataset::TimedPose> Helix(int count) {
  std::vector<dataset::TimedPose> poses;
  for (int i = 0; i < count; ++i) {
    const double angle_rad = 0.1 * i;
    poses.push_back(
        {.time = i * kTenth,
         .world_from_camera = {
             .rotation = geometry::Rotation3::FromAxisAngle({0, 0, angle_rad}),
             .translation = {std::cos(angle_rad), std::sin(angle_rad),
                             0.02 * i}}});
  }
  return poses;
}

TEST(ScoreTrajectory, IsZeroInAnyFrame) {
  const std::vector<dataset::TimedPose> reference = Helix(60);
  const geometry::Rigid3 map_from_world = {
      .rotation = geometry::Rotation3::FromAxisAngle({0.3, -1, 2}),
      .translation = {4, -5, 6}};
  std::vector<dataset::TimedPose> estimate = reference;
  for (dataset::TimedPose& pose : estimate) {
    pose.world_from_camera = map_from_world * pose.world_from_camera;
  }
  const auto error = ScoreTrajectory(estimate, reference);
  ASSERT_TRUE(error.ok()) << error.status();
  EXPECT_EQ(error->associated, 60);
  EXPECT_LT(error->absolute_m.max, 1e-9);
  EXPECT_LT(error->absolute_rad.max, 1e-7);
  EXPECT_LT(error->relative_m.max, 1e-9);
  EXPECT_EQ(error->pairs, 50);
  const geometry::PoseError frame = geometry::ErrorBetween(
      error->reference_from_estimate, map_from_world.Inverse());
  EXPECT_LT(frame.translation_m, 1e-8);
}

TEST(ScoreTrajectory, KnowsTheErrorOfAScaledTrajectory) {
  // Twice as large about its mean: each pose is off by its distance from the
  // mean; a ring of radius 1 has that distance everywhere.
  std::vector<dataset::TimedPose> reference;
  std::vector<dataset::TimedPose> estimate;
  constexpr int kCount = 40;
  for (int i = 0; i < kCount; ++i) {
    const double angle_rad = 2 * std::numbers::pi * i / kCount;
    const geometry::Vec3 at{std::cos(angle_rad), std::sin(angle_rad), 0};
    reference.push_back({i * kTenth, {.rotation = {}, .translation = at}});
    estimate.push_back({i * kTenth, {.rotation = {}, .translation = 2 * at}});
  }
  const auto error = ScoreTrajectory(estimate, reference);
  ASSERT_TRUE(error.ok()) << error.status();
  EXPECT_NEAR(error->absolute_m.rmse, 1, 1e-9);
  EXPECT_NEAR(error->absolute_m.mean, 1, 1e-9);
  EXPECT_NEAR(error->absolute_m.median, 1, 1e-9);
  EXPECT_NEAR(error->absolute_m.max, 1, 1e-9);
  // Over a second, ten steps: a chord of a quarter turn, once instead of twice.
  EXPECT_NEAR(error->relative_m.rmse, std::numbers::sqrt2, 1e-9);
}

TEST(ScoreTrajectory, RelativeErrorsDoNotGrowWithADriftingFrame) {
  const std::vector<dataset::TimedPose> reference = Helix(101);
  std::vector<dataset::TimedPose> estimate = reference;
  // A jump of 0.3 m in the middle concerns the ten pairs that span it alone.
  for (size_t i = 50; i < estimate.size(); ++i) {
    estimate[i].world_from_camera.translation.z += 0.3;
  }
  const auto error = ScoreTrajectory(estimate, reference);
  ASSERT_TRUE(error.ok()) << error.status();
  EXPECT_EQ(error->pairs, 91);
  EXPECT_NEAR(error->relative_m.rmse, 0.3 * std::sqrt(10.0 / 91), 1e-9);
  EXPECT_NEAR(error->relative_m.median, 0, 1e-9);
  EXPECT_GT(error->absolute_m.rmse, 0.05);
}

TEST(ScoreTrajectory, InterpolatesTheReferenceButNotAcrossGaps) {
  std::vector<dataset::TimedPose> reference = Helix(3);
  reference.push_back(
      {.time = 100 * kTenth,
       .world_from_camera = {.rotation = {}, .translation = {9, 9, 9}}});
  std::vector<dataset::TimedPose> estimate;
  for (const dataset::Time_ns time :
       {dataset::Time_ns{0}, kTenth / 2, kTenth, 3 * kTenth / 2, 50 * kTenth,
        100 * kTenth + 1000}) {
    estimate.push_back({time, {}});
  }
  const auto error = ScoreTrajectory(estimate, reference);
  ASSERT_TRUE(error.ok()) << error.status();
  EXPECT_EQ(error->poses, 6);
  // The one at 5 s is in the gap; the last is a microsecond after the last.
  EXPECT_EQ(error->associated, 5);
}

TEST(ScoreTrajectory, RefusesTrajectoriesWithoutCommonTimes) {
  std::vector<dataset::TimedPose> later = Helix(10);
  for (dataset::TimedPose& pose : later) pose.time += 1000 * kTenth;
  EXPECT_EQ(ScoreTrajectory(later, Helix(10)).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_FALSE(ScoreTrajectory({}, Helix(10)).ok());
  EXPECT_FALSE(ScoreTrajectory(Helix(10), {}).ok());
  EXPECT_FALSE(
      ScoreTrajectory(Helix(10), Helix(10), {.interval_s = std::nan("")}).ok());
}

}  // namespace
}  // namespace treeline::rgbd_slam
