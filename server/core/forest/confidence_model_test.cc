#include "server/core/forest/confidence_model.h"

#include "gtest/gtest.h"

namespace treeline::forest {
namespace {

// All that can speak for a pose by features.
PoseEvidence Sure() {
  return {.inlier_ratio = 0.8,
          .correlation = 0.95,
          .agreement = 0.95,
          .visible = 2000,
          .overlap = 0.9,
          .measured = 1000,
          .depth_agreement = 1,
          .matches = 300,
          .sigma_m = 0.002};
}

TEST(ConfidenceModelTest, APlaceOfItsOwnMayLookOtherwiseInParts) {
  PoseEvidence evidence = Sure();
  evidence.distinct = 0.71;
  evidence.contradicted = 0.4;
  EXPECT_FALSE(MayBeElsewhere(evidence));
  EXPECT_EQ(ConfidenceModel::Typical().Probability(evidence),
            ConfidenceModel::Typical().Probability(Sure()));
}

TEST(ConfidenceModelTest, APlaceLikeOthersHasToLookAsLearnt) {
  PoseEvidence evidence = Sure();
  evidence.distinct = 0.5;
  EXPECT_FALSE(MayBeElsewhere(evidence));
  evidence.contradicted = 0.05;
  EXPECT_TRUE(MayBeElsewhere(evidence));
  EXPECT_LT(ConfidenceModel::Typical().Probability(evidence), 0.5);
  EXPECT_GT(ConfidenceModel::Typical().Probability(Sure()), 0.95);
}

TEST(ConfidenceModelTest, WhatIsFoundElsewhereSaysNothing) {
  PoseEvidence evidence = Sure();
  evidence.distinct = 0.2;
  EXPECT_TRUE(MayBeElsewhere(evidence));
}

TEST(ConfidenceModelTest, AForestLooksAtThePlaceAsAWhole) {
  PoseEvidence evidence = Sure();
  evidence.matches = 0;
  evidence.distinct = 0.2;
  evidence.contradicted = 0.4;
  EXPECT_FALSE(MayBeElsewhere(evidence));
}

}  // namespace
}  // namespace treeline::forest
