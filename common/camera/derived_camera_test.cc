#include "common/camera/derived_camera.h"

#include <array>
#include <string>
#include <tuple>

#include "gtest/gtest.h"

namespace treeline::camera {
namespace {

constexpr double kTolerance_px = 1e-9;

// Every model, with distortion that is not symmetric where it has such.
class DerivedCamera : public ::testing::TestWithParam<const char*> {
 protected:
  const Camera camera_ = Camera::Parse(GetParam(), 64, 48).value();
};

constexpr std::array<geometry::Vec3, 4> kPoints{
    geometry::Vec3{0.1, 0.3, 1}, geometry::Vec3{-0.2, 0.1, 1},
    geometry::Vec3{0.4, -0.3, 2}, geometry::Vec3{-0.3, -0.2, 1}};

void ExpectNear(Pixel actual, Pixel expected) {
  EXPECT_NEAR(actual.x, expected.x, kTolerance_px);
  EXPECT_NEAR(actual.y, expected.y, kTolerance_px);
}

TEST_P(DerivedCamera, SeesTheMirroredScene) {
  const Camera mirrored = Mirrored(camera_);
  for (const geometry::Vec3& point : kPoints) {
    const Pixel pixel = camera_.Project(point);
    ExpectNear(mirrored.Project({-point.x, point.y, point.z}),
               {63 - pixel.x, pixel.y});
  }
}

TEST_P(DerivedCamera, SeesTheSameThroughAWindow) {
  const Camera cropped = Cropped(camera_, 5, 7, 40, 30).value();
  EXPECT_EQ(cropped.width(), 40);
  EXPECT_EQ(cropped.height(), 30);
  for (const geometry::Vec3& point : kPoints) {
    const Pixel pixel = camera_.Project(point);
    ExpectNear(cropped.Project(point), {pixel.x - 5, pixel.y - 7});
  }
}

TEST_P(DerivedCamera, KeepsTheEdgesWhenResized) {
  const Camera half = Resized(camera_, 0.5).value();
  EXPECT_EQ(half.width(), 32);
  EXPECT_EQ(half.height(), 24);
  for (const geometry::Vec3& point : kPoints) {
    const Pixel pixel = camera_.Project(point);
    ExpectNear(half.Project(point),
               {(pixel.x + 0.5) / 2 - 0.5, (pixel.y + 0.5) / 2 - 0.5});
  }
}

TEST_P(DerivedCamera, ImagesAllBesideWithItsPrincipalPointMoved) {
  const Camera moved = WithPrincipalPointMoved(camera_, 3, -2).value();
  for (const geometry::Vec3& point : kPoints) {
    const Pixel pixel = camera_.Project(point);
    ExpectNear(moved.Project(point), {pixel.x + 3, pixel.y - 2});
  }
}

INSTANTIATE_TEST_SUITE_P(
    Models, DerivedCamera,
    ::testing::Values(
        "SIMPLE_PINHOLE,50,31,22", "PINHOLE,50,55,31,22",
        "SIMPLE_RADIAL,50,31,22,0.1", "RADIAL,50,31,22,0.1,-0.05",
        "OPENCV,50,55,31,22,0.1,-0.05,0.01,0.02",
        "FULL_OPENCV,50,55,31,22,0.1,-0.05,0.01,0.02,0.01,0.02,0.03,0.01",
        "OPENCV_FISHEYE,50,55,31,22,0.1,0.01,0.001,0.0001",
        "FOV,50,55,31,22,0.9", "SIMPLE_RADIAL_FISHEYE,50,31,22,0.1",
        "RADIAL_FISHEYE,50,31,22,0.1,0.01",
        "THIN_PRISM_FISHEYE,50,55,31,22,0.1,0.01,0.01,0.02,0.001,0.0001,0.02,"
        "0.03"));

TEST(WithRadialAdded, MakesALensOfAPinhole) {
  const auto bent = [](const char* text) {
    return WithRadialAdded(*Camera::Parse(text, 64, 48), 0.25)->ToString();
  };
  EXPECT_EQ(bent("SIMPLE_PINHOLE,50,31,22"), "SIMPLE_RADIAL,50,31,22,0.25");
  EXPECT_EQ(bent("PINHOLE,50,55,31,22"), "OPENCV,50,55,31,22,0.25,0,0,0");
  EXPECT_EQ(bent("RADIAL,50,31,22,-0.5,0.125"), "RADIAL,50,31,22,-0.25,0.125");
  EXPECT_EQ(WithRadialAdded(*Camera::Parse("FOV,50,55,31,22,0.9", 64, 48), 0.25)
                .status()
                .code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(Cropped, RefusesWindowsBeyondThePicture) {
  const Camera camera;
  EXPECT_TRUE(Cropped(camera, 0, 0, 640, 480).ok());
  for (const auto& [left, top, width, height] : {std::tuple{-1, 0, 5, 5},
                                                 {0, -1, 5, 5},
                                                 {0, 0, 0, 5},
                                                 {0, 0, 5, 0},
                                                 {636, 0, 5, 5},
                                                 {0, 476, 5, 5}}) {
    EXPECT_EQ(Cropped(camera, left, top, width, height).status().code(),
              absl::StatusCode::kInvalidArgument)
        << left << " " << top << " " << width << " " << height;
  }
}

TEST(Resized, RefusesFactorsThatLeaveNoPicture) {
  const Camera camera;
  for (const double factor : {0.0, -1.0, 1e-4, 100.0, 1e300}) {
    EXPECT_EQ(Resized(camera, factor).status().code(),
              absl::StatusCode::kInvalidArgument)
        << factor;
  }
}

}  // namespace
}  // namespace treeline::camera
