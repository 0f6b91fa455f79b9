#include "server/core/keyframes/alignment_kernels.h"

#include <array>
#include <cmath>
#include <vector>

#include "common/base/random.h"
#include "gtest/gtest.h"

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
