#include "common/image/orientation.h"

#include <cmath>
#include <numbers>

#include "gtest/gtest.h"

namespace treeline::image {
namespace {

// Gravity of a camera that is rolled clockwise as seen from behind it, and then
// looks up by `pitch_deg`.
geometry::Vec3 Gravity(double roll_deg, double pitch_deg) {
  const double roll = roll_deg * std::numbers::pi / 180;
  const double pitch = pitch_deg * std::numbers::pi / 180;
  return {9.81 * std::cos(pitch) * std::sin(roll),
          9.81 * std::cos(pitch) * std::cos(roll), -9.81 * std::sin(pitch)};
}

TEST(OrientationTest, TheRestOfATurnIsWhatItLacks) {
  EXPECT_EQ(Remaining(QuarterTurn::kHalf, QuarterTurn::kNone),
            QuarterTurn::kHalf);
  EXPECT_EQ(Remaining(QuarterTurn::kClockwise, QuarterTurn::kHalf),
            QuarterTurn::kCounterclockwise);
  EXPECT_EQ(Inverse(QuarterTurn::kClockwise), QuarterTurn::kCounterclockwise);
  EXPECT_EQ(Inverse(QuarterTurn::kHalf), QuarterTurn::kHalf);
}

TEST(OrientationTest, ThingsFallAwayFromTheSideThatIsUp) {
  EXPECT_EQ(OrientationFromGravity({0, 9.81, 0}),
            (Orientation{QuarterTurn::kNone, true}));
  // To the right of the picture: its left side is up.
  EXPECT_EQ(OrientationFromGravity({1, 0, 0}),
            (Orientation{QuarterTurn::kClockwise, true}));
  EXPECT_EQ(OrientationFromGravity({0, -1, 0}),
            (Orientation{QuarterTurn::kHalf, true}));
  EXPECT_EQ(OrientationFromGravity({-1e-6, 0, 0}),
            (Orientation{QuarterTurn::kCounterclockwise, true}));
}

TEST(OrientationTest, IsAGuessHalfWayBetweenTwoSides) {
  for (const double pitch_deg : {-60.0, 0.0, 60.0}) {
    EXPECT_EQ(OrientationFromGravity(Gravity(29, pitch_deg)),
              (Orientation{QuarterTurn::kNone, true}));
    EXPECT_EQ(OrientationFromGravity(Gravity(31, pitch_deg)),
              (Orientation{QuarterTurn::kNone, false}));
    EXPECT_EQ(OrientationFromGravity(Gravity(59, pitch_deg)),
              (Orientation{QuarterTurn::kClockwise, false}));
    EXPECT_EQ(OrientationFromGravity(Gravity(61, pitch_deg)),
              (Orientation{QuarterTurn::kClockwise, true}));
  }
}

TEST(OrientationTest, KnowsNothingOfACameraThatLooksUpOrDown) {
  for (const double pitch_deg : {-71.0, 71.0, 90.0}) {
    EXPECT_EQ(OrientationFromGravity(Gravity(180, pitch_deg)), std::nullopt);
  }
  EXPECT_EQ(OrientationFromGravity(Gravity(180, 69)),
            (Orientation{QuarterTurn::kHalf, true}));
}

}  // namespace
}  // namespace treeline::image
