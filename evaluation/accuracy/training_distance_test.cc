#include "evaluation/accuracy/training_distance.h"

#include <vector>

#include "gtest/gtest.h"
#include "server/tools/testing_fixtures.h"

namespace treeline::accuracy {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;

TEST(DistanceToTraining, WeighsATurnLikeTheMoveOfWhatIsSeen) {
  // 10 cm away, or turned by 4 degrees: 1.5 m * 0.0698 rad = 10.5 cm.
  const geometry::Rigid3 moved{{}, {0.1, 0, 0}};
  const geometry::Rigid3 turned{
      geometry::Rotation3::FromAxisAngle({0, 4 * kDegree, 0}), {}};
  const auto nearest = DistanceToTraining({}, {turned, moved});
  ASSERT_TRUE(nearest.has_value());
  EXPECT_NEAR(nearest->translation_m, 0.1, 1e-12);
  EXPECT_NEAR(nearest->rotation_deg, 0, 1e-12);
  EXPECT_NEAR(nearest->combined_m, 0.1, 1e-12);
  EXPECT_NEAR(DistanceToTraining({}, {turned})->combined_m, 0.10472, 1e-5);
  EXPECT_FALSE(DistanceToTraining({}, {}).has_value());
}

FrameResult FrameAt(double x_m, double error_m) {
  FrameResult result;
  result.estimate = tools::LocalizedAt({{}, {x_m + error_m, 0, 0}});
  result.true_world_from_camera = geometry::Rigid3{{}, {x_m, 0, 0}};
  result.error = geometry::PoseError{error_m, 0};
  return result;
}

TEST(GroupByTrainingDistance, PutsAsManyFramesIntoEachFromNearToFar) {
  std::vector<FrameResult> results;
  for (int i = 9; i >= 0; --i) {
    // The nearer half is right.
    results.push_back(FrameAt(0.1 * i, i < 5 ? 0.01 : 0.2));
  }
  const std::vector<DistanceGroup> groups =
      GroupByTrainingDistance(results, {geometry::Rigid3{}});
  ASSERT_EQ(groups.size(), 5u);
  EXPECT_EQ(groups[0].frames, 2);
  EXPECT_NEAR(groups[0].distance_m, 0.05, 1e-12);
  EXPECT_EQ(groups[0].correct, 1);
  EXPECT_EQ(groups[2].correct, 0.5);
  EXPECT_NEAR(groups[2].distance_m, 0.45, 1e-12);
  EXPECT_EQ(groups[4].correct, 0);
  EXPECT_NEAR(groups[4].median_translation_m.value(), 0.2, 1e-12);
}

TEST(GroupByTrainingDistance, NeedsTrainingCamerasAndGroundTruth) {
  FrameResult unknown = FrameAt(0, 0);
  unknown.true_world_from_camera.reset();
  unknown.error.reset();
  EXPECT_TRUE(GroupByTrainingDistance({FrameAt(0, 0)}, {}).empty());
  EXPECT_TRUE(GroupByTrainingDistance({unknown}, {geometry::Rigid3{}}).empty());
  EXPECT_EQ(
      GroupByTrainingDistance({FrameAt(0, 0)}, {geometry::Rigid3{}}).size(),
      1u);
}

TEST(GroupByTrainingDistance, HasNoMedianWhereNothingWasLocalized) {
  FrameResult lost = FrameAt(0, 0);
  lost.estimate.outcome = localizer::Outcome::kNotLocalized;
  lost.error.reset();
  const std::vector<DistanceGroup> groups =
      GroupByTrainingDistance({lost}, {geometry::Rigid3{}});
  ASSERT_EQ(groups.size(), 1u);
  EXPECT_FALSE(groups[0].median_translation_m.has_value());
  EXPECT_EQ(groups[0].correct, 0);
}

}  // namespace
}  // namespace treeline::accuracy
