#include "server/core/localizer/alignment_trust.h"

#include "gtest/gtest.h"

namespace treeline::localizer {
namespace {

// Matched features that determine the position to sigma_m along one axis.
Candidate Matched(int inliers, double sigma_m) {
  Candidate candidate;
  candidate.is_matched = true;
  candidate.samples = 2 * inliers;
  candidate.pose.emplace();
  candidate.pose->inliers = inliers;
  candidate.pose->covariance[0] = sigma_m * sigma_m;
  return candidate;
}

TEST(IsDrawnAwayTest, BySoManyStandardDeviations) {
  EXPECT_TRUE(IsDrawnAway(Matched(100, 0.01), 0.031));
  EXPECT_FALSE(IsDrawnAway(Matched(100, 0.01), 0.029));
  EXPECT_FALSE(IsDrawnAway(Matched(100, 0.019), 0.031));
}

TEST(IsDrawnAwayTest, FeaturesThatLeaveDoubtSayNothing) {
  EXPECT_TRUE(IsDrawnAway(Matched(25, 0.019), 0.1));
  EXPECT_FALSE(IsDrawnAway(Matched(25, 0.021), 0.1));
  EXPECT_FALSE(IsDrawnAway(Matched(24, 0.019), 0.1));
}

TEST(IsDrawnAwayTest, NorDoesAForest) {
  Candidate candidate = Matched(100, 0.01);
  candidate.is_matched = false;
  EXPECT_FALSE(IsDrawnAway(candidate, 0.1));
}

}  // namespace
}  // namespace treeline::localizer
