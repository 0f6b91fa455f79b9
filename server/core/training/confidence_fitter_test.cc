#include "server/core/training/confidence_fitter.h"

#include <cmath>
#include <numeric>

#include "common/base/random.h"
#include "gtest/gtest.h"

namespace treeline::training {
namespace {

// Every trial counts.
constexpr ConfidenceFit kAll = {.constant_sigma = 3,
                                .weight_sigma = 3,
                                .independent_trials = 1e9,
                                .max_threshold = 0.99};

// Poses whose chance of being right grows with their share of inliers.
std::vector<ConfidenceTrial> MakeTrials(uint64_t seed, int count) {
  base::Random random(seed, 1);
  std::vector<ConfidenceTrial> trials;
  for (int i = 0; i < count; ++i) {
    ConfidenceTrial trial;
    trial.evidence.inlier_ratio = random.NextUniform(0, 0.5);
    trial.evidence.visible = 500;
    trial.evidence.correlation = random.NextUniform(0.5, 0.9);
    const double logit = -8 + 20 * std::sqrt(trial.evidence.inlier_ratio);
    trial.is_right = random.NextUnit() < 1 / (1 + std::exp(-logit));
    trial.is_gross = !trial.is_right;
    trials.push_back(trial);
  }
  return trials;
}

TEST(ConfidenceFitterTest, ProbabilitiesMeanWhatTheySay) {
  const forest::ConfidenceModel model = FitConfidence(
      MakeTrials(1, 2000), forest::ConfidenceModel::Typical(), kAll);
  // On other trials: of those that get about p, a share of p is right.
  constexpr int kBins = 5;
  double said[kBins] = {};
  double right[kBins] = {};
  int count[kBins] = {};
  for (const ConfidenceTrial& trial : MakeTrials(2, 4000)) {
    const double p = model.Probability(trial.evidence);
    ASSERT_GE(p, 0);
    ASSERT_LE(p, 1);
    const int bin = std::min(kBins - 1, static_cast<int>(kBins * p));
    said[bin] += p;
    right[bin] += trial.is_right;
    ++count[bin];
  }
  for (int b = 0; b < kBins; ++b) {
    if (count[b] < 100) continue;
    EXPECT_NEAR(said[b] / count[b], right[b] / count[b], 0.08) << b;
  }
}

TEST(ConfidenceFitterTest, MoreEvidenceNeverCountsAgainstAPose) {
  // Trials in which correlation misleads.
  std::vector<ConfidenceTrial> trials = MakeTrials(3, 500);
  for (ConfidenceTrial& trial : trials) {
    trial.evidence.correlation = trial.is_right ? 0.2 : 0.9;
  }
  const forest::ConfidenceModel model =
      FitConfidence(trials, forest::ConfidenceModel::Typical());
  for (size_t i = 1; i < forest::ConfidenceModel::kFeatures; ++i) {
    EXPECT_GE(model.weights[i], 0)
        << forest::ConfidenceModel::FeatureNames()[i];
  }
}

TEST(ConfidenceFitterTest, TheThresholdKeepsAnswersPrecise) {
  const std::vector<ConfidenceTrial> trials = MakeTrials(4, 3000);
  const forest::ConfidenceModel model =
      FitConfidence(trials, forest::ConfidenceModel::Typical(), kAll);
  int given = 0;
  int wrong = 0;
  for (const ConfidenceTrial& trial : trials) {
    if (model.Probability(trial.evidence) < model.threshold) continue;
    ++given;
    wrong += !trial.is_right;
  }
  EXPECT_GT(given, 500);
  EXPECT_LE(wrong, 0.006 * given);
  EXPECT_GE(model.threshold, 0.5);

  // What is wrong by a little does not raise it.
  std::vector<ConfidenceTrial> nearly = trials;
  for (ConfidenceTrial& trial : nearly) trial.is_gross = false;
  EXPECT_EQ(
      FitConfidence(nearly, forest::ConfidenceModel::Typical(), kAll).threshold,
      kAll.min_threshold);
}

TEST(ConfidenceFitterTest, ManyTrialsOfOneSceneMoveThePriorByAFewAlone) {
  const forest::ConfidenceModel prior = forest::ConfidenceModel::Typical();
  const std::vector<ConfidenceTrial> trials = MakeTrials(5, 3000);
  const auto moved = [&](const ConfidenceFit& fit) {
    const forest::ConfidenceModel model = FitConfidence(trials, prior, fit);
    double sum = 0;
    for (size_t i = 0; i < model.weights.size(); ++i) {
      sum += std::abs(model.weights[i] - prior.weights[i]);
    }
    return sum;
  };
  EXPECT_LT(moved({}), 0.8 * moved(kAll));
  EXPECT_LE(
      FitConfidence(trials, prior, {.min_threshold = 0.5, .max_threshold = 0.6})
          .threshold,
      0.6);
}

TEST(ConfidenceFitterTest, WithoutTrialsThePriorHolds) {
  const forest::ConfidenceModel prior = forest::ConfidenceModel::Typical();
  EXPECT_EQ(FitConfidence({}, prior).weights, prior.weights);
}

TEST(ConfidenceFitterTest, FocalLengthsAreKnownAsWellAsTrialsShow) {
  const auto scale_of = [](double spread, int count, bool is_right) {
    base::Random random(7, 1);
    std::vector<ConfidenceTrial> trials(static_cast<size_t>(count));
    for (ConfidenceTrial& trial : trials) {
      trial.is_right = is_right;
      trial.focal_error_sigmas = spread * std::abs(random.NextGaussian());
    }
    return FitConfidence(trials, forest::ConfidenceModel::Typical())
        .focal_sigma_scale;
  };
  // The 95th percentile of 400 is known to about 5 %.
  EXPECT_NEAR(scale_of(1, 400, true), 1, 0.2);
  EXPECT_NEAR(scale_of(3, 400, true), 3, 0.5);
  // Never narrower; nothing of few trials, of none that tells, of wrong poses.
  EXPECT_EQ(scale_of(0.3, 400, true), 1);
  EXPECT_EQ(scale_of(3, 19, true), 1);
  EXPECT_EQ(scale_of(0, 400, true), 1);
  EXPECT_EQ(scale_of(3, 400, false), 1);
}

TEST(ConfidenceFitterTest, BlocksHeldOutHaveNoNeighboursAmongThoseLearnt) {
  std::vector<int> frames(500);
  std::iota(frames.begin(), frames.end(), 100);
  const HeldOutSplit split = SplitForConfidence(frames);
  EXPECT_GT(split.held_out.size(), 80u);
  EXPECT_GT(split.train.size(), 200u);
  for (const int held : split.held_out) {
    for (const int train : split.train) {
      ASSERT_GE(std::abs(held - train), 8);
    }
  }
  const HeldOutSplit small =
      SplitForConfidence(std::span(frames).subspan(0, 20));
  EXPECT_EQ(small.train.size(), 20u);
  EXPECT_TRUE(small.held_out.empty());
}

TEST(ConfidenceFitterTest, OfFewPhotographsEveryFourthIsHeldOut) {
  std::vector<int> frames(500);
  std::iota(frames.begin(), frames.end(), 100);
  const auto split = [&](size_t count) {
    return SplitPhotographsForConfidence(std::span(frames).first(count));
  };
  EXPECT_TRUE(split(19).held_out.empty());
  EXPECT_EQ(split(20).held_out, (std::vector<int>{103, 107, 111, 115, 119}));
  EXPECT_EQ(split(20).train.size(), 15u);
  EXPECT_EQ(split(60).held_out,
            SplitForConfidence(std::span(frames).first(60)).held_out);
}

}  // namespace
}  // namespace treeline::training
