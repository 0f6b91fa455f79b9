#include "server/core/localizer/report.h"

#include "gtest/gtest.h"

namespace treeline::localizer {
namespace {

Candidate WithPose() {
  Candidate candidate;
  candidate.samples = 200;
  candidate.pose.emplace();
  candidate.pose->inliers = 50;
  candidate.pose->world_from_camera.translation = {1, 2, 3};
  candidate.correspondences.resize(7);
  return candidate;
}

TEST(ReportTest, SaysWhatTheVerifierMadeOfThePose) {
  Verdict verdict;
  verdict.world_from_camera.translation = {1.5, 2, 3};
  verdict.covariance[0] = 0.25;
  verdict.confidence = 0.75;
  verdict.evidence.overlap = 0.5;
  const PoseEstimate estimate = Report(WithPose(), &verdict);
  EXPECT_EQ(estimate.outcome, Outcome::kLocalized);
  EXPECT_EQ(estimate.reason, NotLocalizedReason::kNone);
  EXPECT_EQ(estimate.world_from_camera, verdict.world_from_camera);
  EXPECT_EQ(estimate.covariance, verdict.covariance);
  EXPECT_EQ(estimate.confidence, 0.75);
  EXPECT_EQ(estimate.evidence.overlap, 0.5);
  EXPECT_EQ(estimate.inliers, 50);
  EXPECT_EQ(estimate.samples, 200);
  EXPECT_EQ(estimate.inlier_ratio, 0.25);
  EXPECT_EQ(estimate.correspondences.size(), 7u);
}

TEST(ReportTest, KeepsAPoseThatIsNotBelievedAndItsEvidence) {
  Verdict verdict;
  verdict.world_from_camera.translation = {1.5, 2, 3};
  verdict.reason = NotLocalizedReason::kLowConfidence;
  verdict.confidence = 0.25;
  const PoseEstimate estimate = Report(WithPose(), &verdict);
  EXPECT_EQ(estimate.outcome, Outcome::kNotLocalized);
  EXPECT_EQ(estimate.reason, NotLocalizedReason::kLowConfidence);
  EXPECT_EQ(estimate.confidence, 0.25);
  EXPECT_EQ(estimate.inliers, 50);
  EXPECT_EQ(estimate.world_from_camera, verdict.world_from_camera);
}

TEST(ReportTest, WithoutAPoseSaysWhyThereIsNone) {
  Candidate candidate;
  candidate.samples = 12;
  candidate.reason = NotLocalizedReason::kTooFewInliers;
  const PoseEstimate estimate = Report(candidate, nullptr);
  EXPECT_EQ(estimate.outcome, Outcome::kNotLocalized);
  EXPECT_EQ(estimate.reason, NotLocalizedReason::kTooFewInliers);
  EXPECT_EQ(estimate.samples, 12);
  EXPECT_EQ(estimate.inliers, 0);
  EXPECT_EQ(estimate.confidence, 0);
}

}  // namespace
}  // namespace treeline::localizer
