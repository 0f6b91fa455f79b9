#include "nav_agent/mapping/odometry_doubt.h"

#include <cstdint>

#include "common/base/random.h"
#include "gtest/gtest.h"

namespace treeline::mapping {
namespace {

constexpr geometry::Rigid2 kStep = {{0.3, 0}, 0.1};

// Innovations of a robot whose odometry is `times` as wrong as assumed.
void Teach(double times, int count, OdometryDoubt* doubt) {
  const OdometryNoise noise;
  const double sigma_m = noise.m + 0.3 * noise.m_per_m + 0.1 * noise.m_per_rad;
  const double sigma_rad =
      noise.rad + 0.1 * noise.rad_per_rad + 0.3 * noise.rad_per_m;
  for (int i = 0; i < count; ++i) {
    base::Random random(3, static_cast<uint64_t>(i));
    doubt->Learn(kStep, {{times * sigma_m * random.NextGaussian(), 0},
                         times * sigma_rad * random.NextGaussian()});
  }
}

TEST(OdometryDoubt, BeginsDoubtfulAndLearnsToTrust) {
  OdometryDoubt doubt({}, 3);
  const OdometryDoubt::Sigma before = doubt.SearchOf(kStep);
  EXPECT_NEAR(doubt.scale_rad(), 3, 0.5);
  Teach(0.5, 200, &doubt);
  EXPECT_EQ(doubt.scale_m(), 1);
  EXPECT_EQ(doubt.scale_rad(), 1);
  EXPECT_LT(doubt.SearchOf(kStep).rad, before.rad / 2);
}

// 100 Gaussian samples tell their deviation to 7 %; the quantile, to 12.
TEST(OdometryDoubt, LearnsHowWrongOdometryIs) {
  OdometryDoubt doubt({}, 3);
  Teach(5, 200, &doubt);
  EXPECT_NEAR(doubt.scale_m(), 5, 1.5);
  EXPECT_NEAR(doubt.scale_rad(), 5, 1.5);
  // Three standard deviations are searched at least.
  EXPECT_GE(doubt.SearchOf(kStep).rad, 3 * doubt.SigmaOf(kStep).rad);
}

TEST(OdometryDoubt, BearsSingleSlips) {
  OdometryDoubt doubt({}, 3);
  Teach(0.5, 200, &doubt);
  for (int i = 0; i < 3; ++i) doubt.Learn(kStep, {{1, 0}, 1});
  EXPECT_EQ(doubt.scale_m(), 1);
  EXPECT_EQ(doubt.scale_rad(), 1);
}

TEST(OdometryDoubt, StaysAsGivenIfItIsFixed) {
  const OdometryNoise noise = OdometryNoise::WithGyroscope();
  OdometryDoubt doubt(noise, 3);
  Teach(50, 200, &doubt);
  EXPECT_EQ(doubt.scale_m(), 1);
  EXPECT_NEAR(doubt.SigmaOf({{1, 0}, 0}).m, noise.m + noise.m_per_m, 1e-12);
  EXPECT_NEAR(doubt.SearchOf({}).m, noise.min_search_m, 1e-12);
}

TEST(OdometryDoubt, ARobotThatWasMeasuredToSlipIsBelievedLess) {
  const OdometryNoise usual = OdometryNoise::WithGyroscope();
  const OdometryNoise slips =
      OdometryNoise::AtLeast(usual, {.turn_from_turn = 0.1,
                                     .turn_from_drive = 0.001,
                                     .drive_from_drive = 0.05,
                                     .drive_from_turn = 0.001});
  EXPECT_DOUBLE_EQ(slips.rad_per_rad, 0.2);
  EXPECT_DOUBLE_EQ(slips.m_per_m, 0.1);
  // No robot is believed more than usual.
  EXPECT_DOUBLE_EQ(slips.rad_per_m, usual.rad_per_m);
  EXPECT_DOUBLE_EQ(slips.m_per_rad, usual.m_per_rad);
  EXPECT_FALSE(slips.is_estimated);
}

}  // namespace
}  // namespace treeline::mapping
