#include "server/core/keyframes/depth_lookup.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/base/random.h"
#include "gtest/gtest.h"
#include "server/core/features/rgbd_samples.h"

namespace treeline::keyframes {
namespace {

// What MeasureDepth says of a point in the colour camera, in double precision.
struct Expected {
  geometry::Vec3 point;
  double sigma_m = 0;
  double from_edge_px = 0;  // of where the value changes
};

Expected Look(const camera::RgbdCalibration& calibration,
              const image::DepthImage& depth, geometry::Vec3 p) {
  Expected expected;
  const geometry::Vec3 q = calibration.color_from_depth.Inverse() * p;
  const camera::Pixel pixel = calibration.depth.Project(q);
  const auto from_half = [](double at) {
    return std::abs(at + 0.5 - std::round(at + 0.5));
  };
  expected.from_edge_px =
      std::min({from_half(pixel.x), from_half(pixel.y), std::abs(pixel.x),
                std::abs(pixel.y), std::abs(pixel.x - (depth.width - 1)),
                std::abs(pixel.y - (depth.height - 1))});
  if (!(pixel.x > 0 && pixel.y > 0 && pixel.x < depth.width - 1 &&
        pixel.y < depth.height - 1)) {
    return expected;
  }
  const int x = static_cast<int>(pixel.x + 0.5);
  const int y = static_cast<int>(pixel.y + 0.5);
  const uint16_t value = depth.values[static_cast<size_t>(y * depth.width + x)];
  if (!image::IsMeasured(value)) return expected;
  const double z = calibration.depth_scale * depth.unit_m * value;
  expected.point =
      calibration.color_from_depth *
      (z * geometry::Vec3{q.x / q.z + (x - pixel.x) / calibration.depth.fx(),
                          q.y / q.z + (y - pixel.y) / calibration.depth.fy(),
                          1});
  expected.sigma_m = features::DepthSigma_m(z);
  return expected;
}

camera::RgbdCalibration WithDepthCamera(const char* lens) {
  camera::RgbdCalibration calibration;
  calibration.depth = *camera::Camera::Parse(lens, 60, 40);
  calibration.color_from_depth = {
      geometry::Rotation3::FromAxisAngle({0.01, 0.02, -0.01}),
      {0.03, -0.01, 0.005}};
  calibration.depth_scale = 1.02;
  return calibration;
}

TEST(DepthLookupTest, DepthIsLookedUpThroughItsLens) {
  base::Random random(6, 0);
  image::DepthImage depth{.width = 60, .height = 40, .values = {}};
  for (int i = 0; i < 60 * 40; ++i) {
    const uint32_t kind = random.NextBelow(8);
    depth.values.push_back(
        static_cast<uint16_t>(kind == 0   ? 0
                              : kind == 1 ? 65535
                                          : 500 + random.NextBelow(4000)));
  }
  constexpr size_t kPoints = 4096;
  VisiblePoints seen;
  seen.resize(kPoints);
  for (size_t i = 0; i < kPoints; ++i) {
    const auto uniform = [&](float size) {
      return size * (static_cast<float>(random.NextBelow(2001)) / 1000 - 1);
    };
    seen.z[i] = 2 + uniform(1);
    seen.x[i] = 0.6F * seen.z[i] * uniform(1);
    seen.y[i] = 0.45F * seen.z[i] * uniform(1);
    seen.seen[i] = i % 7 == 0 ? 0 : 1;
  }
  for (const char* lens :
       {"PINHOLE,55,56,29,20", "SIMPLE_RADIAL,55,29,20,-0.1",
        "RADIAL,55,29,20,-0.1,0.02",
        "OPENCV,55,56,29,20,-0.1,0.02,0.001,-0.002",
        "FULL_OPENCV,55,56,29,20,0.1,0.02,0.001,-0.002,0.01,0.2,0.03,0.01"}) {
    SCOPED_TRACE(lens);
    const camera::RgbdCalibration calibration = WithDepthCamera(lens);
    const auto view = DepthViewOf(calibration, depth);
    ASSERT_TRUE(view.has_value());
    MeasuredPoints measured;
    measured.resize(kPoints);
    MeasureDepth(seen, 0, kPoints, *view, measured);
    int found = 0;
    for (size_t i = 0; i < kPoints; ++i) {
      if (seen.seen[i] == 0) {
        EXPECT_EQ(measured.sigma_m[i], 0);
        continue;
      }
      const Expected expected =
          Look(calibration, depth, {seen.x[i], seen.y[i], seen.z[i]});
      // Single precision may take the other pixel there.
      if (expected.from_edge_px < 1e-4) continue;
      ASSERT_NEAR(measured.sigma_m[i], expected.sigma_m, 1e-6) << i;
      if (expected.sigma_m == 0) continue;
      ++found;
      EXPECT_NEAR(measured.x[i], expected.point.x, 1e-5);
      EXPECT_NEAR(measured.y[i], expected.point.y, 1e-5);
      EXPECT_NEAR(measured.z[i], expected.point.z, 1e-5);
    }
    EXPECT_GT(found, 1000);
  }
}

TEST(DepthLookupTest, TheLastDepthPixelIsReadFromInsideTheImage) {
  // Three values, of which points see the last; a sanitizer knows the end.
  camera::RgbdCalibration calibration;
  calibration.depth = *camera::Camera::Parse("PINHOLE,2,2,1,0.5", 3, 2);
  const image::DepthImage depth{
      .width = 3, .height = 2, .values = {1, 2, 3, 4, 5, 2000}};
  VisiblePoints seen;
  seen.resize(kAlignmentBlock);
  seen.x[0] = 0.45F;  // pixel 1.9
  seen.y[0] = 0.2F;   // pixel 0.9
  seen.z[0] = 1;
  seen.seen[0] = 1;
  MeasuredPoints measured;
  measured.resize(kAlignmentBlock);
  MeasureDepth(seen, 0, kAlignmentBlock, *DepthViewOf(calibration, depth),
               measured);
  EXPECT_NEAR(measured.z[0], 2, 1e-6);
  EXPECT_GT(measured.sigma_m[0], 0);
  EXPECT_EQ(measured.sigma_m[1], 0);
}

TEST(DepthLookupTest, OtherLensesAreLookedThroughPointByPoint) {
  const image::DepthImage depth{
      .width = 60, .height = 40, .values = std::vector<uint16_t>(60 * 40, 1)};
  EXPECT_FALSE(
      DepthViewOf(WithDepthCamera("OPENCV_FISHEYE,55,56,29,20,0.1,0,0,0"),
                  depth)
          .has_value());
  EXPECT_FALSE(
      DepthViewOf(WithDepthCamera("FOV,55,56,29,20,0.5"), depth).has_value());
}

}  // namespace
}  // namespace treeline::keyframes
