#include "evaluation/accuracy/answer_counts.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/tools/testing_fixtures.h"

namespace treeline::accuracy {
namespace {

using ::testing::DoubleEq;
using ::testing::Optional;

FrameResult Answered(double translation_m, double confidence) {
  FrameResult result;
  result.estimate = tools::LocalizedAt({});
  result.estimate.confidence = confidence;
  result.true_world_from_camera = geometry::Rigid3{};
  result.error = geometry::PoseError{translation_m, 0};
  result.latency_ms = 4;
  return result;
}

FrameResult Refused(double translation_m) {
  FrameResult result;
  result.estimate.inliers = 7;
  result.estimate.confidence = 0.2;
  result.true_world_from_camera = geometry::Rigid3{};
  result.refused_error = geometry::PoseError{translation_m, 0};
  result.latency_ms = 8;
  return result;
}

FrameResult Failed() {
  FrameResult result;
  result.status = absl::NotFoundError("gone");
  result.true_world_from_camera = geometry::Rigid3{};
  return result;
}

FrameResult WithoutTruth() {
  FrameResult result = Answered(0, 0.9);
  result.true_world_from_camera.reset();
  result.error.reset();
  return result;
}

TEST(CountAnswers, TellsRightRefusedAndWrongApart) {
  const AnswerCounts counts =
      CountAnswers({Answered(0.01, 0.9), Answered(0.02, 0.4),
                    Answered(0.07, 0.8), Answered(0.3, 0.7), Answered(0.3, 0.3),
                    Refused(0.01), Refused(0.4), Failed(), WithoutTruth()},
                   {}, 0.5);
  EXPECT_EQ(counts.frames, 8);
  EXPECT_EQ(counts.answered, 5);
  EXPECT_EQ(counts.right, 2);
  EXPECT_EQ(counts.found, 3);
  EXPECT_EQ(counts.relied_on, 3);
  EXPECT_EQ(counts.wrong, 2);
  EXPECT_EQ(counts.gross, 1);
  EXPECT_THAT(counts.ShareRight(), Optional(DoubleEq(2.0 / 8)));
  EXPECT_THAT(counts.ShareAnswered(), Optional(DoubleEq(5.0 / 8)));
  EXPECT_THAT(counts.ShareFound(), Optional(DoubleEq(3.0 / 8)));
  EXPECT_THAT(counts.Coverage(), Optional(DoubleEq(2.0 / 3)));
  EXPECT_THAT(counts.Precision(), Optional(DoubleEq(1.0 / 3)));
  EXPECT_TRUE(counts.calibration_error.has_value());
  EXPECT_DOUBLE_EQ(counts.latency_ms->p50, 4);
}

TEST(CountAnswers, ReliesOnAllAnswersOfAMethodWithoutConfidence) {
  const AnswerCounts counts =
      CountAnswers({Answered(0.01, 0), Answered(0.3, 0)}, {}, 0.5);
  EXPECT_EQ(counts.relied_on, 2);
  EXPECT_EQ(counts.wrong, 1);
  EXPECT_THAT(counts.Precision(), Optional(DoubleEq(0.5)));
  EXPECT_FALSE(counts.calibration_error.has_value());
}

TEST(CountAnswers, HasNoSharesOfNothing) {
  const AnswerCounts counts = CountAnswers({}, {}, 0.5);
  EXPECT_FALSE(counts.ShareRight().has_value());
  EXPECT_FALSE(counts.Coverage().has_value());
  EXPECT_FALSE(counts.Precision().has_value());
}

TEST(CountForeignAnswers, CallsEveryAnswerWrong) {
  FrameResult confident = WithoutTruth();
  FrameResult doubtful = WithoutTruth();
  doubtful.estimate.confidence = 0.1;
  FrameResult refused;
  const AnswerCounts counts =
      CountForeignAnswers({confident, doubtful, refused, Failed()}, 0.5);
  EXPECT_EQ(counts.frames, 3);
  EXPECT_EQ(counts.answered, 2);
  EXPECT_EQ(counts.wrong, 1);
  EXPECT_EQ(counts.gross, 1);
  EXPECT_EQ(counts.right, 0);
}

TEST(RightWithin, IsRelativeWhereTheUnitIsArbitrary) {
  FrameResult far = Answered(0, 0);
  far.true_world_from_camera->translation = {0, 300, 400};
  const std::vector<FrameResult> results{Answered(0, 0), far};
  EXPECT_EQ(RightWithin(results, true), PoseThreshold{});
  EXPECT_DOUBLE_EQ(RightWithin(results, false).translation_m, 5);
  EXPECT_DOUBLE_EQ(RightWithin(results, false).rotation_deg, 5);
}

}  // namespace
}  // namespace treeline::accuracy
