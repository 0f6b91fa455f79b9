#include "nav_agent/calibration/noise_model.h"

#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "common/base/random.h"
#include "gtest/gtest.h"
#include "nav_agent/calibration/parameters.h"

namespace treeline::calibration {
namespace {

// 2000 motions: a standard deviation is good to 2 %, and two that share the
// data to some times that; steps are a fifth.
TEST(NoiseModel, FindsTheSharesThatErrorsWereDrawnFrom) {
  base::Random random(1, 1);
  std::vector<MotionError> errors;
  for (int i = 0; i < 2000; ++i) {
    MotionError error;
    error.way_m = random.NextUniform(0, 0.5);
    error.turn_rad = random.NextUniform(-0.35, 0.35);
    if (i % 3 == 0) error.turn_rad = 0;
    if (i % 3 == 1) error.way_m = 0;
    const double turn_rad = std::abs(error.turn_rad);
    error.yaw_rad =
        (0.08 * turn_rad + 0.03 * error.way_m) * random.NextGaussian();
    error.along_m =
        (0.05 * error.way_m + 0.02 * turn_rad) * random.NextGaussian();
    errors.push_back(error);
  }
  const auto noise = FitNoise(errors);
  ASSERT_TRUE(noise.has_value());
  EXPECT_NEAR(noise->noise.turn_from_turn, 0.08, 0.25 * 0.08);
  EXPECT_NEAR(noise->noise.turn_from_drive, 0.03, 0.25 * 0.03);
  EXPECT_NEAR(noise->noise.drive_from_drive, 0.05, 0.25 * 0.05);
  EXPECT_NEAR(noise->noise.drive_from_turn, 0.02, 0.25 * 0.02);
  // Errors are independent here: what is stated is what they scatter, which is
  // a few per cent of each, and never nothing.
  for (const auto& [name, value] : core::kNoiseKeys) {
    EXPECT_GT(noise->sigma.*value, 0.005 * noise->noise.*value) << name;
    EXPECT_LT(noise->sigma.*value, 0.3 * noise->noise.*value) << name;
  }
  // They fit what they were drawn from, and twice that is twice as much.
  const NoiseExcess fits = ExcessOver(noise->noise, errors);
  EXPECT_NEAR(fits.yaw, 1, 0.05);
  EXPECT_NEAR(fits.along, 1, 0.05);
  for (MotionError& error : errors) error.along_m *= 2;
  EXPECT_NEAR(ExcessOver(noise->noise, errors).along, 2, 0.1);
  EXPECT_NEAR(ExcessOver(noise->noise, errors).yaw, 1, 0.05);
  EXPECT_EQ(ExcessOver(noise->noise, {}).yaw, 0);
}

TEST(CalibrationParameters, HaveANameOfTheirOwnAndSayWhy) {
  std::set<std::string> seen;
  for (const base::ParameterRow& row : CalibrationParameters()) {
    EXPECT_TRUE(seen.insert(std::string(row.name)).second) << row.name;
    EXPECT_FALSE(row.why.empty()) << row.name;
  }
  EXPECT_GT(seen.size(), 40u);
}

TEST(NoiseModel, NeedsTurnsAndStraightMotions) {
  const std::vector<MotionError> straight(
      50, {.way_m = 0.5, .turn_rad = 0, .along_m = 0.01, .yaw_rad = 0.01});
  EXPECT_FALSE(FitNoise(straight).has_value());
  EXPECT_FALSE(FitNoise({}).has_value());
}

}  // namespace
}  // namespace treeline::calibration
