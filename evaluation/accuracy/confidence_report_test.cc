#include "evaluation/accuracy/confidence_report.h"

#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/tools/testing_fixtures.h"

namespace treeline::accuracy {
namespace {

using ::testing::DoubleNear;
using ::testing::Optional;

constexpr PoseThreshold kWithin{0.05, 5};

FrameResult Answer(double confidence, bool correct) {
  FrameResult result;
  result.estimate = tools::LocalizedAt({});
  result.estimate.confidence = confidence;
  result.true_world_from_camera = geometry::Rigid3{};
  result.error = geometry::PoseError{correct ? 0.01 : 0.5, 0};
  return result;
}

TEST(AssessConfidence, WeighsTheGapOfEachBinByItsFrames) {
  // Two answers at 0.95, of which one is right; two at 0.55, both right.
  const ConfidenceReport report =
      AssessConfidence({Answer(0.95, true), Answer(0.95, false),
                        Answer(0.55, true), Answer(0.55, true)},
                       kWithin, 0.9);
  EXPECT_THAT(report.expected_calibration_error,
              Optional(DoubleNear(0.5 * 0.45 + 0.5 * 0.45, 1e-12)));
  EXPECT_THAT(report.Precision(), Optional(DoubleNear(0.5, 1e-12)));
  EXPECT_THAT(report.Recall(), Optional(DoubleNear(1.0 / 3, 1e-12)));
  EXPECT_EQ(report.bins[9].frames, 2);
  EXPECT_NEAR(report.bins[9].correct, 0.5, 1e-12);
  EXPECT_NEAR(report.bins[5].confidence, 0.55, 1e-12);
}

TEST(AssessConfidence, CountsCertaintyInTheLastBin) {
  const ConfidenceReport report =
      AssessConfidence({Answer(1, true)}, kWithin, 1);
  EXPECT_EQ(report.bins.back().frames, 1);
  EXPECT_EQ(report.confident, 1);
  EXPECT_THAT(report.expected_calibration_error,
              Optional(DoubleNear(0, 1e-12)));
}

TEST(AssessConfidence, LeavesOutFramesThatWereNotLocalized) {
  FrameResult lost;
  lost.true_world_from_camera = geometry::Rigid3{};
  EXPECT_EQ(AssessConfidence({lost, Answer(0.9, true)}, kWithin, 0.5).frames,
            1);
}

TEST(AssessConfidence, SaysNothingWhereNothingIsStated) {
  const ConfidenceReport report =
      AssessConfidence({Answer(0, true), Answer(0, false)}, kWithin, 0);
  EXPECT_FALSE(report.stated);
  EXPECT_FALSE(report.expected_calibration_error.has_value());
  EXPECT_FALSE(report.Precision().has_value());
  EXPECT_FALSE(AssessConfidence({}, kWithin, 0.9).Precision().has_value());
}

}  // namespace
}  // namespace treeline::accuracy
