#include "common/dataset/trajectory_error.h"

#include <cmath>
#include <numbers>
#include <vector>

#include "gtest/gtest.h"

namespace treeline::dataset {
namespace {

constexpr Time_ns kTenth = 100'000'000;

// A helix, ten poses a second.
std::vector<TimedPose> Helix(int count) {
  std::vector<TimedPose> poses;
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
  const std::vector<TimedPose> reference = Helix(60);
  const geometry::Rigid3 map_from_world = {
      .rotation = geometry::Rotation3::FromAxisAngle({0.3, -1, 2}),
      .translation = {4, -5, 6}};
  std::vector<TimedPose> estimate = reference;
  for (TimedPose& pose : estimate) {
    pose.world_from_camera = map_from_world * pose.world_from_camera;
  }
  const auto error = ScoreTrajectory(estimate, reference);
  ASSERT_TRUE(error.ok()) << error.status();
  EXPECT_EQ(error->absolute.poses, 60);
  EXPECT_LT(error->absolute.position_m.max, 1e-9);
  EXPECT_LT(error->absolute.rotation_rad.max, 1e-7);
  EXPECT_LT(error->relative_m.max, 1e-9);
  EXPECT_EQ(error->pairs, 50);
  const geometry::PoseError frame =
      geometry::ErrorBetween(error->absolute.alignment.reference_from_estimate,
                             map_from_world.Inverse());
  EXPECT_LT(frame.translation_m, 1e-8);
}

TEST(ScoreTrajectory, KnowsTheErrorOfAScaledTrajectory) {
  // Twice as large about its mean: each pose is off by its distance from the
  // mean; a ring of radius 1 has that distance everywhere.
  std::vector<TimedPose> reference;
  std::vector<TimedPose> estimate;
  constexpr int kCount = 40;
  for (int i = 0; i < kCount; ++i) {
    const double angle_rad = 2 * std::numbers::pi * i / kCount;
    const geometry::Vec3 at{std::cos(angle_rad), std::sin(angle_rad), 0};
    reference.push_back({i * kTenth, {.rotation = {}, .translation = at}});
    estimate.push_back({i * kTenth, {.rotation = {}, .translation = 2 * at}});
  }
  const auto error = ScoreTrajectory(estimate, reference);
  ASSERT_TRUE(error.ok()) << error.status();
  EXPECT_NEAR(error->absolute.position_m.rmse, 1, 1e-9);
  EXPECT_NEAR(error->absolute.position_m.mean, 1, 1e-9);
  EXPECT_NEAR(error->absolute.position_m.median, 1, 1e-9);
  EXPECT_NEAR(error->absolute.position_m.max, 1, 1e-9);
  // Over a second, ten steps: a chord of a quarter turn, once instead of twice.
  EXPECT_NEAR(error->relative_m.rmse, std::numbers::sqrt2, 1e-9);
}

TEST(ScoreTrajectory, RelativeErrorsDoNotGrowWithADriftingFrame) {
  const std::vector<TimedPose> reference = Helix(101);
  std::vector<TimedPose> estimate = reference;
  // A jump of 0.3 m in the middle concerns the ten pairs that span it alone.
  for (size_t i = 50; i < estimate.size(); ++i) {
    estimate[i].world_from_camera.translation.z += 0.3;
  }
  const auto error = ScoreTrajectory(estimate, reference);
  ASSERT_TRUE(error.ok()) << error.status();
  EXPECT_EQ(error->pairs, 91);
  EXPECT_NEAR(error->relative_m.rmse, 0.3 * std::sqrt(10.0 / 91), 1e-9);
  EXPECT_NEAR(error->relative_m.median, 0, 1e-9);
  EXPECT_GT(error->absolute.position_m.rmse, 0.05);
}

TEST(ScoreTrajectory, InterpolatesTheReferenceButNotAcrossGaps) {
  std::vector<TimedPose> reference = Helix(3);
  reference.push_back(
      {.time = 100 * kTenth,
       .world_from_camera = {.rotation = {}, .translation = {9, 9, 9}}});
  std::vector<TimedPose> estimate;
  for (const Time_ns time : {Time_ns{0}, kTenth / 2, kTenth, 3 * kTenth / 2,
                             50 * kTenth, 100 * kTenth + 1000}) {
    estimate.push_back({time, {}});
  }
  const auto error = ScoreTrajectory(estimate, reference);
  ASSERT_TRUE(error.ok()) << error.status();
  EXPECT_EQ(error->poses, 6);
  // The one at 5 s is in the gap; the last is a microsecond after the last.
  EXPECT_EQ(error->absolute.poses, 5);
}

// A drift of 1 cm a pose upwards, and a turn of all about z.
std::vector<TimedPose> ClimbingHelix(double yaw_rad) {
  std::vector<TimedPose> poses = Helix(60);
  const geometry::Rotation3 turn =
      geometry::Rotation3::FromAxisAngle({0, 0, yaw_rad});
  for (size_t i = 0; i < poses.size(); ++i) {
    geometry::Rigid3& pose = poses[i].world_from_camera;
    pose = geometry::Rigid3{turn, {7, -8, 9}} * pose;
    pose.translation.z += 0.01 * static_cast<double>(i);
  }
  return poses;
}

TEST(ScoreTrajectory, KeepsUpUprightWhereAskedTo) {
  const auto first =
      ScoreTrajectory(ClimbingHelix(0.7), Helix(60),
                      {.alignment = TrajectoryAlignment::kFirstPoseUpright});
  ASSERT_TRUE(first.ok()) << first.status();
  // From 0 to 59 cm: mean of the squares of 0 to 59.
  EXPECT_NEAR(first->absolute.height_m.rmse,
              0.01 * std::sqrt(59.0 * 60 * 119 / 6 / 60), 1e-9);
  EXPECT_NEAR(first->absolute.height_m.max, 0.59, 1e-9);
  EXPECT_LT(first->absolute.planar_m.max, 1e-9);
  EXPECT_LT(first->absolute.rotation_rad.max, 1e-7);
  EXPECT_NEAR(first->absolute.position_m.rmse, first->absolute.height_m.rmse,
              1e-9);
  const auto all =
      ScoreTrajectory(ClimbingHelix(0.7), Helix(60),
                      {.alignment = TrajectoryAlignment::kUpright});
  ASSERT_TRUE(all.ok()) << all.status();
  // About their mean.
  EXPECT_NEAR(all->absolute.height_m.rmse,
              0.01 * std::sqrt((60.0 * 60 - 1) / 12), 1e-9);
  EXPECT_LT(all->absolute.planar_m.max, 1e-9);
}

TEST(ScoreTrajectory, NeedsOnePoseUprightAndThreeInSpace) {
  const std::vector<TimedPose> one = Helix(1);
  EXPECT_FALSE(ScoreTrajectory(one, one).ok());
  EXPECT_FALSE(
      ScoreTrajectory({}, one, {.alignment = TrajectoryAlignment::kUpright})
          .ok());
  const auto score =
      ScoreTrajectory(one, one, {.alignment = TrajectoryAlignment::kUpright});
  ASSERT_TRUE(score.ok()) << score.status();
  EXPECT_EQ(score->absolute.poses, 1);
}

TEST(ScoreTrajectory, RefusesTrajectoriesWithoutCommonTimes) {
  std::vector<TimedPose> later = Helix(10);
  for (TimedPose& pose : later) pose.time += 1000 * kTenth;
  EXPECT_EQ(ScoreTrajectory(later, Helix(10)).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_FALSE(ScoreTrajectory({}, Helix(10)).ok());
  EXPECT_FALSE(ScoreTrajectory(Helix(10), {}).ok());
  EXPECT_FALSE(
      ScoreTrajectory(Helix(10), Helix(10), {.interval_s = std::nan("")}).ok());
}

PosePair At(geometry::Vec3 estimated, geometry::Vec3 truth) {
  return {.estimate = {{}, estimated}, .reference = {{}, truth}};
}

const std::vector<geometry::Vec3>& Corners() {
  static const std::vector<geometry::Vec3> corners{
      {0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}, {1, 2, 3}};
  return corners;
}

// Truth is the estimate turned, moved and scaled.
std::vector<PosePair> InAnotherWorld(double scale) {
  const geometry::Rotation3 turn =
      geometry::Rotation3::FromAxisAngle({0.3, -0.8, 1.2});
  std::vector<PosePair> pairs;
  for (const geometry::Vec3& corner : Corners()) {
    pairs.push_back(
        At(corner, scale * (turn * corner) + geometry::Vec3{4, -5, 6}));
  }
  return pairs;
}

TEST(AbsoluteTrajectoryError, IsTheRootMeanSquareDistanceWithoutAlignment) {
  const auto error = AbsoluteTrajectoryError(
      std::vector<PosePair>{At({0, 0, 0}, {0, 0, 3}), At({1, 0, 0}, {1, 4, 0})},
      TrajectoryAlignment::kNone);
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->poses, 2);
  EXPECT_NEAR(error->position_m.rmse, std::sqrt((9 + 16) / 2.0), 1e-12);
}

TEST(AbsoluteTrajectoryError, VanishesBetweenWorldsThatDifferRigidly) {
  const auto error =
      AbsoluteTrajectoryError(InAnotherWorld(1), TrajectoryAlignment::kRigid);
  ASSERT_TRUE(error.has_value());
  EXPECT_NEAR(error->position_m.rmse, 0, 1e-9);
  EXPECT_EQ(error->alignment.scale, 1);
}

TEST(AbsoluteTrajectoryError, FindsTheScaleWhereAskedTo) {
  const std::vector<PosePair> pairs = InAnotherWorld(1.25);
  const auto rigid =
      AbsoluteTrajectoryError(pairs, TrajectoryAlignment::kRigid);
  const auto similar =
      AbsoluteTrajectoryError(pairs, TrajectoryAlignment::kSimilarity);
  ASSERT_TRUE(rigid.has_value() && similar.has_value());
  EXPECT_GT(rigid->position_m.rmse, 0.1);
  EXPECT_NEAR(similar->position_m.rmse, 0, 1e-9);
  EXPECT_NEAR(similar->alignment.scale, 1.25, 1e-9);
}

TEST(AbsoluteTrajectoryError, IsUnknownWhereNothingCanBeAligned) {
  EXPECT_FALSE(
      AbsoluteTrajectoryError({}, TrajectoryAlignment::kNone).has_value());
  const std::vector<PosePair> line{At({0, 0, 0}, {}), At({1, 0, 0}, {1, 0, 0}),
                                   At({2, 0, 0}, {2, 0, 0})};
  EXPECT_FALSE(
      AbsoluteTrajectoryError(line, TrajectoryAlignment::kRigid).has_value());
  EXPECT_TRUE(
      AbsoluteTrajectoryError(line, TrajectoryAlignment::kNone).has_value());
}

}  // namespace
}  // namespace treeline::dataset
