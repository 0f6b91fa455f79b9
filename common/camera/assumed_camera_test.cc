#include "common/camera/assumed_camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace treeline::camera {
namespace {

Camera Scene() {
  return *Camera::Parse("RADIAL,525,319,241,0.1,-0.2", 640, 480);
}

TEST(AssumedCamera, AResizedPictureIsOfTheScenesCamera) {
  const Camera half = AssumedCamera(320, 240, std::nullopt, Scene());
  EXPECT_EQ(half.ToString(), "RADIAL,262.5,159.25,120.25,0.1,-0.2");
  EXPECT_EQ(half.width(), 320);
  // A third of 480 is exact, of 640 it is rounded.
  const Camera third = AssumedCamera(213, 160, std::nullopt, Scene());
  EXPECT_EQ(third.width(), 213);
  EXPECT_EQ(third.height(), 160);
  EXPECT_NEAR(third.fx(), 525 * 213 / 640.0, 1e-9);
}

TEST(AssumedCamera, APhonesLensIsTakenFromExif) {
  // 26 mm, 4000 x 3000: the diagonal is 5000.
  const Camera phone = AssumedCamera(4000, 3000, 26, Scene());
  EXPECT_EQ(phone.model(), CameraModel::kSimplePinhole);
  EXPECT_NEAR(phone.fx(), 26 / 43.2666 * 5000, 0.1);
  EXPECT_EQ(phone.cx(), 1999.5);
  EXPECT_EQ(phone.cy(), 1499.5);
  // 28 mm is what the scene's camera has: that is known better.
  EXPECT_EQ(AssumedCamera(320, 240, 28, Scene()),
            AssumedCamera(320, 240, std::nullopt, Scene()));
}

TEST(AssumedCamera, ElseItIsAUsualOne) {
  for (const auto& absurd : {std::optional<double>(), std::optional(0.0),
                             std::optional(1e9), std::optional(std::nan(""))}) {
    const Camera upright = AssumedCamera(1080, 1920, absurd, Scene());
    EXPECT_NEAR(2 * std::atan(960 / upright.fx()) * 180 / std::numbers::pi,
                67.4, 0.1);
    EXPECT_EQ(upright.cx(), 539.5);
  }
  EXPECT_EQ(AssumedCamera(1, 1, std::nullopt, Scene()).fx(), 0.75);
}

TEST(IsOfAnotherLens, IsWhatExifSaysClearly) {
  // The scene's is 28.4 mm.
  for (const double same : {23.0, 26.0, 28.0, 35.0}) {
    EXPECT_FALSE(IsOfAnotherLens(same, Scene())) << same;
  }
  for (const double other : {13.0, 22.0, 36.0, 77.0}) {
    EXPECT_TRUE(IsOfAnotherLens(other, Scene())) << other;
  }
  for (const auto& absurd : {std::optional<double>(), std::optional(0.0),
                             std::optional(1e9), std::optional(std::nan(""))}) {
    EXPECT_FALSE(IsOfAnotherLens(absurd, Scene()));
  }
}

}  // namespace
}  // namespace treeline::camera
