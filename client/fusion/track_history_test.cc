#include "client/fusion/track_history.h"

#include <numbers>

#include "gtest/gtest.h"

namespace treeline::drift {
namespace {

using std::chrono::milliseconds;

geometry::Rigid3 At(double x, double yaw_rad = 0) {
  return {geometry::Rotation3::FromAxisAngle({0, 0, yaw_rad}), {x, 0, 0}};
}

TEST(TrackHistoryTest, BetweenTwoPosesIsTheLineAndTheShorterArc) {
  const DriftOptions options;
  TrackHistory history(options);
  history.Add(milliseconds(0), At(0, 3));
  history.Add(milliseconds(200), At(0.4, -3));
  const std::optional<TrackedPose> between = history.At(milliseconds(50));
  ASSERT_TRUE(between.has_value());
  // From 3 rad on over pi: a quarter of the 0.28 rad.
  const double arc_rad = 2 * std::numbers::pi - 6;
  const geometry::PoseError error =
      ErrorBetween(between->device_from_camera, At(0.1, 3 + arc_rad / 4));
  EXPECT_NEAR(error.translation_m, 0, 1e-12);
  EXPECT_NEAR(error.rotation_rad, 0, 1e-12);
  EXPECT_NEAR(between->moved_m, 0.1, 1e-12);
  EXPECT_NEAR(between->turned_rad, arc_rad / 4, 1e-12);
}

TEST(TrackHistoryTest, KnowsNothingOutsideOfItsTime) {
  const DriftOptions options{.history_s = 1};
  TrackHistory history(options);
  EXPECT_FALSE(history.At(milliseconds(0)).has_value());
  for (int i = 0; i <= 20; ++i) history.Add(milliseconds(100 * i), At(0));
  EXPECT_EQ(history.oldest()->time, milliseconds(1000));
  EXPECT_FALSE(history.At(milliseconds(999)).has_value());
  EXPECT_TRUE(history.At(milliseconds(1000)).has_value());
  EXPECT_TRUE(history.At(milliseconds(2000)).has_value());
  EXPECT_FALSE(history.At(milliseconds(2001)).has_value());
}

TEST(TrackHistoryTest, AGapALeapAndASpinAreNoContinuation) {
  const DriftOptions options;
  TrackHistory history(options);
  EXPECT_FALSE(history.IsBroken(milliseconds(0), At(100)));
  history.Add(milliseconds(0), At(0));
  EXPECT_FALSE(history.IsBroken(milliseconds(100), At(0.9)));
  EXPECT_TRUE(history.IsBroken(milliseconds(100), At(1.1)));
  EXPECT_FALSE(history.IsBroken(milliseconds(100), At(0, 1.2)));
  EXPECT_TRUE(history.IsBroken(milliseconds(100), At(0, 1.3)));
  EXPECT_FALSE(history.IsBroken(milliseconds(1000), At(0)));
  EXPECT_TRUE(history.IsBroken(milliseconds(1001), At(0)));
}

TEST(TrackHistoryTest, DriftGrowsWithTheWayAndTheTime) {
  const DriftOptions options{.drift_m_per_sqrt_m = 0.2,
                             .drift_m_per_sqrt_s = 0.1,
                             .drift_deg_per_sqrt_m = 1,
                             .drift_deg_per_sqrt_rad = 2,
                             .drift_deg_per_sqrt_s = 3};
  TrackHistory history(options);
  const TrackedPose from{.time = milliseconds(0)};
  const TrackedPose to{
      .time = milliseconds(2000), .moved_m = 3, .turned_rad = 0.5};
  const geometry::PoseCovariance drift = history.Drift(from, to);
  EXPECT_NEAR(drift[0], 0.04 * 3 + 0.01 * 2, 1e-12);
  const double deg = std::numbers::pi / 180;
  EXPECT_NEAR(drift[35], deg * deg * (1 * 3 + 4 * 0.5 + 9 * 2), 1e-12);
}

}  // namespace
}  // namespace treeline::drift
