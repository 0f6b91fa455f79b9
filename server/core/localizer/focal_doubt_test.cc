#include "server/core/localizer/focal_doubt.h"

#include <gtest/gtest.h>

#include <cmath>

namespace treeline::localizer {
namespace {

constexpr pose::FocalEstimate kLonger{.scale = 1.05, .sigma = 0.01};

std::optional<OtherFocal> OfFeatures(const FocalDoubt& doubt,
                                     const pose::FocalEstimate& focal) {
  return doubt.Other({focal, std::nullopt});
}

TEST(FocalDoubtTest, IsOfOneThatTheStatedOneIsFarFrom) {
  const FocalDoubt known(/*may_be_guessed=*/false, /*sigma_scale=*/1);
  ASSERT_TRUE(OfFeatures(known, kLonger).has_value());
  EXPECT_EQ(OfFeatures(known, kLonger)->scale, 1.05);
  const pose::FocalEstimate shorter{.scale = 1 / 1.05, .sigma = 0.01};
  EXPECT_EQ(OfFeatures(known, shorter)->scale, shorter.scale);
  EXPECT_FALSE(OfFeatures(known, {.scale = 1.05, .sigma = 0.013}).has_value());
  // However well it is known.
  EXPECT_FALSE(OfFeatures(known, {.scale = 1.01, .sigma = 1e-4}).has_value());
  EXPECT_FALSE(known.Other({}).has_value());
}

TEST(FocalDoubtTest, AGuessIsGivenUpForLess) {
  const FocalDoubt guess(/*may_be_guessed=*/true, /*sigma_scale=*/1);
  const auto little = OfFeatures(guess, {.scale = 1.05, .sigma = 0.03});
  ASSERT_TRUE(little.has_value());
  EXPECT_EQ(little->needed_odds, 1);
  const auto clear = OfFeatures(guess, {.scale = 1.05, .sigma = 0.005});
  ASSERT_TRUE(clear.has_value());
  EXPECT_LT(clear->needed_odds, 1);
}

TEST(FocalDoubtTest, AGuessIsConfirmedByFeaturesThatKnowIt) {
  const auto by = [](const pose::FocalEstimate& focal) {
    return IsGuessConfirmed({focal, std::nullopt}, /*max_sigma=*/0.01);
  };
  EXPECT_TRUE(by({.scale = 1.01, .sigma = 0.01}));
  EXPECT_FALSE(by({.scale = 1, .sigma = 0.011}));
  EXPECT_FALSE(by(kLonger));
  EXPECT_FALSE(IsGuessConfirmed({}, 1));
  EXPECT_FALSE(IsGuessConfirmed({std::nullopt, kLonger}, 1));
}

TEST(FocalDoubtTest, ALittleOfItAsksForABetterAnswer) {
  const FocalDoubt known(/*may_be_guessed=*/false, /*sigma_scale=*/1);
  EXPECT_GT(OfFeatures(known, kLonger)->needed_odds, 1);
  EXPECT_LT(OfFeatures(known, {.scale = 1.05, .sigma = 0.005})->needed_odds, 1);
  const FocalDoubt in_vague_scene(/*may_be_guessed=*/false, /*sigma_scale=*/3);
  EXPECT_GT(
      OfFeatures(in_vague_scene, {.scale = 1.05, .sigma = 0.005})->needed_odds,
      1);
}

TEST(FocalDoubtTest, PointsAndFeaturesCountByHowWellTheyKnow) {
  const FocalDoubt known(/*may_be_guessed=*/false, /*sigma_scale=*/1);
  // Each alone is not sure enough.
  const pose::FocalEstimate vague{.scale = 1.05, .sigma = 0.02};
  const auto both = known.Other({vague, vague});
  ASSERT_TRUE(both.has_value());
  EXPECT_NEAR(both->scale, 1.05, 1e-9);
  EXPECT_FALSE(known.Other({vague, std::nullopt}).has_value());
  // Points that know the stated one to be right outweigh what features say,
  // the more so where these state too much.
  const pose::FocalEstimate right{.scale = 1, .sigma = 0.007};
  EXPECT_FALSE(known.Other({kLonger, right}).has_value());
  const FocalDoubt in_vague_scene(/*may_be_guessed=*/false, /*sigma_scale=*/3);
  const pose::FocalEstimate sure{.scale = 1.05, .sigma = 0.004};
  const auto corrected = known.Other({sure, right});
  ASSERT_TRUE(corrected.has_value());
  EXPECT_NEAR(std::log(corrected->scale), std::log(1.05) / (1 + 16. / 49),
              1e-9);
  EXPECT_FALSE(in_vague_scene.Other({sure, right}).has_value());
  // Points alone correct nothing.
  EXPECT_FALSE(known.Other({std::nullopt, sure}).has_value());
}

TEST(FocalDoubtTest, PointsAreDoubtedOnlyIfTheyAreClearlyOff) {
  EXPECT_TRUE(DoubtsFocal({.scale = 0.95, .sigma = 0.015}));
  EXPECT_FALSE(DoubtsFocal({.scale = 0.97, .sigma = 0.015}));
  EXPECT_FALSE(DoubtsFocal({.scale = 1.01, .sigma = 0.001}));
}

}  // namespace
}  // namespace treeline::localizer
