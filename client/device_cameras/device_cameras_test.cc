#include "client/device_cameras/device_cameras.h"

#include <cmath>
#include <numbers>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::device_cameras {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Rounding of a few products.
constexpr double kRounding = 1e-12;

void ExpectNear(geometry::Vec3 a, geometry::Vec3 b) {
  EXPECT_LT(geometry::Norm(a - b), kRounding)
      << a.x << " " << a.y << " " << a.z << " is not " << b.x << " " << b.y
      << " " << b.z;
}

std::vector<double> First(const camera::Camera& camera, int count) {
  return {camera.parameters().begin(), camera.parameters().begin() + count};
}

TEST(Colmap, CountsPixelsFromTheCorner) {
  const auto camera =
      CameraFromColmap("SIMPLE_RADIAL", 640, 480, {500, 320, 240, 0.1});
  ASSERT_TRUE(camera.ok()) << camera.status();
  EXPECT_THAT(First(*camera, 4), ElementsAre(500, 319.5, 239.5, 0.1));
  const auto pinhole =
      CameraFromColmap("PINHOLE", 640, 480, {500, 510, 320, 240});
  EXPECT_THAT(First(pinhole.value(), 4), ElementsAre(500, 510, 319.5, 239.5));
  EXPECT_FALSE(CameraFromColmap("PINHOLE", 640, 480, {500}).ok());
  EXPECT_FALSE(CameraFromColmap("ODD", 640, 480, {500, 1, 1}).ok());
}

TEST(Colmap, GivesWhereTheCameraIs) {
  // The camera at (1, 2, 3) that looks along the world's x, z up.
  const geometry::Rigid3 world_from_camera = {
      geometry::Rotation3::FromMatrix({0, 0, 1, -1, 0, 0, 0, -1, 0}),
      {1, 2, 3}};
  const geometry::Rigid3 stated = world_from_camera.Inverse();
  const auto pose = WorldFromCameraOfColmap(
      stated.rotation.w, stated.rotation.x, stated.rotation.y,
      stated.rotation.z, stated.translation);
  ASSERT_TRUE(pose.ok()) << pose.status();
  ExpectNear(*pose * geometry::Vec3{0, 0, 4}, {5, 2, 3});
  EXPECT_FALSE(WorldFromCameraOfColmap(1, 1, 0, 0, {}).ok());
}

TEST(OpenCv, KeepsItsPixelsAndDistortion) {
  const std::array<double, 9> matrix = {500, 0, 320, 0, 510, 240, 0, 0, 1};
  EXPECT_THAT(First(CameraFromOpenCv(matrix, 640, 480).value(), 4),
              ElementsAre(500, 510, 320, 240));
  const auto four =
      CameraFromOpenCv(matrix, 640, 480, {0.1, 0.01, 0.001, 0.002});
  EXPECT_EQ(four.value().model(), camera::CameraModel::kOpenCv);
  const auto five =
      CameraFromOpenCv(matrix, 640, 480, {0.1, 0.01, 0.001, 0.002, 0.3});
  EXPECT_EQ(five.value().model(), camera::CameraModel::kFullOpenCv);
  EXPECT_THAT(First(*five, 12), ElementsAre(500, 510, 320, 240, 0.1, 0.01,
                                            0.001, 0.002, 0.3, 0, 0, 0));
  EXPECT_THAT(
      std::string(CameraFromOpenCv(matrix, 640, 480, {0.1}).status().message()),
      HasSubstr("1 distortion"));
}

TEST(OpenCv, InvertsWhatSolvePnpGives) {
  const geometry::Rigid3 pose =
      WorldFromCameraOfOpenCv({0, 0, std::numbers::pi / 2}, {1, 0, 2});
  ExpectNear(pose * geometry::Vec3{1, 0, 2}, {0, 0, 0});
  ExpectNear(pose * geometry::Vec3{0, 0, 2}, {0, 1, 0});
}

// A camera at (1, 2, 3) of a world with y up, that looks along -z: without a
// turn in the axes of OpenGL.
constexpr std::array<double, 16> kLooksAlongMinusZ = {1, 0, 0, 0, 0, 1, 0, 0,
                                                      0, 0, 1, 0, 1, 2, 3, 1};

void ExpectLooksAlongMinusZ(const absl::StatusOr<geometry::Rigid3>& pose) {
  ASSERT_TRUE(pose.ok()) << pose.status();
  // 5 m ahead, to the right, and below.
  ExpectNear(*pose * geometry::Vec3{0, 0, 5}, {1, 2, -2});
  ExpectNear(*pose * geometry::Vec3{1, 0, 0}, {2, 2, 3});
  ExpectNear(*pose * geometry::Vec3{0, 1, 0}, {1, 1, 3});
}

TEST(ArKit, HasColumnsAndTheAxesOfOpenGl) {
  const auto camera =
      CameraFromArKit({1450, 0, 0, 0, 1451, 0, 960, 720, 1}, 1920, 1440);
  EXPECT_THAT(First(camera.value(), 4), ElementsAre(1450, 1451, 959.5, 719.5));
  ExpectLooksAlongMinusZ(DeviceFromCameraOfArKit(kLooksAlongMinusZ));
  std::array<double, 16> rows{};
  for (size_t i = 0; i < 16; ++i)
    rows[i] = kLooksAlongMinusZ[i % 4 * 4 + i / 4];
  EXPECT_FALSE(DeviceFromCameraOfArKit(rows).ok());
}

TEST(ArCore, HasItsOwnOrderOfAQuaternion) {
  const auto camera = CameraFromArCore({480, 481}, {320, 240}, 640, 480);
  EXPECT_THAT(First(camera.value(), 4), ElementsAre(480, 481, 319.5, 239.5));
  ExpectLooksAlongMinusZ(DeviceFromCameraOfArCore({1, 2, 3}, 0, 0, 0, 1));
  EXPECT_FALSE(DeviceFromCameraOfArCore({1, 2, 3}, 0, 0, 0, 0.5).ok());
}

TEST(WebXr, IsTheCameraThatProjectsAlike) {
  // 90 degrees across, a picture of 4:3, off the centre.
  std::array<double, 16> p{};
  p[0] = 1;
  p[5] = 4.0 / 3;
  p[8] = 0.1;
  p[9] = -0.2;
  p[10] = -1.001;
  p[11] = -1;
  p[14] = -0.02;
  const auto camera = CameraFromWebXr(p, 640, 480);
  ASSERT_TRUE(camera.ok()) << camera.status();
  // By the matrix: clip coordinates of a point, on a picture whose corners are
  // at (-1, 1) and (1, -1).
  const geometry::Vec3 opengl = {0.3, 0.2, -2};
  const double x = (p[0] * opengl.x + p[8] * opengl.z) / -opengl.z;
  const double y = (p[5] * opengl.y + p[9] * opengl.z) / -opengl.z;
  const auto pixel = camera->Project({opengl.x, -opengl.y, -opengl.z});
  EXPECT_NEAR(pixel.x, (x + 1) / 2 * 640 - 0.5, 1e-9);
  EXPECT_NEAR(pixel.y, (1 - y) / 2 * 480 - 0.5, 1e-9);
  p[15] = 1;
  EXPECT_THAT(std::string(CameraFromWebXr(p, 640, 480).status().message()),
              HasSubstr("perspective"));
  ExpectLooksAlongMinusZ(DeviceFromCameraOfWebXr(kLooksAlongMinusZ));
}

TEST(Axes, OfOpenGlAndBodiesGoThereAndBack) {
  const geometry::Rigid3 pose = {
      geometry::Rotation3::FromAxisAngle({0.3, -0.2, 0.9}), {1, 2, 3}};
  for (const geometry::Rigid3& back :
       {CameraFromOpenGlPose(OpenGlFromCameraPose(pose)),
        CameraFromBodyPose(BodyFromCameraPose(pose))}) {
    // acos near 1 loses half of the digits.
    EXPECT_LT(geometry::AngleBetween_rad(back.rotation, pose.rotation), 1e-7);
    EXPECT_EQ(back.translation, pose.translation);
  }
  // Without a turn the camera looks along z, and its picture's top is -y.
  const geometry::Rigid3 body = BodyFromCameraPose({});
  ExpectNear(body * geometry::Vec3{1, 0, 0}, {0, 0, 1});
  ExpectNear(body * geometry::Vec3{0, 1, 0}, {-1, 0, 0});
  ExpectNear(body * geometry::Vec3{0, 0, 1}, {0, -1, 0});
  const geometry::Rigid3 opengl = OpenGlFromCameraPose({});
  ExpectNear(opengl * geometry::Vec3{0, 1, 0}, {0, -1, 0});
  ExpectNear(opengl * geometry::Vec3{0, 0, 1}, {0, 0, -1});
}

}  // namespace
}  // namespace treeline::device_cameras
