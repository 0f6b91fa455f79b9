#include "evaluation/accuracy/scene_coordinate_errors.h"

#include <filesystem>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/tools/testing_fixtures.h"

namespace treeline::accuracy {
namespace {

using ::testing::IsEmpty;

EvaluationOptions Quiet() {
  EvaluationOptions options;
  options.quiet = true;
  return options;
}

// The recording's cameras: depth is 2 m everywhere.
forest::ModelInfo ModelOf(const dataset::Dataset& dataset) {
  forest::ModelInfo info;
  info.calibration = dataset.calibration();
  info.calibration.depth = info.calibration.color;
  return info;
}

// Predicts (0, 0, 2) for the middle pixel and a point 3 cm beside the truth of
// pixel (5, 3), in a world whose origin is the camera.
localizer::PoseEstimate TwoPredictions(
    const localizer::LocalizeOptions& options) {
  localizer::PoseEstimate estimate = tools::LocalizedAt({});
  if (options.keep_correspondences) {
    estimate.correspondences = {{{4, 3}, {}, {0, 0, 2}, true},
                                {{5, 3}, {}, {0.2, 0.03, 2}, false}};
  }
  return estimate;
}

TEST(SceneCoordinateErrors, AreDistancesFromRecordedDepth) {
  const tools::SmallRecording recording(
      2, {geometry::Rigid3{}});  // frame 1 has no pose
  const dataset::Dataset dataset = recording.Open();
  const tools::FunctionLocalizer localizer(
      ModelOf(dataset),
      [](const image::Frame&, const localizer::LocalizeOptions& options) {
        return TwoPredictions(options);
      });
  const auto errors = SceneCoordinateErrors(localizer, dataset, 10, Quiet());
  ASSERT_TRUE(errors.ok()) << errors.status();
  ASSERT_EQ(errors->size(), 2u);
  EXPECT_NEAR((*errors)[0], 0, 1e-9);
  EXPECT_NEAR((*errors)[1], 0.03, 1e-9);
}

TEST(SceneCoordinateErrors, UseTheTruePoseAndNotTheEstimate) {
  const geometry::Rigid3 truth{{}, {1, 0, 0}};
  const tools::SmallRecording recording(1, {truth});
  const dataset::Dataset dataset = recording.Open();
  const tools::FunctionLocalizer localizer(
      ModelOf(dataset),
      [](const image::Frame&, const localizer::LocalizeOptions& options) {
        localizer::PoseEstimate estimate = tools::LocalizedAt({{}, {9, 9, 9}});
        if (options.keep_correspondences) {
          estimate.correspondences = {{{4, 3}, {}, {1, 0, 2.5}, false}};
        }
        return estimate;
      });
  const auto errors = SceneCoordinateErrors(localizer, dataset, 10, Quiet());
  ASSERT_TRUE(errors.ok()) << errors.status();
  ASSERT_EQ(errors->size(), 1u);
  EXPECT_NEAR(errors->front(), 0.5, 1e-9);
}

TEST(SceneCoordinateErrors, LeaveOutFramesThatFail) {
  const tools::SmallRecording recording(3, std::vector<geometry::Rigid3>(3));
  const dataset::Dataset dataset = recording.Open();
  std::filesystem::remove(recording.ColorPath(1));
  const tools::FunctionLocalizer localizer(
      ModelOf(dataset),
      [](const image::Frame& frame, const localizer::LocalizeOptions& options)
          -> absl::StatusOr<localizer::PoseEstimate> {
        if (tools::FrameNumber(frame) == 2)
          return absl::InvalidArgumentError("no");
        return TwoPredictions(options);
      });
  const auto errors = SceneCoordinateErrors(localizer, dataset, 10, Quiet());
  ASSERT_TRUE(errors.ok()) << errors.status();
  EXPECT_EQ(errors->size(), 2u);
}

TEST(TakeHeatMaps, ShowsFramesWithGroundTruthAlone) {
  const tools::SmallRecording recording(2, {geometry::Rigid3{}});
  const dataset::Dataset dataset = recording.Open();
  const tools::FunctionLocalizer localizer(
      ModelOf(dataset),
      [](const image::Frame&, const localizer::LocalizeOptions& options) {
        return TwoPredictions(options);
      });
  const std::vector<ErrorHeatMap> maps =
      TakeHeatMaps(localizer, dataset, {0, 1}, Quiet());
  ASSERT_EQ(maps.size(), 1u);
  EXPECT_EQ(maps[0].stem, "seq-01/frame-000000");
  EXPECT_EQ(maps[0].predictions, 2);
  EXPECT_NEAR(maps[0].median_error_m, 0.015, 1e-9);
  EXPECT_EQ(maps[0].map_jpeg.substr(0, 2), "\xff\xd8");
  EXPECT_THAT(TakeHeatMaps(localizer, dataset, {1}, Quiet()), IsEmpty());
}

TEST(HeatColor, ClampsAtBothEnds) {
  EXPECT_EQ(HeatColor(-1), HeatColor(0));
  EXPECT_EQ(HeatColor(7), HeatColor(1));
  EXPECT_NE(HeatColor(0), HeatColor(1));
  EXPECT_EQ(HeatColor(0).size(), 7u);
}

}  // namespace
}  // namespace treeline::accuracy
