#include "evaluation/accuracy/trajectory_error.h"

#include <cmath>
#include <vector>

#include "gtest/gtest.h"
#include "server/tools/testing_fixtures.h"

namespace treeline::accuracy {
namespace {

FrameResult At(geometry::Vec3 estimated, geometry::Vec3 truth) {
  FrameResult result;
  result.estimate = tools::LocalizedAt({{}, estimated});
  result.true_world_from_camera = geometry::Rigid3{{}, truth};
  result.error = geometry::PoseError{geometry::Norm(estimated - truth), 0};
  return result;
}

const std::vector<geometry::Vec3>& Corners() {
  static const std::vector<geometry::Vec3> corners{
      {0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}, {1, 2, 3}};
  return corners;
}

// Truth is the estimate turned, moved and scaled.
std::vector<FrameResult> InAnotherWorld(double scale) {
  const geometry::Rotation3 turn =
      geometry::Rotation3::FromAxisAngle({0.3, -0.8, 1.2});
  std::vector<FrameResult> results;
  for (const geometry::Vec3& corner : Corners()) {
    results.push_back(
        At(corner, scale * (turn * corner) + geometry::Vec3{4, -5, 6}));
  }
  return results;
}

TEST(AbsoluteTrajectoryError, IsTheRootMeanSquareDistanceWithoutAlignment) {
  const auto error = AbsoluteTrajectoryError(
      {At({0, 0, 0}, {0, 0, 3}), At({1, 0, 0}, {1, 4, 0})},
      TrajectoryAlignment::kNone);
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->poses, 2);
  EXPECT_NEAR(error->rmse_m, std::sqrt((9 + 16) / 2.0), 1e-12);
}

TEST(AbsoluteTrajectoryError, VanishesBetweenWorldsThatDifferRigidly) {
  const auto error =
      AbsoluteTrajectoryError(InAnotherWorld(1), TrajectoryAlignment::kRigid);
  ASSERT_TRUE(error.has_value());
  EXPECT_NEAR(error->rmse_m, 0, 1e-9);
  EXPECT_EQ(error->scale, 1);
}

TEST(AbsoluteTrajectoryError, FindsTheScaleWhereAskedTo) {
  const std::vector<FrameResult> results = InAnotherWorld(1.25);
  const auto rigid =
      AbsoluteTrajectoryError(results, TrajectoryAlignment::kRigid);
  const auto similar =
      AbsoluteTrajectoryError(results, TrajectoryAlignment::kSimilarity);
  ASSERT_TRUE(rigid.has_value() && similar.has_value());
  EXPECT_GT(rigid->rmse_m, 0.1);
  EXPECT_NEAR(similar->rmse_m, 0, 1e-9);
  EXPECT_NEAR(similar->scale, 1.25, 1e-9);
}

TEST(AbsoluteTrajectoryError, LeavesOutFramesThatWereNotLocalized) {
  std::vector<FrameResult> results = InAnotherWorld(1);
  FrameResult lost;
  lost.true_world_from_camera = geometry::Rigid3{{}, {100, 100, 100}};
  results.push_back(lost);
  EXPECT_EQ(
      AbsoluteTrajectoryError(results, TrajectoryAlignment::kRigid)->poses, 5);
}

TEST(AbsoluteTrajectoryError, IsUnknownWhereNothingCanBeAligned) {
  EXPECT_FALSE(
      AbsoluteTrajectoryError({}, TrajectoryAlignment::kNone).has_value());
  const std::vector<FrameResult> line{
      At({0, 0, 0}, {}), At({1, 0, 0}, {1, 0, 0}), At({2, 0, 0}, {2, 0, 0})};
  EXPECT_FALSE(
      AbsoluteTrajectoryError(line, TrajectoryAlignment::kRigid).has_value());
  EXPECT_TRUE(
      AbsoluteTrajectoryError(line, TrajectoryAlignment::kNone).has_value());
}

}  // namespace
}  // namespace treeline::accuracy
