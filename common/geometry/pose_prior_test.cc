#include "common/geometry/pose_prior.h"

#include <limits>
#include <numbers>
#include <string>

#include "gtest/gtest.h"

namespace treeline::geometry {
namespace {

Rigid3 At(Vec3 position, Vec3 axis_angle_rad = {}) {
  return {Rotation3::FromAxisAngle(axis_angle_rad), position};
}

TEST(PosePriorTest, AllowsWhatIsWithinBothRadii) {
  const PosePrior prior{At({1, 2, 3}, {0, 0, 0.5}), 0.2, 0.1};
  EXPECT_TRUE(prior.Allows(At({1.19, 2, 3}, {0, 0, 0.59})));
  EXPECT_FALSE(prior.Allows(At({1.21, 2, 3}, {0, 0, 0.5})));
  EXPECT_FALSE(prior.Allows(At({1, 2, 3}, {0, 0, 0.61})));
}

TEST(PosePriorTest, APlaceAllowsEveryRotation) {
  const PositionPrior prior{{1, 2, 3}, 0.5};
  EXPECT_TRUE(prior.Allows(At({1, 2.4, 3.2}, {3, 0, 0})));
  EXPECT_FALSE(prior.Allows(At({1, 2.4, 3.4})));
}

TEST(PosePriorTest, HeightsAreAlongTheirOwnDirection) {
  EXPECT_TRUE((HeightBand{.min_m = 1, .max_m = 2}.Allows(At({9, 9, 1.5}))));
  EXPECT_FALSE((HeightBand{.min_m = 1, .max_m = 2}.Allows(At({9, 9, 2.5}))));
  // A world whose y axis points down; the vector's length is of no account.
  const HeightBand band{.up_in_world = {0, -3, 0}, .min_m = 1, .max_m = 2};
  EXPECT_TRUE(band.Allows(At({9, -1.5, 9})));
  EXPECT_FALSE(band.Allows(At({9, 1.5, 9})));
  EXPECT_FALSE(band.Allows(At({9, -2.5, 9})));
}

TEST(PosePriorTest, EachOfSeveralHasToAgree) {
  PosePriors priors;
  EXPECT_TRUE(priors.empty());
  EXPECT_TRUE(priors.Allows(At({100, 100, 100})));
  priors.position = PositionPrior{{0, 0, 0}, 2};
  priors.height = HeightBand{.min_m = 0, .max_m = 1};
  EXPECT_FALSE(priors.empty());
  EXPECT_TRUE(priors.Allows(At({1, 1, 0.5})));
  EXPECT_FALSE(priors.Allows(At({1, 1, 1.1})));
  EXPECT_FALSE(priors.Allows(At({2, 1, 0.5})));
  priors.pose = PosePrior{At({1, 1, 0.5}), 0.1, 0.1};
  EXPECT_FALSE(priors.Allows(At({0.5, 0.5, 0.5})));
}

TEST(PosePriorTest, WidenedAllowsWhatIsNearToIt) {
  PosePriors priors;
  priors.pose = PosePrior{At({}), 1, 0.5};
  priors.position = PositionPrior{{}, 1};
  priors.height = HeightBand{.min_m = -1, .max_m = 1};
  const PosePriors wide = priors.Widened(0.5, 0.2);
  EXPECT_TRUE(wide.Allows(At({0, 0, 1.4}, {0.6, 0, 0})));
  EXPECT_TRUE(wide.Allows(At({0, 0, -1.4}, {0.6, 0, 0})));
  EXPECT_FALSE(wide.Allows(At({0, 0, 1.6}, {0.6, 0, 0})));
  EXPECT_FALSE(wide.Allows(At({0, 0, 1.4}, {0.8, 0, 0})));
  EXPECT_EQ(priors.Widened(0, 9).pose->rotation_radius_rad, std::numbers::pi);
}

TEST(PosePriorTest, WhatIsNoBeliefNamesItsField) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const auto field = [](const auto& prior) {
    const std::string message(prior.Validate().message());
    return message.substr(0, message.find(':'));
  };
  EXPECT_TRUE((PosePrior{{}, 1, 1}.Validate().ok()));
  EXPECT_EQ(field(PosePrior{{}, 0, 1}), "position_radius_m");
  EXPECT_EQ(field(PosePrior{{}, 1, nan}), "rotation_radius_rad");
  EXPECT_TRUE((PositionPrior{{}, 1}.Validate().ok()));
  EXPECT_EQ(field(PositionPrior{{}, infinity}), "radius_m");
  EXPECT_EQ(field(PositionPrior{{nan, 0, 0}, 1}), "position_in_world_m");
  EXPECT_TRUE((HeightBand{.min_m = 0, .max_m = 1}.Validate().ok()));
  EXPECT_EQ(field(HeightBand{.min_m = 1, .max_m = 1}), "max_m");
  EXPECT_EQ(field(HeightBand{.min_m = -infinity, .max_m = 1}), "max_m");
  EXPECT_EQ(field(HeightBand{.up_in_world = {}, .min_m = 0, .max_m = 1}),
            "up_in_world");
}

}  // namespace
}  // namespace treeline::geometry
