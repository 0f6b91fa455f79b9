#include "common/camera/camera.h"

#include <cmath>
#include <limits>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::camera {
namespace {

using ::testing::HasSubstr;

Camera ParseOrDie(const char* text) {
  absl::StatusOr<Camera> camera = Camera::Parse(text, 640, 480);
  EXPECT_TRUE(camera.ok()) << camera.status();
  return camera.ok() ? *camera : Camera();
}

TEST(CameraTest, DefaultIsTheKinectPinhole) {
  const Camera camera;
  EXPECT_EQ(camera, ParseOrDie("PINHOLE,585,585,320,240"));
  EXPECT_FALSE(camera.has_distortion());
}

TEST(CameraTest, PinholeProjectsByHand) {
  const Camera camera = ParseOrDie("PINHOLE,500,400,320,240");
  const Pixel pixel = camera.Project({0.5, -0.25, 2});
  EXPECT_DOUBLE_EQ(pixel.x, 500 * 0.25 + 320);
  EXPECT_DOUBLE_EQ(pixel.y, 400 * -0.125 + 240);
}

TEST(CameraTest, SimplePinholeUsesOneFocalLength) {
  const Camera camera = ParseOrDie("SIMPLE_PINHOLE,500,310,230");
  EXPECT_EQ(camera.fx(), 500);
  EXPECT_EQ(camera.fy(), 500);
  EXPECT_EQ(camera.cx(), 310);
  EXPECT_EQ(camera.cy(), 230);
}

// At (x, y) = (0.5, 0.25), r2 = 0.3125.
TEST(CameraTest, RadialModelsProjectByHand) {
  const Pixel simple =
      ParseOrDie("SIMPLE_RADIAL,100,0,0,0.1").Project({0.5, 0.25, 1});
  EXPECT_NEAR(simple.x, 100 * 0.5 * (1 + 0.1 * 0.3125), 1e-12);
  EXPECT_NEAR(simple.y, 100 * 0.25 * (1 + 0.1 * 0.3125), 1e-12);
  const Pixel radial =
      ParseOrDie("RADIAL,100,0,0,0.1,-0.2").Project({0.5, 0.25, 1});
  const double g = 1 + 0.1 * 0.3125 - 0.2 * 0.09765625;
  EXPECT_NEAR(radial.x, 50 * g, 1e-12);
  EXPECT_NEAR(radial.y, 25 * g, 1e-12);
}

TEST(CameraTest, OpenCvTangentialTermsProjectByHand) {
  const Pixel pixel =
      ParseOrDie("OPENCV,100,200,10,20,0,0,0.01,0.02").Project({0.5, 0.25, 1});
  // x' = x + 2 p1 x y + p2 (r2 + 2 x^2)
  EXPECT_NEAR(pixel.x, 100 * (0.5 + 0.0025 + 0.02 * 0.8125) + 10, 1e-12);
  // y' = y + p1 (r2 + 2 y^2) + 2 p2 x y
  EXPECT_NEAR(pixel.y, 200 * (0.25 + 0.01 * 0.4375 + 0.005) + 20, 1e-12);
}

TEST(CameraTest, FullOpenCvHasARationalRadialFactor) {
  const Pixel pixel =
      ParseOrDie("FULL_OPENCV,100,100,0,0,0.1,0.2,0,0,0.3,0.4,0.5,0.6")
          .Project({0.5, 0.25, 1});
  const double r2 = 0.3125;
  const double g = (1 + 0.1 * r2 + 0.2 * r2 * r2 + 0.3 * r2 * r2 * r2) /
                   (1 + 0.4 * r2 + 0.5 * r2 * r2 + 0.6 * r2 * r2 * r2);
  EXPECT_NEAR(pixel.x, 50 * g, 1e-12);
  EXPECT_NEAR(pixel.y, 25 * g, 1e-12);
}

TEST(CameraTest, FisheyeIsEquidistantWithoutCoefficients) {
  const Camera camera = ParseOrDie("OPENCV_FISHEYE,300,300,320,240,0,0,0,0");
  EXPECT_TRUE(camera.has_distortion());
  // A ray at 45 degrees lands pi/4 focal lengths away.
  const Pixel pixel = camera.Project({2, 0, 2});
  EXPECT_NEAR(pixel.x, 320 + 300 * std::atan(1.0), 1e-10);
  EXPECT_NEAR(pixel.y, 240, 1e-10);
}

TEST(CameraTest, FisheyePolynomialProjectsByHand) {
  const Camera camera =
      ParseOrDie("OPENCV_FISHEYE,100,100,0,0,0.1,0.01,0.001,0.0001");
  const double t = std::atan(1.0);
  const double t2 = t * t;
  const double radius = t * (1 + 0.1 * t2 + 0.01 * t2 * t2 +
                             0.001 * t2 * t2 * t2 + 0.0001 * t2 * t2 * t2 * t2);
  EXPECT_NEAR(camera.Project({0, 3, 3}).y, 100 * radius, 1e-10);
}

// A ray at 45 degrees along y: theta is pi/4.
TEST(CameraTest, RadialFisheyesProjectByHand) {
  const double t = std::atan(1.0);
  EXPECT_NEAR(
      ParseOrDie("SIMPLE_RADIAL_FISHEYE,100,5,7,0.1").Project({0, 3, 3}).y,
      100 * t * (1 + 0.1 * t * t) + 7, 1e-10);
  EXPECT_NEAR(
      ParseOrDie("RADIAL_FISHEYE,100,5,7,0.1,-0.02").Project({0, 3, 3}).y,
      100 * t * (1 + 0.1 * t * t - 0.02 * t * t * t * t) + 7, 1e-10);
}

TEST(CameraTest, FovProjectsByHand) {
  const Camera camera = ParseOrDie("FOV,100,200,10,20,0.8");
  const Pixel pixel = camera.Project({1, 1, 2});
  const double r = std::hypot(0.5, 0.5);
  const double scale = std::atan(2 * r * std::tan(0.4)) / 0.8 / r;
  EXPECT_NEAR(pixel.x, 100 * 0.5 * scale + 10, 1e-10);
  EXPECT_NEAR(pixel.y, 200 * 0.5 * scale + 20, 1e-10);
}

TEST(CameraTest, FovWithoutAFieldOfViewIsAPinhole) {
  for (const char* text : {"FOV,100,200,10,20,0", "FOV,100,200,10,20,1e-300"}) {
    const Pixel pixel = ParseOrDie(text).Project({1, 1, 2});
    EXPECT_DOUBLE_EQ(pixel.x, 60) << text;
    EXPECT_DOUBLE_EQ(pixel.y, 120) << text;
  }
}

// The ray (1, 0) has theta = pi/4 along x: u = pi/4, v = 0, r2 = u^2.
TEST(CameraTest, ThinPrismFisheyeProjectsByHand) {
  const Pixel pixel = ParseOrDie(
                          "THIN_PRISM_FISHEYE,100,200,0,0,0.1,0.02,0.03,0.04,"
                          "0.005,0.006,0.07,0.08")
                          .Project({2, 0, 2});
  const double u = std::atan(1.0);
  const double r2 = u * u;
  const double g = 1 + 0.1 * r2 + 0.02 * r2 * r2 + 0.005 * r2 * r2 * r2 +
                   0.006 * r2 * r2 * r2 * r2;
  EXPECT_NEAR(pixel.x, 100 * (g * u + 0.04 * 3 * r2 + 0.07 * r2), 1e-10);
  EXPECT_NEAR(pixel.y, 200 * (0.03 * r2 + 0.08 * r2), 1e-10);
}

class CameraRoundTripTest : public ::testing::TestWithParam<const char*> {};

TEST_P(CameraRoundTripTest, EveryPixelUnprojectsToTheRayThatProjectsToIt) {
  const Camera camera = ParseOrDie(GetParam());
  for (int y = 0; y < 480; y += 7) {
    for (int x = 0; x < 640; x += 7) {
      const auto ray = camera.Unproject({1.0 * x, 1.0 * y});
      ASSERT_TRUE(ray.has_value()) << x << ", " << y;
      const Pixel back = camera.Project({3 * ray->x, 3 * ray->y, 3});
      ASSERT_NEAR(back.x, x, 1e-8);
      ASSERT_NEAR(back.y, y, 1e-8);
    }
  }
}

TEST_P(CameraRoundTripTest, UnprojectFindsTheRayOnTheNearBranch) {
  const Camera camera = ParseOrDie(GetParam());
  for (double y = -0.3; y <= 0.3; y += 0.06) {
    for (double x = -0.4; x <= 0.4; x += 0.08) {
      const auto ray = camera.Unproject(camera.Project({x, y, 1}));
      ASSERT_TRUE(ray.has_value()) << x << ", " << y;
      ASSERT_NEAR(ray->x, x, 1e-10);
      ASSERT_NEAR(ray->y, y, 1e-10);
    }
  }
}

TEST_P(CameraRoundTripTest, TextRoundTripsExactly) {
  const Camera camera = ParseOrDie(GetParam());
  EXPECT_EQ(camera.ToString(), GetParam());
  EXPECT_EQ(ParseOrDie(camera.ToString().c_str()), camera);
}

INSTANTIATE_TEST_SUITE_P(
    Models, CameraRoundTripTest,
    ::testing::Values(
        "SIMPLE_PINHOLE,525,319.5,239.5", "PINHOLE,585.25,584.1,320,240",
        "SIMPLE_RADIAL,525,320,240,-0.2", "RADIAL,525,320,240,0.2,-0.3",
        "OPENCV,520,521,320,240,-0.28,0.07,0.001,-0.002",
        "FULL_OPENCV,517.3,516.5,318.6,255.3,0.2624,-0.9531,-0.0054,0.0026,"
        "1.1633,0,0,0",
        "FULL_OPENCV,520,520,320,240,0.5,-0.1,0.001,0.002,0.02,0.7,0.05,0.01",
        "OPENCV_FISHEYE,300,301,320,240,-0.02,0.01,-0.004,0.001",
        "FOV,400,410,320,240,0.9", "FOV,400,410,320,240,-0.9",
        "SIMPLE_RADIAL_FISHEYE,320,320,240,-0.03",
        "RADIAL_FISHEYE,320,320,240,-0.03,0.01",
        "THIN_PRISM_FISHEYE,330,331,320,240,-0.02,0.01,0.001,-0.002,-0.004,"
        "0.001,0.003,-0.001"));

TEST(CameraTest, UnprojectGivesUpBeyondTheFoldOfABarrelDistortion) {
  // r (1 - 0.5 r^2) never exceeds 0.544: pixels farther out see nothing.
  const Camera camera = ParseOrDie("SIMPLE_RADIAL,300,320,240,-0.5");
  EXPECT_TRUE(camera.Unproject({320 + 300 * 0.5, 240}).has_value());
  EXPECT_FALSE(camera.Unproject({320 + 300 * 0.6, 240}).has_value());
}

TEST(CameraTest, UnprojectGivesUpOnFisheyeRaysAcrossTheCamera) {
  const Camera camera = ParseOrDie("OPENCV_FISHEYE,100,100,320,240,0,0,0,0");
  EXPECT_TRUE(camera.Unproject({320 + 156, 240}).has_value());
  EXPECT_FALSE(camera.Unproject({320 + 158, 240}).has_value());
  const Camera prism =
      ParseOrDie("THIN_PRISM_FISHEYE,100,100,320,240,0,0,0,0,0,0,0,0");
  EXPECT_TRUE(prism.Unproject({320 + 156, 240}).has_value());
  EXPECT_FALSE(prism.Unproject({320 + 158, 240}).has_value());
  // tan(radius * omega) has its pole at radius pi/2 focal lengths.
  const Camera fov = ParseOrDie("FOV,100,100,320,240,1");
  EXPECT_TRUE(fov.Unproject({320 + 156, 240}).has_value());
  EXPECT_FALSE(fov.Unproject({320 + 158, 240}).has_value());
}

TEST(CameraTest, UnprojectOfNanIsNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const char* text :
       {"SIMPLE_RADIAL,300,320,240,-0.1", "FOV,300,300,320,240,0.5",
        "SIMPLE_RADIAL_FISHEYE,300,320,240,-0.1",
        "THIN_PRISM_FISHEYE,300,300,320,240,0,0,0,0,0,0,0,0"}) {
    EXPECT_FALSE(ParseOrDie(text).Unproject({nan, 0}).has_value()) << text;
  }
}

TEST(CameraTest, RejectsBadParametersWithTheReason) {
  const auto error = [](const char* text, int width = 640, int height = 480) {
    const absl::StatusOr<Camera> camera = Camera::Parse(text, width, height);
    EXPECT_EQ(camera.status().code(), absl::StatusCode::kInvalidArgument)
        << text;
    return std::string(camera.status().message());
  };
  EXPECT_THAT(error("PINHOLE,585,585,320"), HasSubstr("takes 4 parameters"));
  EXPECT_THAT(error("PINHOLE"), HasSubstr("not 0"));
  EXPECT_THAT(error("PINHOLE,585,585,320,240,0"), HasSubstr("not 5"));
  EXPECT_THAT(error("PINHOLE,585,585,three,240"), HasSubstr("'three'"));
  EXPECT_THAT(error("PINHOLE,585,nan,320,240"), HasSubstr("not a finite"));
  EXPECT_THAT(error("PINHOLE,585,inf,320,240"), HasSubstr("not a finite"));
  EXPECT_THAT(error("PINHOLE,0,585,320,240"), HasSubstr("not positive"));
  EXPECT_THAT(error("PINHOLE,585,-1,320,240"), HasSubstr("not positive"));
  EXPECT_THAT(error("FOV,585,585,320,240,3.2"), HasSubstr("omega 3.2"));
  EXPECT_THAT(error("WIDE,585,585,320,240"), HasSubstr("unknown camera model"));
  EXPECT_THAT(error(""), HasSubstr("unknown camera model"));
  EXPECT_THAT(error("PINHOLE,585,585,320,240", 0, 480), HasSubstr("0 x 480"));
  EXPECT_THAT(error("PINHOLE,585,585,320,240", 640, 16385),
              HasSubstr("outside"));
}

TEST(CameraTest, RejectsAModelNumberThatDoesNotExist) {
  const std::vector<double> parameters = {585, 320, 240};
  EXPECT_EQ(
      Camera::Create(static_cast<CameraModel>(99), 640, 480, parameters.data(),
                     static_cast<int>(parameters.size()))
          .status()
          .code(),
      absl::StatusCode::kInvalidArgument);
}

TEST(CameraTest, ModelNamesRoundTrip) {
  for (const CameraModel model :
       {CameraModel::kSimplePinhole, CameraModel::kPinhole,
        CameraModel::kSimpleRadial, CameraModel::kRadial, CameraModel::kOpenCv,
        CameraModel::kFullOpenCv, CameraModel::kOpenCvFisheye,
        CameraModel::kFov, CameraModel::kSimpleRadialFisheye,
        CameraModel::kRadialFisheye, CameraModel::kThinPrismFisheye}) {
    EXPECT_EQ(*ParseCameraModel(CameraModelName(model)), model);
  }
}

}  // namespace
}  // namespace treeline::camera
