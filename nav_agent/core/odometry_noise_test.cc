#include "nav_agent/core/odometry_noise.h"

#include <limits>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::core {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(MeasuredOdometryNoise, IsFourNumbersOrNone) {
  const auto none = NoiseOfFile({});
  ASSERT_TRUE(none.ok()) << none.status();
  EXPECT_FALSE(none->has_value());
  const MeasuredOdometryNoise all = {0.01, 0.02, 0.03, 0.04};
  const auto four = NoiseOfFile(all);
  ASSERT_TRUE(four.ok()) << four.status();
  EXPECT_EQ(*four, all);
  const auto two =
      NoiseOfFile({.turn_from_turn = 0.01, .drive_from_turn = 0.02});
  EXPECT_EQ(two.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(two.status().message(),
              AllOf(HasSubstr("turn_from_drive, drive_from_drive are missing"),
                    HasSubstr("calibrate")));
}

TEST(MeasuredOdometryNoise, IsWithinWhatWheelsMayErr) {
  for (const double wrong :
       {-0.01, 1e-4, 1.5, 1e9, std::numeric_limits<double>::quiet_NaN()}) {
    MeasuredOdometryNoise noise = {0.01, 0.02, 0.03, 0.04};
    noise.turn_from_drive = wrong;
    EXPECT_THAT(NoiseOfFile(noise).status().message(),
                HasSubstr("turn_from_drive is"))
        << wrong;
  }
}

}  // namespace
}  // namespace treeline::core
