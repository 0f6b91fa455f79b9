#include "common/image/depth_registration.h"

#include <optional>
#include <vector>

#include "gtest/gtest.h"

namespace treeline::image {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;

camera::RgbdCalibration Pair(const char* color, const char* depth,
                             geometry::Vec3 offset_m) {
  camera::RgbdCalibration calibration;
  calibration.color = camera::Camera::Parse(color, kWidth, kHeight).value();
  calibration.depth = camera::Camera::Parse(depth, kWidth, kHeight).value();
  calibration.color_from_depth.translation = offset_m;
  return calibration;
}

DepthImage NoDepth() {
  DepthImage depth{kWidth, kHeight, {}, 0.001};
  depth.values.assign(kWidth * kHeight, 0);
  return depth;
}

void SetDepth(DepthImage& depth, int x, int y, uint16_t value) {
  depth.values[static_cast<size_t>(y * depth.width + x)] = value;
}

TEST(DepthRegistrar, PutsAPointWhereTheColourCameraSeesIt) {
  // Depth pixel (180, 120), 20 px right of the centre at f 200, 2 m away: the
  // point (0.2, 0, 2). The colour camera sits 0.1 m to the right of it, so
  // that the point is (0.1, 0, 2) there, at 160 + 300 * 0.05 = 175.
  const camera::RgbdCalibration calibration =
      Pair("PINHOLE,300,300,160,120", "PINHOLE,200,200,160,120", {-0.1, 0, 0});
  const DepthRegistrar registration(calibration);
  DepthImage depth = NoDepth();
  SetDepth(depth, 180, 120, 2000);
  const std::vector<geometry::Vec3> points = registration.PointsInColor(depth);
  // A little beside it, the ray is that of the pixel asked for.
  const std::optional<geometry::Vec3> point =
      registration.PointAt(points, {175.3, 120});
  ASSERT_TRUE(point.has_value());
  EXPECT_NEAR(point->x, 2 * 15.3 / 300, 1e-12);
  EXPECT_NEAR(point->y, 0, 1e-12);
  EXPECT_NEAR(point->z, 2, 1e-12);
  EXPECT_FALSE(registration.PointAt(points, {180, 120}).has_value());
}

TEST(DepthRegistrar, AppliesTheDepthScale) {
  camera::RgbdCalibration calibration =
      Pair("PINHOLE,300,300,160,120", "PINHOLE,300,300,160,120", {});
  calibration.depth_scale = 0.99;
  const DepthRegistrar registration(calibration);
  DepthImage depth = NoDepth();
  SetDepth(depth, 160, 120, 2000);
  const auto point =
      registration.PointAt(registration.PointsInColor(depth), {160, 120});
  ASSERT_TRUE(point.has_value());
  EXPECT_NEAR(point->z, 1.98, 1e-12);
}

TEST(DepthRegistrar, KeepsTheNearerOfTwoPointsOnOnePixel) {
  // Half the focal length in colour: depth pixels 160 and 161 share a pixel.
  const camera::RgbdCalibration calibration =
      Pair("PINHOLE,100,100,160,120", "PINHOLE,400,400,160,120", {});
  const DepthRegistrar registration(calibration);
  DepthImage depth = NoDepth();
  SetDepth(depth, 160, 120, 2040);
  SetDepth(depth, 161, 120, 2000);
  const auto point =
      registration.PointAt(registration.PointsInColor(depth), {160, 120});
  ASSERT_TRUE(point.has_value());
  EXPECT_NEAR(point->z, 2, 1e-12);
}

TEST(DepthRegistrar, RefusesPointsAtDepthEdges) {
  const camera::RgbdCalibration calibration =
      Pair("PINHOLE,300,300,160,120", "PINHOLE,300,300,160,120", {});
  const DepthRegistrar registration(calibration);
  DepthImage depth = NoDepth();
  SetDepth(depth, 160, 120, 2000);
  SetDepth(depth, 161, 120, 2080);
  EXPECT_TRUE(
      registration.PointAt(registration.PointsInColor(depth), {160, 120})
          .has_value());
  SetDepth(depth, 161, 120, 2120);
  EXPECT_FALSE(
      registration.PointAt(registration.PointsInColor(depth), {160, 120})
          .has_value());
}

TEST(DepthRegistrar, IgnoresWhatWasNotMeasured) {
  const camera::RgbdCalibration calibration =
      Pair("PINHOLE,300,300,160,120", "PINHOLE,300,300,160,120", {});
  const DepthRegistrar registration(calibration);
  DepthImage depth = NoDepth();
  SetDepth(depth, 160, 120, 65535);
  EXPECT_FALSE(
      registration.PointAt(registration.PointsInColor(depth), {160, 120})
          .has_value());
  EXPECT_FALSE(
      registration.PointAt(registration.PointsInColor(depth), {-50, 400})
          .has_value());
}

}  // namespace
}  // namespace treeline::image
