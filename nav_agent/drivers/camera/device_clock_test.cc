#include "nav_agent/drivers/camera/device_clock.h"

#include <chrono>

#include "gtest/gtest.h"

namespace treeline::camera_driver {
namespace {

using std::chrono::milliseconds;

const base::MonotonicTime kStart{std::chrono::hours(3)};

TEST(DeviceClock, FollowsTheQuickestArrivals) {
  DeviceClock clock;
  for (int i = 0; i < 1000; ++i) {
    const milliseconds device(33 * i);
    // From 5 to 15 ms late.
    const base::MonotonicTime stamp =
        clock.StampOf(device, kStart + device + milliseconds(5 + (i * 7) % 11));
    if (i < 11) continue;  // in which each lateness has come once
    EXPECT_EQ(stamp, kStart + device + milliseconds(5));
  }
}

TEST(DeviceClock, FollowsADeviceThatRunsSlow) {
  DeviceClock clock;
  for (int i = 0; i < 3000; ++i) {
    // 300 ppm, far more than a quartz has.
    const std::chrono::microseconds true_time(33340 * i);
    const base::MonotonicTime stamp =
        clock.StampOf(std::chrono::microseconds(33330 * i), kStart + true_time);
    EXPECT_LE(stamp, kStart + true_time);
    // Twenty seconds of it.
    EXPECT_GE(stamp, kStart + true_time - std::chrono::microseconds(6100));
  }
}

TEST(DeviceClock, BeginsAnewWhenTheDeviceDoes) {
  DeviceClock clock;
  clock.StampOf(std::chrono::hours(5), kStart);
  EXPECT_EQ(clock.StampOf(milliseconds(3), kStart + milliseconds(40)),
            kStart + milliseconds(40));
}

}  // namespace
}  // namespace treeline::camera_driver
