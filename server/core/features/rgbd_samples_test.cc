#include "server/core/features/rgbd_samples.h"

#include <algorithm>

#include "gtest/gtest.h"
#include "server/core/features/pixel_difference.h"
#include "server/core/features/walsh_hadamard.h"

namespace treeline::features {
namespace {

camera::RgbdCalibration SideBySide() {
  camera::RgbdCalibration calibration;
  calibration.color =
      *camera::Camera::Parse("PINHOLE,525,525,320,240", 640, 480);
  calibration.depth =
      *camera::Camera::Parse("PINHOLE,585,585,320,240", 640, 480);
  calibration.color_from_depth.translation = {-0.025, 0, 0};
  return calibration;
}

image::DepthImage Flat(uint16_t value) {
  return {640, 480, std::vector<uint16_t>(640 * 480, value), 0.001};
}

TEST(DepthGeometryTest, LiftsAndProjectsByHand) {
  camera::RgbdCalibration calibration = SideBySide();
  calibration.depth_scale = 1.5;
  const DepthGeometry geometry(calibration);
  DepthGeometry::Lifted lifted;
  // 58.5 px right of the centre: 0.1 per metre; 2 m of measured depth are 3 m.
  ASSERT_TRUE(geometry.Lift(379, 240, 2, lifted));
  EXPECT_NEAR(lifted.point_in_color.x, 3 * 59 / 585. - 0.025, 1e-12);
  EXPECT_NEAR(lifted.point_in_color.z, 3, 1e-12);
  EXPECT_NEAR(lifted.color_pixel.x, 320 + 525 * (3 * 59 / 585. - 0.025) / 3,
              1e-9);
  EXPECT_EQ(lifted.point_in_pose_sensor, lifted.point_in_color);
}

TEST(DepthGeometryTest, GivesPointsInThePoseSensorsFrame) {
  camera::RgbdCalibration calibration = SideBySide();
  calibration.pose_sensor = camera::RgbdSensor::kDepth;
  const DepthGeometry geometry(calibration);
  DepthGeometry::Lifted lifted;
  ASSERT_TRUE(geometry.Lift(320, 240, 2, lifted));
  EXPECT_EQ(lifted.point_in_pose_sensor, (geometry::Vec3{0, 0, 2}));
  EXPECT_EQ(lifted.point_in_color, (geometry::Vec3{-0.025, 0, 2}));
}

TEST(DrawSamplesTest, GivesAsManyAsAskedWithPatchesInside) {
  RgbdSamples samples;
  DrawSamples(DepthGeometry(SideBySide()), Flat(2000), 300, base::Random(1, 0),
              samples);
  ASSERT_EQ(samples.size(), 300u);
  for (size_t i = 0; i < samples.size(); ++i) {
    EXPECT_TRUE(PatchInside(samples.x[i], samples.y[i], 640, 480));
    EXPECT_EQ(samples.inverse_depth_q12[i], InverseDepthQ12(525, 2));
    EXPECT_DOUBLE_EQ(samples.point[i].z, 2);
  }
}

TEST(DrawSamplesTest, TakesOnlyMeasuredDepthInRange) {
  image::DepthImage depth = Flat(0);
  const size_t good = 240 * 640 + 320;
  depth.values[good - 1] = 65535;  // not measured
  depth.values[good + 1] = 100;    // 0.1 m: too near
  depth.values[good + 2] = 11000;  // 11 m: too far
  depth.values[good] = 2000;
  RgbdSamples samples;
  DrawSamples(DepthGeometry(SideBySide()), depth, 20000, base::Random(1, 0),
              samples);
  for (const geometry::Vec3& point : samples.point)
    EXPECT_DOUBLE_EQ(point.z, 2);
  EXPECT_LT(samples.size(), 20u);  // one pixel in 307,200, 160,000 draws
}

TEST(DrawSamplesTest, GivesUpOnAFrameWithoutDepth) {
  RgbdSamples samples;
  DrawSamples(DepthGeometry(SideBySide()), Flat(0), 100, base::Random(1, 0),
              samples);
  EXPECT_EQ(samples.size(), 0u);
}

TEST(DrawSamplesTest, TheFirstAreThoseOfAll) {
  // Hardly any depth: one pixel in twelve, so that draws run out.
  image::DepthImage sparse = Flat(0);
  for (size_t i = 0; i < sparse.values.size(); i += 12) {
    sparse.values[i] = static_cast<uint16_t>(1000 + i % 3000);
  }
  const DepthGeometry geometry(SideBySide());
  RgbdSamples all, first;
  DrawSamples(geometry, sparse, 300, base::Random(1, 0), all);
  ASSERT_GT(all.size(), 60u);
  ASSERT_LT(all.size(), 300u);
  for (const int count : {1, 60, 299, 300, 400}) {
    DrawFirstSamples(geometry, sparse, count, 300, base::Random(1, 0), first);
    const size_t expected = std::min(all.size(), static_cast<size_t>(count));
    ASSERT_EQ(first.size(), expected) << count;
    for (size_t i = 0; i < expected; ++i) {
      EXPECT_EQ(first.x[i], all.x[i]);
      EXPECT_EQ(first.y[i], all.y[i]);
      EXPECT_EQ(first.point[i], all.point[i]);
    }
  }
}

TEST(DrawSamplesTest, DependsOnTheSeedAlone) {
  RgbdSamples a, b, c;
  const DepthGeometry geometry(SideBySide());
  DrawSamples(geometry, Flat(2000), 50, base::Random(1, 0), a);
  DrawSamples(geometry, Flat(2000), 50, base::Random(1, 0), b);
  DrawSamples(geometry, Flat(2000), 50, base::Random(2, 0), c);
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.y, b.y);
  EXPECT_NE(a.x, c.x);
}

}  // namespace
}  // namespace treeline::features
