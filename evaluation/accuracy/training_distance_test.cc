#include "evaluation/accuracy/training_distance.h"

#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/tools/testing_fixtures.h"

namespace treeline::accuracy {
namespace {

using ::testing::ElementsAre;

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

FrameResult FrameAt(double x_m, double turn_deg, double error_m) {
  FrameResult result;
  const geometry::Rigid3 truth{
      geometry::Rotation3::FromAxisAngle({0, turn_deg * kDegree, 0}),
      {x_m, 0, 0}};
  result.estimate = tools::LocalizedAt(truth);
  result.true_world_from_camera = truth;
  result.error = geometry::PoseError{error_m, 0};
  return result;
}

std::vector<int> Frames(const std::vector<TrainingDistanceBin>& bins) {
  std::vector<int> frames;
  for (const TrainingDistanceBin& bin : bins) {
    frames.push_back(bin.counts.frames);
  }
  return frames;
}

TEST(ViewGap, IsAboveOneBeyondEitherLimit) {
  const auto gap = [](double x_m, double turn_deg) {
    return ViewGap(*FrameAt(x_m, turn_deg, 0).true_world_from_camera,
                   {geometry::Rigid3{}}, ViewLimits{});
  };
  EXPECT_NEAR(gap(0.15, 0), 0.5, 1e-9);
  EXPECT_NEAR(gap(0.15, 12), 0.8, 1e-9);
  EXPECT_NEAR(gap(0.6, 5), 2, 1e-9);
  EXPECT_NEAR(gap(0, 30), 2, 1e-9);
  // The nearest by one measure need not be near by the other.
  const std::vector<geometry::Rigid3> cameras{
      *FrameAt(0, 20, 0).true_world_from_camera,
      *FrameAt(0.27, 3, 0).true_world_from_camera};
  EXPECT_NEAR(ViewGap(geometry::Rigid3{}, cameras, ViewLimits{}), 0.9, 1e-9);
  EXPECT_GT(ViewGap(geometry::Rigid3{}, std::vector<geometry::Rigid3>{},
                    ViewLimits{}),
            1e300);
}

TEST(BinByTrainingDistance, PutsEachFrameIntoOneBinOfEveryList) {
  EvaluatedMethod method;
  method.training_poses = {geometry::Rigid3{}};
  method.results = {FrameAt(0.05, 2, 0.01),  // gap 0.17
                    FrameAt(0.25, 0, 0.01),  // 0.83
                    FrameAt(0.25, 12, 0.2),  // 0.83
                    FrameAt(0.1, 20, 0.01),  // 1.33
                    FrameAt(2, 90, 0.2)};    // 6.7
  FrameResult unknown = FrameAt(0, 0, 0);
  unknown.true_world_from_camera.reset();
  method.results.push_back(unknown);
  const TrainingDistanceBins bins = BinByTrainingDistance(method, 0.5);
  EXPECT_THAT(Frames(bins.by_distance_m), ElementsAre(1, 1, 2, 0, 0, 1));
  EXPECT_THAT(Frames(bins.by_angle_deg), ElementsAre(2, 0, 1, 1, 0, 1));
  EXPECT_THAT(Frames(bins.by_view_gap), ElementsAre(1, 2, 1, 0, 1));
  EXPECT_EQ(bins.by_view_gap[1].counts.right, 1);
  EXPECT_EQ(bins.by_view_gap[1].low, 0.5);
  EXPECT_EQ(bins.by_view_gap[1].high, 1.0);
  EXPECT_FALSE(bins.by_view_gap.back().high.has_value());
}

TEST(BinByTrainingDistance, TakesTheViewingDistanceWhereThereIsNoMetre) {
  EvaluatedMethod method;
  method.model.units_are_metres = false;
  method.model.viewing_distance = 15;
  method.training_poses = {geometry::Rigid3{}};
  method.results = {FrameAt(2.5, 0, 0)};  // a quarter of a metre
  EXPECT_THAT(Frames(BinByTrainingDistance(method, 0.5).by_distance_m),
              ElementsAre(0, 0, 1, 0, 0, 0));
}

TEST(BinByTrainingDistance, NeedsTrainingCamerasAndGroundTruth) {
  EvaluatedMethod method;
  method.results = {FrameAt(0, 0, 0)};
  EXPECT_TRUE(BinByTrainingDistance(method, 0.5).by_view_gap.empty());
  method.training_poses = {geometry::Rigid3{}};
  method.results[0].true_world_from_camera.reset();
  EXPECT_TRUE(BinByTrainingDistance(method, 0.5).by_view_gap.empty());
}

}  // namespace
}  // namespace treeline::accuracy
