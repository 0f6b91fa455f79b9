#include "common/image/quarter_turn.h"

#include <string>
#include <vector>

#include "common/base/random.h"
#include "common/image/depth_registration.h"
#include "gtest/gtest.h"

namespace treeline::image {
namespace {

using camera::Camera;
using geometry::Rigid3;
using geometry::Vec3;

constexpr int kWidth = 17;
constexpr int kHeight = 11;

// Every model, bent in every way that it can be, and with centres that are not
// those of the image.
std::vector<Camera> Cameras(int width, int height) {
  std::vector<Camera> cameras;
  for (const char* text :
       {"SIMPLE_PINHOLE,15,8.3,4.1", "PINHOLE,15,14,8.3,4.1",
        "SIMPLE_RADIAL,15,8.3,4.1,-0.1", "RADIAL,15,8.3,4.1,-0.1,0.02",
        "OPENCV,15,14,8.3,4.1,-0.1,0.02,0.03,-0.05",
        "FULL_OPENCV,15,14,8.3,4.1,-0.1,0.02,0.03,-0.05,0.01,0.02,0.03,0.01",
        "OPENCV_FISHEYE,15,14,8.3,4.1,-0.1,0.02,0.03,-0.01",
        "FOV,15,14,8.3,4.1,0.9", "SIMPLE_RADIAL_FISHEYE,15,8.3,4.1,-0.1",
        "RADIAL_FISHEYE,15,8.3,4.1,-0.1,0.02",
        "THIN_PRISM_FISHEYE,15,14,8.3,4.1,-0.1,0.02,0.03,-0.05,0.01,0.02,0.04,"
        "-0.06"}) {
    cameras.push_back(Camera::Parse(text, width, height).value());
  }
  return cameras;
}

ColorImage SomeColor(int width, int height) {
  base::Random random(/*seed=*/1, /*stream=*/0);
  ColorImage image{.width = width, .height = height, .rgb = {}};
  for (int i = 0; i < 3 * width * height; ++i) {
    image.rgb.push_back(static_cast<uint8_t>(random.NextBelow(256)));
  }
  return image;
}

DepthImage SomeDepth(int width, int height) {
  DepthImage image{
      .width = width, .height = height, .values = {}, .unit_m = 0.0005};
  for (int i = 0; i < width * height; ++i) {
    image.values.push_back(static_cast<uint16_t>(3000 + 7 * i));
  }
  return image;
}

size_t IndexOf(camera::Pixel pixel, int width) {
  return static_cast<size_t>(pixel.y) * static_cast<size_t>(width) +
         static_cast<size_t>(pixel.x);
}

void ExpectNear(Vec3 a, Vec3 b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST(QuarterTurnTest, ClockwiseBringsTheLeftSideToTheTop) {
  //  1 2 3    4 1
  //  4 5 6    5 2
  //           6 3
  const DepthImage image{.width = 3, .height = 2, .values = {1, 2, 3, 4, 5, 6}};
  const DepthImage turned = Turned(image, QuarterTurn::kClockwise);
  EXPECT_EQ(turned.width, 2);
  EXPECT_EQ(turned.height, 3);
  EXPECT_EQ(turned.values, (std::vector<uint16_t>{4, 1, 5, 2, 6, 3}));
  EXPECT_EQ(Turned(image, QuarterTurn::kHalf).values,
            (std::vector<uint16_t>{6, 5, 4, 3, 2, 1}));
  EXPECT_EQ(Turned(image, QuarterTurn::kCounterclockwise).values,
            (std::vector<uint16_t>{3, 6, 2, 5, 1, 4}));
}

TEST(QuarterTurnTest, EveryPixelGoesWhereItSays) {
  const ColorImage color = SomeColor(kWidth, kHeight);
  const DepthImage depth = SomeDepth(kWidth, kHeight);
  for (const QuarterTurn turn : kQuarterTurns) {
    const ColorImage turned = Turned(color, turn);
    const DepthImage turned_depth = Turned(depth, turn);
    EXPECT_EQ(turned_depth.unit_m, depth.unit_m);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const camera::Pixel before{static_cast<double>(x),
                                   static_cast<double>(y)};
        const camera::Pixel after = Turned(before, kWidth, kHeight, turn);
        const size_t from = IndexOf(before, kWidth);
        const size_t to = IndexOf(after, turned.width);
        for (size_t c = 0; c < 3; ++c) {
          ASSERT_EQ(turned.rgb[3 * to + c], color.rgb[3 * from + c]);
        }
        ASSERT_EQ(turned_depth.values[to], depth.values[from]);
      }
    }
  }
}

TEST(QuarterTurnTest, TheInverseUndoesIt) {
  const ColorImage color = SomeColor(kWidth, kHeight);
  for (const QuarterTurn turn : kQuarterTurns) {
    const ColorImage back = Turned(Turned(color, turn), Inverse(turn));
    EXPECT_EQ(back.width, kWidth);
    EXPECT_EQ(back.rgb, color.rgb);
    for (const Camera& camera : Cameras(kWidth, kHeight)) {
      const Camera again = Turned(Turned(camera, turn), Inverse(turn));
      EXPECT_EQ(again.width(), camera.width());
      for (size_t i = 0; i < Camera::kMaxParameters; ++i) {
        EXPECT_NEAR(again.parameters()[i], camera.parameters()[i], 1e-12);
      }
    }
  }
}

TEST(QuarterTurnTest, EveryCameraModelSeesTheTurnedPointInTheTurnedPixel) {
  base::Random random(/*seed=*/2, /*stream=*/0);
  for (const Camera& camera : Cameras(kWidth, kHeight)) {
    for (const QuarterTurn turn : kQuarterTurns) {
      const Camera turned = Turned(camera, turn);
      for (int i = 0; i < 20; ++i) {
        const Vec3 point{random.NextUnit() - 0.5, random.NextUnit() - 0.5,
                         1 + random.NextUnit()};
        const camera::Pixel expected =
            Turned(camera.Project(point), kWidth, kHeight, turn);
        const camera::Pixel seen =
            turned.Project(TurnedFromCamera(turn) * point);
        EXPECT_NEAR(seen.x, expected.x, 1e-9) << camera.ToString();
        EXPECT_NEAR(seen.y, expected.y, 1e-9) << camera.ToString();
      }
    }
  }
}

// A pair of cameras that look in different directions and at different sizes.
Frame SomeFrame() {
  Frame frame;
  frame.color = SomeColor(kWidth, kHeight);
  frame.depth = SomeDepth(13, 9);
  frame.calibration = camera::RgbdCalibration{
      .color = Camera::Parse("OPENCV,15,14,8.3,4.1,-0.1,0.02,0.03,-0.05",
                             kWidth, kHeight)
                   .value(),
      .depth = Camera::Parse("PINHOLE,11,12,6.2,3.9", 13, 9).value(),
      .color_from_depth = {geometry::Rotation3::FromAxisAngle({0.02, 0.1, 0.2}),
                           {0.3, -0.1, 0.05}},
      .depth_scale = 1.02,
      .pose_sensor = camera::RgbdSensor::kDepth};
  return frame;
}

TEST(QuarterTurnTest, DepthIsRegisteredToTheTurnedColourAsBefore) {
  const Frame frame = SomeFrame();
  const std::vector<Vec3> before =
      DepthRegistrar(*frame.calibration).PointsInColor(*frame.depth);
  for (const QuarterTurn turn : kQuarterTurns) {
    const Frame turned = Turned(frame, turn);
    const std::vector<Vec3> after =
        DepthRegistrar(*turned.calibration).PointsInColor(*turned.depth);
    int measured = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const camera::Pixel pixel{static_cast<double>(x),
                                  static_cast<double>(y)};
        const Vec3 point = before[IndexOf(pixel, kWidth)];
        measured += point.z > 0;
        ExpectNear(after[IndexOf(Turned(pixel, kWidth, kHeight, turn),
                                 turned.color.width)],
                   TurnedFromCamera(turn) * point, 1e-9);
      }
    }
    EXPECT_GT(measured, 20);
  }
}

TEST(QuarterTurnTest, APoseOfTheTurnedFrameIsOneOfTheFrame) {
  const Frame frame = SomeFrame();
  const Rigid3 world_from_color{
      geometry::Rotation3::FromAxisAngle({0.4, -0.3, 0.2}), {1, 2, 3}};
  for (const QuarterTurn turn : kQuarterTurns) {
    const Frame turned = Turned(frame, turn);
    const Rigid3 turned_from_camera{TurnedFromCamera(turn), {}};
    const Rigid3 world_from_turned =
        world_from_color * turned_from_camera.Inverse();
    // Of either sensor.
    const Rigid3 world_from_turned_depth =
        camera::PoseOfSensor(world_from_turned, camera::RgbdSensor::kColor,
                             camera::RgbdSensor::kDepth, *turned.calibration);
    const geometry::PoseError error = geometry::ErrorBetween(
        world_from_turned_depth * turned_from_camera,
        camera::PoseOfSensor(world_from_color, camera::RgbdSensor::kColor,
                             camera::RgbdSensor::kDepth, *frame.calibration));
    EXPECT_NEAR(error.translation_m, 0, 1e-12);
    EXPECT_NEAR(error.rotation_rad, 0, 1e-7);
    const Vec3 point_in_world = world_from_color * Vec3{0.1, -0.2, 2};
    const camera::Pixel seen = turned.calibration->color.Project(
        world_from_turned.Inverse() * point_in_world);
    const camera::Pixel expected =
        Turned(frame.calibration->color.Project({0.1, -0.2, 2}), kWidth,
               kHeight, turn);
    EXPECT_NEAR(seen.x, expected.x, 1e-9);
    EXPECT_NEAR(seen.y, expected.y, 1e-9);
  }
}

TEST(QuarterTurnTest, TheFrameKnowsWhatIsLeftOfItsTurn) {
  Frame frame = SomeFrame();
  frame.orientation = {QuarterTurn::kClockwise, true};
  EXPECT_EQ(Turned(frame, QuarterTurn::kClockwise).orientation,
            (Orientation{QuarterTurn::kNone, true}));
  EXPECT_EQ(Turned(frame, QuarterTurn::kHalf).orientation,
            (Orientation{QuarterTurn::kCounterclockwise, true}));
  EXPECT_EQ(Turned(frame, QuarterTurn::kNone).calibration, frame.calibration);
}

}  // namespace
}  // namespace treeline::image
