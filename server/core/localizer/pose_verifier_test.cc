#include "server/core/localizer/pose_verifier.h"

#include "gtest/gtest.h"
#include "server/core/localizer/support_verifier.h"

namespace treeline::localizer {
namespace {

TEST(ReasonAgainstTest, NamesTheFirstThatIsMissing) {
  EXPECT_EQ(ReasonAgainst({true, true, true, true}), NotLocalizedReason::kNone);
  EXPECT_EQ(ReasonAgainst({true, true, true, false}),
            NotLocalizedReason::kLowConfidence);
  EXPECT_EQ(ReasonAgainst({true, true, false, false}),
            NotLocalizedReason::kContradictsDepth);
  EXPECT_EQ(ReasonAgainst({true, false, false, false}),
            NotLocalizedReason::kPoorlyConstrained);
  EXPECT_EQ(ReasonAgainst({false, false, true, true}),
            NotLocalizedReason::kTooFewInliers);
}

TEST(IsBetterTest, WhatIsBelievedBeatsWhatIsMoreProbable) {
  const Verdict believed{.confidence = 0.6};
  const Verdict surer{.confidence = 0.7};
  const Verdict refused{.reason = NotLocalizedReason::kPoorlyConstrained,
                        .confidence = 0.9};
  EXPECT_TRUE(IsBetter(believed, refused));
  EXPECT_FALSE(IsBetter(refused, believed));
  EXPECT_TRUE(IsBetter(surer, believed));
  EXPECT_FALSE(IsBetter(believed, believed));
}

TEST(OddsRatioTest, IsOfTheChances) {
  const Verdict nine{.confidence = 0.9};
  const Verdict four{.confidence = 0.8};
  EXPECT_NEAR(OddsRatio(nine, four), 9.0 / 4, 1e-9);
  EXPECT_NEAR(OddsRatio(four, nine), 4.0 / 9, 1e-9);
  EXPECT_GT(OddsRatio(Verdict{.confidence = 1}, nine), 1e6);
  EXPECT_LT(OddsRatio(Verdict{.confidence = 0}, nine), 1e-6);
}

// A scene of which cameras stand 2 units away.
class SupportVerifierTest : public testing::Test {
 protected:
  static Verdict VerdictOn(int inliers, int samples, double position_sigma,
                           std::optional<double> min_confidence = 0.0) {
    Candidate candidate;
    candidate.samples = samples;
    candidate.pose.emplace();
    candidate.pose->inliers = inliers;
    candidate.places = inliers;
    candidate.pose->world_from_camera.translation = {1, 2, 3};
    candidate.pose->covariance[7] = position_sigma * position_sigma;
    forest::ModelInfo info;
    info.viewing_distance = 2;
    const image::Frame frame;
    const camera::RgbdCalibration calibration;
    LocalizeOptions options;
    options.min_confidence = min_confidence;
    QueryScratch scratch;
    Query query(frame, calibration, DepthUse::kIgnored, options, scratch);
    return SupportVerifier(info).Verify(query, candidate);
  }
};

TEST_F(SupportVerifierTest, LeavesThePoseAsItIs) {
  const Verdict verdict = VerdictOn(80, 100, 0.01);
  EXPECT_TRUE(verdict.is_believed());
  EXPECT_EQ(verdict.world_from_camera.translation, (geometry::Vec3{1, 2, 3}));
  EXPECT_EQ(verdict.covariance[7], 1e-4);
}

TEST_F(SupportVerifierTest, WantsTwelveInliers) {
  EXPECT_TRUE(VerdictOn(12, 20, 0.01).is_believed());
  EXPECT_EQ(VerdictOn(11, 20, 0.01).reason, NotLocalizedReason::kTooFewInliers);
}

TEST_F(SupportVerifierTest, WantsAPositionToATwentiethOfTheViewingDistance) {
  EXPECT_TRUE(VerdictOn(80, 100, 0.099).is_believed());
  EXPECT_EQ(VerdictOn(80, 100, 0.101).reason,
            NotLocalizedReason::kPoorlyConstrained);
}

TEST_F(SupportVerifierTest, AShareOfFewMatchesMeansLessThanOneOfMany) {
  const Verdict few = VerdictOn(16, 20, 0.01);
  const Verdict many = VerdictOn(160, 200, 0.01);
  EXPECT_LT(few.confidence, many.confidence);
  EXPECT_DOUBLE_EQ(few.evidence.inlier_ratio, 16. / 50);
  EXPECT_EQ(VerdictOn(16, 20, 0.01, 0.9999).reason,
            NotLocalizedReason::kLowConfidence);
}

}  // namespace
}  // namespace treeline::localizer
