#include "evaluation/accuracy/report_pictures.h"

#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/tools/testing_fixtures.h"

namespace treeline::accuracy {
namespace {

using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::IsEmpty;

constexpr double kDegree = 3.14159265358979323846 / 180;

FrameResult Localized(const std::string& stem, double translation_m) {
  FrameResult result;
  result.stem = stem;
  result.estimate = tools::LocalizedAt({{}, {translation_m, 0, 0}});
  result.true_world_from_camera = geometry::Rigid3{};
  result.error = geometry::PoseError{translation_m, 0.5 * kDegree};
  result.latency_ms = 3;
  result.decode_ms = 4;
  return result;
}

FrameResult Lost(const std::string& stem) {
  FrameResult result;
  result.stem = stem;
  result.estimate.reason = localizer::NotLocalizedReason::kTooFewInliers;
  result.true_world_from_camera = geometry::Rigid3{};
  result.latency_ms = 3;
  return result;
}

FrameResult Failed(const std::string& stem) {
  FrameResult result;
  result.stem = stem;
  result.status = absl::NotFoundError("no such file");
  return result;
}

TEST(ChoosePictures, TakesWorstMedianAndBestOfFramesThatCanBeShown) {
  // Errors grow with the index; neighbours look alike and are not taken
  // together while others remain.
  std::vector<FrameResult> results;
  for (int i = 0; i < 40; ++i) {
    results.push_back(Localized("f", 0.001 * (i + 1)));
  }
  results.push_back(Failed("failed"));
  const std::vector<PictureChoice> choices = ChoosePictures(results, 2, 1, 1);
  std::vector<int> frames;
  for (const PictureChoice& choice : choices) frames.push_back(choice.frame);
  EXPECT_THAT(frames, ElementsAre(39, 35, 19, 0));
}

TEST(ChoosePictures, PutsLostFramesFirst) {
  const std::vector<PictureChoice> choices =
      ChoosePictures({Localized("far", 9), Lost("lost")}, 1, 0, 0);
  EXPECT_THAT(choices, ElementsAre(Field(&PictureChoice::frame, 1)));
}

TEST(ChoosePictures, NeverShowsAFrameTwice) {
  EXPECT_THAT(ChoosePictures({Localized("only", 0.01)}, 3, 3, 3),
              ElementsAre(Field(&PictureChoice::kind, PictureKind::kWorst)));
  EXPECT_THAT(ChoosePictures({}, 3, 3, 3), IsEmpty());
}

TEST(TakePictures, AsksForCorrespondencesWithTheSeedOfTheEvaluation) {
  const tools::SmallRecording recording(2, {});
  EvaluationOptions options;
  options.seed = 5;
  const tools::FunctionLocalizer localizer(
      {},
      [](const image::Frame& frame, const localizer::LocalizeOptions& query) {
        localizer::PoseEstimate estimate = tools::LocalizedAt({});
        if (query.keep_correspondences) {
          estimate.correspondences.push_back(
              {{static_cast<double>(tools::FrameNumber(frame)),
                static_cast<double>(query.seed)},
               {},
               {},
               true});
        }
        return estimate;
      });
  const std::vector<ReportPicture> pictures = TakePictures(
      localizer, recording.Open(), {{1, PictureKind::kBest}}, options);
  ASSERT_EQ(pictures.size(), 1u);
  EXPECT_EQ(pictures[0].width, 8);
  EXPECT_EQ(pictures[0].height, 6);
  ASSERT_EQ(pictures[0].correspondences.size(), 1u);
  EXPECT_EQ(pictures[0].correspondences[0].color_pixel.x, 1);
  EXPECT_EQ(pictures[0].correspondences[0].color_pixel.y, 5);
  EXPECT_EQ(pictures[0].jpeg.substr(0, 2), "\xff\xd8");
}

}  // namespace
}  // namespace treeline::accuracy
