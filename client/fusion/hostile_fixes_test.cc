// What no honest server or tracker sends.
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "client/fusion/drift_corrector.h"
#include "client/fusion/testing_device.h"
#include "gtest/gtest.h"

namespace treeline::drift {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool IsInvalid(const absl::Status& status) {
  return status.code() == absl::StatusCode::kInvalidArgument;
}

// A locked device, which goes on as if nothing had been.
void ExpectUnharmed(TestingDevice& device) {
  const DriftEstimate estimate = device.Step();
  EXPECT_EQ(estimate.state, DriftState::kLocked);
  EXPECT_FALSE(estimate.tracking_broke);
  EXPECT_NEAR(estimate.world_from_device->translation.x, 10, 1e-9);
  EXPECT_EQ(device.Add(), FixVerdict::kApplied);
}

TEST(HostileFixesTest, WhatIsNoFixIsRefusedAndChangesNothing) {
  const std::vector<std::function<void(Fix&)>> spoils = {
      [](Fix& fix) { fix.world_from_camera.translation.x = kNan; },
      [](Fix& fix) { fix.world_from_camera.translation.z = kInfinity; },
      [](Fix& fix) { fix.world_from_camera.rotation.w = kNan; },
      [](Fix& fix) {
        fix.world_from_camera.rotation = {0, 0, 0, 0};
      },
      [](Fix& fix) {
        fix.world_from_camera.rotation = {2, 0, 0, 0};
      },
      [](Fix& fix) { fix.covariance[35] = kNan; },
      [](Fix& fix) { fix.covariance[0] = kInfinity; },
      [](Fix& fix) { fix.covariance[0] = -1; },
      [](Fix& fix) { fix.covariance[1] = 1e-5; },
      [](Fix& fix) { fix.covariance[1] = fix.covariance[6] = 1; },
      [](Fix& fix) { fix.confidence = kNan; },
      [](Fix& fix) { fix.confidence = 1.1; },
      [](Fix& fix) { fix.confidence = -0.1; },
      [](Fix& fix) { fix.capture_time = nanoseconds::max(); },
      [](Fix& fix) { fix.capture_time = nanoseconds::min(); },
  };
  TestingDevice device;
  device.Lock();
  for (size_t i = 0; i < spoils.size(); ++i) {
    Fix fix = device.FixOf(TestingDevice::World());
    spoils[i](fix);
    EXPECT_TRUE(IsInvalid(device.corrector.AddFix(fix).status())) << i;
  }
  ExpectUnharmed(device);
}

TEST(HostileFixesTest, WhatIsNoTrackingIsRefusedAndChangesNothing) {
  TestingDevice device;
  device.Lock();
  const auto track = [&device](nanoseconds time, const geometry::Rigid3& pose) {
    return device.corrector.Track(time, pose).status();
  };
  const geometry::Rigid3 here = At(device.x_m);
  const nanoseconds next = device.time + milliseconds(50);
  EXPECT_TRUE(IsInvalid(track(device.time, here)));
  EXPECT_TRUE(IsInvalid(track(device.time - milliseconds(1), here)));
  EXPECT_TRUE(IsInvalid(track(nanoseconds::min(), here)));
  EXPECT_TRUE(IsInvalid(track(nanoseconds::max(), here)));
  EXPECT_TRUE(IsInvalid(track(next, At(kNan))));
  EXPECT_TRUE(IsInvalid(track(next, At(kInfinity))));
  EXPECT_TRUE(IsInvalid(track(next, {{kNan, 0, 0, 0}, {}})));
  EXPECT_TRUE(IsInvalid(track(next, {{0, 0, 0, 0}, {}})));
  ExpectUnharmed(device);
}

TEST(HostileFixesTest, ZeroCovarianceIsNoCertainty) {
  TestingDevice device;
  device.Lock();
  Fix sure = device.FixOf(At(10.1));
  sure.covariance = Diagonal(0, 0);
  sure.confidence = 1;
  EXPECT_EQ(device.corrector.AddFix(sure).value(), FixVerdict::kApplied);
  // Two fixes of a centimetre speak against it.
  const DriftEstimate estimate = device.Walk(50);
  EXPECT_LT(estimate.world_from_device->translation.x, 10.07);
  EXPECT_GT(*estimate.position_sigma_m, 0);
}

TEST(HostileFixesTest, OnePictureCountsOnce) {
  TestingDevice device;
  EXPECT_EQ(device.Add(At(20)), FixVerdict::kHeld);
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(device.Add(At(20)), FixVerdict::kIgnoredRepeated);
  }
  EXPECT_EQ(device.Step().state, DriftState::kTentative);
  device.Lock();
  EXPECT_EQ(device.Add(), FixVerdict::kApplied);
  const DriftEstimate before = device.Step(0);
  Fix again = device.FixOf(TestingDevice::World());
  again.capture_time -= milliseconds(100);
  EXPECT_EQ(device.corrector.AddFix(again).value(),
            FixVerdict::kIgnoredRepeated);
  EXPECT_GE(*device.Step(0).position_sigma_m, *before.position_sigma_m);
  // What was ignored has not counted.
  EXPECT_EQ(device.Add(TestingDevice::World(), 0.1),
            FixVerdict::kIgnoredConfidence);
  EXPECT_EQ(device.Add(), FixVerdict::kApplied);
}

TEST(HostileFixesTest, PosesFarOutsideOfTheWorldStayFinite) {
  TestingDevice device;
  device.Lock();
  for (const double x : {1e100, -1e200, 1e307}) {
    EXPECT_EQ(device.Add(At(x)), FixVerdict::kHeld);
    device.Step();
  }
  ExpectUnharmed(device);
  // A leap there is none of this device.
  const absl::StatusOr<DriftEstimate> far =
      device.corrector.Track(device.time + milliseconds(100), At(1e300));
  ASSERT_TRUE(far.ok());
  EXPECT_TRUE(far->tracking_broke);
  EXPECT_EQ(far->state, DriftState::kSearching);
}

TEST(HostileFixesTest, TenThousandFixesStayFiniteAndSymmetric) {
  TestingDevice device;
  device.Lock();
  for (int i = 0; i < 10000; ++i) {
    // To and fro, so that each view is seen often.
    device.Step(i / 50 % 2 == 0 ? 0.02 : -0.02);
    // A millimetre and 0.1 degrees to either side.
    const double sign = i % 2 == 0 ? 1 : -1;
    ASSERT_EQ(device.Add(At(10 + 0.001 * sign, 0.1 * sign)),
              FixVerdict::kApplied)
        << i;
  }
  const DriftEstimate estimate = device.Step();
  EXPECT_EQ(estimate.state, DriftState::kLocked);
  EXPECT_NEAR(estimate.world_from_device->translation.x, 10, 0.005);
  EXPECT_GT(*estimate.position_sigma_m, 1e-4);
  EXPECT_LT(*estimate.position_sigma_m, 0.02);
}

TEST(HostileFixesTest, TenThousandFixesBetweenTwoFramesAreBounded) {
  TestingDevice device;
  device.Step();
  const Fix fix = device.FixOf(TestingDevice::World());
  for (int i = 0; i < 10000; ++i) {
    Fix other = fix;
    other.capture_time -= nanoseconds(10000 * i);
    // Each contradicts all others.
    other.world_from_camera.translation.y = 10.0 * i;
    ASSERT_EQ(device.corrector.AddFix(other).value(), FixVerdict::kHeld);
  }
  EXPECT_EQ(device.Step().state, DriftState::kTentative);
}

}  // namespace
}  // namespace treeline::drift
