// A device whose camera moves along x, and fixes of it; for tests.
#ifndef CLIENT_FUSION_TESTING_DEVICE_H_
#define CLIENT_FUSION_TESTING_DEVICE_H_

#include <chrono>
#include <utility>

#include "client/fusion/drift_corrector.h"
#include "client/fusion/gaussian_pose.h"
#include "client/fusion/radians.h"
#include "gtest/gtest.h"

namespace treeline::drift {

inline geometry::Rigid3 At(double x, double yaw_deg = 0) {
  return {geometry::Rotation3::FromAxisAngle({0, 0, Radians(yaw_deg)}),
          {x, 0, 0}};
}

class TestingDevice {
 public:
  // The truth: the world is the device's frame, moved by 10 m.
  static geometry::Rigid3 World() { return At(10); }

  explicit TestingDevice(const DriftOptions& options = {})
      : corrector(DriftCorrector::Create(options).value()) {
    EXPECT_TRUE(corrector.Track(time, At(0)).ok());
  }

  DriftEstimate Step(double metres = 0.1) {
    time += std::chrono::milliseconds(100);
    x_m += metres;
    return corrector.Track(time, At(x_m)).value();
  }

  DriftEstimate Walk(int steps, double metres = 0.1) {
    for (int i = 1; i < steps; ++i) Step(metres);
    return Step(metres);
  }

  // What a server would say of the camera now, if the world were `world`.
  Fix FixOf(const geometry::Rigid3& world) const {
    return {.capture_time = time,
            .world_from_camera = world * At(x_m),
            .covariance = Diagonal(0.01 * 0.01, Radians(0.3) * Radians(0.3)),
            .confidence = 0.97};
  }

  FixVerdict Add(const geometry::Rigid3& world = World(),
                 double confidence = 0.97) {
    Fix fix = FixOf(world);
    fix.confidence = confidence;
    return corrector.AddFix(fix).value();
  }

  DriftEstimate Lock() {
    EXPECT_EQ(Add(), FixVerdict::kHeld);
    Step();
    EXPECT_EQ(Add(), FixVerdict::kLocked);
    return Step();
  }

  DriftCorrector corrector;
  std::chrono::nanoseconds time{0};
  double x_m = 0;
};

}  // namespace treeline::drift

#endif  // CLIENT_FUSION_TESTING_DEVICE_H_
