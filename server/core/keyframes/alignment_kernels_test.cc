#include "server/core/keyframes/alignment_kernels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "common/base/random.h"
#include "gtest/gtest.h"
#include "server/core/features/rgbd_samples.h"

namespace treeline::keyframes {
namespace {

camera::Camera TestCamera() {
  return *camera::Camera::Parse("PINHOLE,200,210,79.5,59.5", 160, 120);
}

features::GrayPyramid NoisePyramid() {
  image::ColorImage image{160, 120, std::vector<uint8_t>(3 * 160 * 120)};
  base::Random random(2, 0);
  for (uint8_t& v : image.rgb) v = static_cast<uint8_t>(random.NextBelow(256));
  features::GrayPyramid pyramid;
  pyramid.Assign(features::PlanarImage(image));
  return pyramid;
}

// Points in front of the camera, a few of which it does not see, and one that
// faces away.
AlignmentPoints RandomPoints(geometry::Vec3 origin) {
  AlignmentPoints points;
  base::Random random(3, 0);
  const auto uniform = [&] {
    return static_cast<float>(random.NextBelow(2001)) / 1000 - 1;
  };
  for (int i = 0; i < 37; ++i) {
    points.Append({10 + uniform(), uniform(), 2 + 0.5F * uniform()},
                  {0, 0, static_cast<int8_t>(i == 5 ? 127 : -127)}, origin);
    for (std::vector<float>& level : points.gray) level.push_back(100);
  }
  points.Pad();
  return points;
}

geometry::Rigid3 CameraFromWorld() {
  return geometry::Rigid3{
      geometry::Rotation3::FromAxisAngle({0.02, -0.03, 0.05}), {10, 0, 0}}
      .Inverse();
}

TEST(AlignmentKernelsTest, PointsAreSeenAsTheCameraAndThePyramidSay) {
  const geometry::Vec3 origin{9, 1, 0};
  const AlignmentPoints points = RandomPoints(origin);
  const camera::Camera camera = TestCamera();
  const features::GrayPyramid pyramid = NoisePyramid();
  const PinholeView view = ViewOf(CameraFromWorld(), camera, origin);
  ASSERT_EQ(points.size() % kAlignmentBlock, 0u);
  for (const int l : {0, 1, 2}) {
    VisiblePoints seen;
    seen.resize(points.size());
    ProjectPoints(points, 0, points.size(), view, seen);
    const int counted = SampleBrightness(pyramid, l, 0, points.size(), seen);
    const features::GrayPyramid::Level& level = pyramid.level(l);
    int visible = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      const geometry::Vec3 world =
          origin + geometry::Vec3{points.x[i], points.y[i], points.z[i]};
      const geometry::Vec3 p = CameraFromWorld() * world;
      const camera::Pixel pixel = camera.Project(p);
      const float x = features::AtLevel(static_cast<float>(pixel.x), l);
      const float y = features::AtLevel(static_cast<float>(pixel.y), l);
      const bool inside = x > 1.5F && y > 1.5F &&
                          x < static_cast<float>(level.width) - 2.5F &&
                          y < static_cast<float>(level.height) - 2.5F;
      EXPECT_EQ(seen.seen[i] > 0, i < 37 && i != 5 && inside) << i;
      if (!(seen.seen[i] > 0)) continue;
      ++visible;
      // Single precision moves a pixel by 1e-4 at most; noise is steep.
      EXPECT_NEAR(seen.u[i], pixel.x, 1e-4);
      EXPECT_NEAR(seen.brightness[i], level.At(x, y), 0.05);
      const float shrink = 1.0F / static_cast<float>(1 << l);
      EXPECT_NEAR(seen.gradient_x[i],
                  shrink * (level.At(x + 0.5F, y) - level.At(x - 0.5F, y)),
                  0.05);
      EXPECT_NEAR(seen.gradient_y[i],
                  shrink * (level.At(x, y + 0.5F) - level.At(x, y - 0.5F)),
                  0.05);
    }
    EXPECT_GT(visible, 10);
    EXPECT_EQ(counted, visible);
  }
}

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
  calibration.color = TestCamera();
  calibration.depth = *camera::Camera::Parse(lens, 60, 40);
  calibration.color_from_depth = {
      geometry::Rotation3::FromAxisAngle({0.01, 0.02, -0.01}),
      {0.03, -0.01, 0.005}};
  calibration.depth_scale = 1.02;
  return calibration;
}

TEST(AlignmentKernelsTest, DepthIsLookedUpThroughItsLens) {
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

TEST(AlignmentKernelsTest, TheLastDepthPixelIsReadFromInsideTheImage) {
  // Three values, of which points see the last; a sanitizer knows the end.
  camera::RgbdCalibration calibration;
  calibration.color = TestCamera();
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

TEST(AlignmentKernelsTest, OtherLensesAreLookedThroughPointByPoint) {
  const image::DepthImage depth{
      .width = 60, .height = 40, .values = std::vector<uint16_t>(60 * 40, 1)};
  EXPECT_FALSE(
      DepthViewOf(WithDepthCamera("OPENCV_FISHEYE,55,56,29,20,0.1,0,0,0"),
                  depth)
          .has_value());
  EXPECT_FALSE(
      DepthViewOf(WithDepthCamera("FOV,55,56,29,20,0.5"), depth).has_value());
}

TEST(AlignmentKernelsTest, ExposureIsFoundAgain) {
  constexpr size_t kPoints = 64;
  std::vector<float> reference;
  VisiblePoints seen;
  seen.resize(kPoints);
  for (size_t i = 0; i < kPoints; ++i) {
    reference.push_back(static_cast<float>(3 * i + 10));
    seen.seen[i] = i % 3 == 0 ? 0 : 1;
    seen.brightness[i] = seen.seen[i] * (0.8F * reference[i] + 12);
  }
  const ExposureSums s = SumExposure(reference, seen, 0, kPoints, 1, 0, 1e9F);
  const float gain = (s.xy - s.x * s.y / s.w) / (s.xx - s.x * s.x / s.w);
  EXPECT_NEAR(gain, 0.8F, 1e-4);
  EXPECT_NEAR((s.y - gain * s.x) / s.w + 128 * (1 - gain), 12, 0.02);
}

TEST(AlignmentKernelsTest, SurfacesPullTowardsWhatWasMeasured) {
  SurfacePoints points;
  const PinholeView view = ViewOf({}, TestCamera(), {});
  base::Random random(5, 0);
  for (int i = 0; i < 40; ++i) {
    const geometry::Vec3 p{0.01 * random.NextBelow(100),
                           0.01 * random.NextBelow(100), 2};
    points.Append(p, {0, 0, -1}, p + geometry::Vec3{0, 0, 0.02}, 1e-4);
  }
  points.Pad();
  NormalSums sums;
  AddSurfaces(points, view, 0.15F, sums);
  // n . (p - measured) = 0.02; its derivative with respect to z is -1, and
  // Geman-McClure's weight at one scale is a quarter.
  EXPECT_NEAR(sums.g[2], -40 * 0.02 * 0.25 / 1e-4, 1);
  EXPECT_NEAR(sums.h[11], 40 * 0.25 / 1e-4, 50);
  NormalSums none;
  AddSurfaces(points, view, 0.01F, none);
  EXPECT_EQ(none.g[2], 0);
}

}  // namespace
}  // namespace treeline::keyframes
