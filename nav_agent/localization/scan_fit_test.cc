#include "nav_agent/localization/scan_fit.h"

#include <array>
#include <cmath>
#include <optional>

#include "gtest/gtest.h"

namespace treeline::localization {
namespace {

constexpr std::array<FitStep, 2> kPasses = {
    {{.m = 0.1, .rad = 0.04}, {.m = 0.05, .rad = 0.02}}};

// A scan that fits best at one pose, and less with the distance from it.
struct Peak {
  geometry::Rigid2 at;
  std::optional<ScanFit> operator()(const core::LevelPose& pose) const {
    const double off =
        geometry::Norm(pose.map_from_base.translation - at.translation) +
        std::abs(geometry::NormalizedAngle_rad(pose.map_from_base.yaw_rad -
                                               at.yaw_rad));
    return ScanFit{.explained = 1 - off, .contradicted = 0, .judged = 100};
  }
};

double ScoreOnly(const core::LevelPose&, const ScanFit& fit) {
  return FitScore(fit);
}

TEST(RefineFit, FindsAPeakOnItsGrid) {
  const Peak peak = {.at = {{0.15, -0.05}, 0.06}};
  const FittedPose best = RefineFit({.pose = {}, .fit = {}, .score = -2},
                                    kPasses, 0, peak, ScoreOnly);
  EXPECT_NEAR(best.pose.map_from_base.translation.x, 0.15, 1e-9);
  EXPECT_NEAR(best.pose.map_from_base.translation.y, -0.05, 1e-9);
  EXPECT_NEAR(best.pose.map_from_base.yaw_rad, 0.06, 1e-9);
  EXPECT_NEAR(best.score, 1, 1e-9);
}

TEST(RefineFit, StaysWithinTheSumOfItsSteps) {
  const Peak peak = {.at = {{5, 0}, 0}};
  const FittedPose best = RefineFit({.pose = {}, .fit = {}, .score = -10},
                                    kPasses, 0, peak, ScoreOnly);
  EXPECT_NEAR(best.pose.map_from_base.translation.x, 0.15, 1e-9);
}

TEST(RefineFit, WhereItIsFlatItStays) {
  const auto flat = [](const core::LevelPose&) {
    return std::optional<ScanFit>(
        {.explained = 0.5, .contradicted = 0, .judged = 100});
  };
  const FittedPose start = {.pose = {.map_from_base = {{1, 2}, 3}, .place = {}},
                            .fit = {},
                            .score = 0.5};
  EXPECT_EQ(RefineFit(start, kPasses, 0, flat, ScoreOnly).pose, start.pose);
}

TEST(RefineFit, WhatIsChargedForDecidesToo) {
  const Peak peak = {.at = {{0.1, 0}, 0}};
  const FittedPose start = {
      .pose = {}, .fit = *peak({}), .score = FitScore(*peak({}))};
  const auto too_dear = [](const core::LevelPose& pose, const ScanFit& fit) {
    return FitScore(fit) - 2 * geometry::Norm(pose.map_from_base.translation);
  };
  EXPECT_EQ(RefineFit(start, kPasses, 1e-9, peak, too_dear).pose, start.pose);
}

TEST(RefineFit, WithoutAScanNothingIsTried) {
  const auto none = [](const core::LevelPose&) -> std::optional<ScanFit> {
    return std::nullopt;
  };
  const FittedPose start = {.pose = {}, .fit = {}, .score = -2};
  EXPECT_EQ(RefineFit(start, kPasses, 0, none, ScoreOnly).score, -2);
}

}  // namespace
}  // namespace treeline::localization
