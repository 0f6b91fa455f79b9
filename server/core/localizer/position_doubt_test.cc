#include "server/core/localizer/position_doubt.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <limits>
#include <optional>

#include "server/core/localizer/parameters.h"

namespace treeline::localizer {
namespace {

// Of an error with standard deviation `sigma_m` along (1, 1, 0), and a tenth of
// it across.
geometry::PoseCovariance Aslant(double sigma_m) {
  const double along = sigma_m * sigma_m;
  const double across = along / 100;
  geometry::PoseCovariance covariance{};
  covariance[0] = covariance[7] = (along + across) / 2;
  covariance[1] = covariance[6] = (along - across) / 2;
  covariance[14] = across;
  return covariance;
}

TEST(PositionDoubt, CountsTheAxisThatIsKnownLeast) {
  // Within one, two and three standard deviations of a normal distribution.
  EXPECT_NEAR(ProbabilityNear(Aslant(kApart_m)), 0.6827, 1e-4);
  EXPECT_NEAR(ProbabilityNear(Aslant(kApart_m / 2)), 0.9545, 1e-4);
  EXPECT_NEAR(ProbabilityNear(Aslant(kApart_m / 3)), 0.9973, 1e-4);
}

TEST(PositionDoubt, WhatIsExactIsNearAndWhatIsUnknownIsNot) {
  EXPECT_EQ(ProbabilityNear({}), 1);
  EXPECT_LT(ProbabilityNear(Aslant(10)), 0.01);
  geometry::PoseCovariance unknown{};
  unknown[7] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(ProbabilityNear(unknown), 0);
}

TEST(PositionDoubt, ErrorsAreWidenedAndAdded) {
  const geometry::PoseCovariance sum =
      Sum(Widened(Aslant(0.03), 2), Aslant(0.02));
  for (size_t i = 0; i < sum.size(); ++i) {
    EXPECT_NEAR(sum[i], 4 * Aslant(0.03)[i] + Aslant(0.02)[i], 1e-12);
  }
}

constexpr double kMinConfidence = 0.7;

PoseEstimate Sure() {
  PoseEstimate estimate;
  estimate.outcome = Outcome::kLocalized;
  estimate.reason = NotLocalizedReason::kNone;
  estimate.confidence = 0.96;
  estimate.covariance = Aslant(0.005);
  return estimate;
}

PoseEstimate Weighed(const std::optional<geometry::PoseCovariance>& of_features,
                     const std::optional<geometry::PoseCovariance>& camera,
                     double scale) {
  PoseEstimate estimate = Sure();
  WeighDoubt(of_features, camera, scale, kMinConfidence, estimate);
  return estimate;
}

TEST(PositionDoubt, ASureAnswerThatIsDeterminedStaysOne) {
  const PoseEstimate estimate = Weighed(Aslant(0.01), Aslant(0), 1);
  EXPECT_EQ(estimate.outcome, Outcome::kLocalized);
  EXPECT_NEAR(estimate.confidence, 0.96, 1e-5);
  EXPECT_EQ(estimate.covariance, Sure().covariance);
}

TEST(PositionDoubt, WhatIsNotDeterminedIsNoAnswerHoweverSure) {
  // Five of a hundred are off by two standard deviations, one in three by one.
  EXPECT_NEAR(Weighed(Aslant(0.025), Aslant(0), 1).confidence, 0.96 * 0.9545,
              1e-4);
  const PoseEstimate wide = Weighed(Aslant(0.05), Aslant(0), 1);
  EXPECT_EQ(wide.outcome, Outcome::kNotLocalized);
  EXPECT_EQ(wide.reason, NotLocalizedReason::kPoorlyConstrained);
  // A camera that is known to 4 cm, and one to 2 cm where that is understated.
  EXPECT_EQ(Weighed(Aslant(0.03), Aslant(0.04), 1).outcome,
            Outcome::kNotLocalized);
  EXPECT_EQ(Weighed(Aslant(0.03), Aslant(0.02), 1).outcome,
            Outcome::kLocalized);
  EXPECT_EQ(Weighed(Aslant(0.03), Aslant(0.02), 2).outcome,
            Outcome::kNotLocalized);
}

TEST(PositionDoubt, ACameraThatNothingTellsOfIsNoAnswer) {
  EXPECT_EQ(Weighed(Aslant(0.01), std::nullopt, 1).confidence, 0);
  EXPECT_EQ(Weighed(Aslant(0.01), std::nullopt, 1).outcome,
            Outcome::kNotLocalized);
}

TEST(PositionDoubt, TheAnswersCovarianceHasIt) {
  const PoseEstimate estimate = Weighed(Aslant(0.01), Aslant(0.01), 2);
  EXPECT_NEAR(estimate.covariance[14],
              4 * (Aslant(0.005)[14] + Aslant(0.01)[14]), 1e-12);
  // Where something else holds the pose it is told, and nothing else.
  const PoseEstimate held = Weighed(std::nullopt, Aslant(0.05), 2);
  EXPECT_EQ(held.outcome, Outcome::kLocalized);
  EXPECT_EQ(held.confidence, Sure().confidence);
  EXPECT_NEAR(held.covariance[14], Aslant(0.005)[14] + 4 * Aslant(0.05)[14],
              1e-12);
}

}  // namespace
}  // namespace treeline::localizer
