#include "common/image/rolling_shutter.h"

#include <gtest/gtest.h>

#include <cmath>

namespace treeline::image {
namespace {

constexpr double kPinhole[] = {200, 200, 79.5, 59.5};

camera::RgbdCalibration Calibration() {
  camera::RgbdCalibration calibration;
  calibration.color = calibration.depth = *camera::Camera::Create(
      camera::CameraModel::kPinhole, 160, 120, kPinhole, 4);
  return calibration;
}

// A world of directions: brightness is smooth over them.
double Brightness(geometry::Vec3 direction) {
  return 128 + 60 * std::sin(25 * direction.x / direction.z) +
         50 * std::cos(27 * direction.y / direction.z);
}

// A plane at 2 m across the view at the time stamp.
constexpr double kPlane_m = 2;

// What rolling rows see of it, and of the plane, of a camera that turns.
Frame Seen(const camera::RgbdCalibration& calibration,
           const RollingShutter& shutter, const FrameMotion& motion) {
  const camera::Camera& camera = calibration.color;
  Frame frame;
  frame.color = {camera.width(), camera.height(), {}};
  frame.depth = {camera.width(), camera.height(), {}, 0.0002};
  for (int y = 0; y < camera.height(); ++y) {
    for (int x = 0; x < camera.width(); ++x) {
      const auto ray = camera.Unproject({1.0 * x, 1.0 * y});
      const auto at_stamp = [&](double delay_s) {
        return geometry::Rotation3::FromAxisAngle(delay_s *
                                                  motion.turn_rate_rad_s) *
               geometry::Vec3{ray->x, ray->y, 1};
      };
      const double row_s =
          shutter.offset_s + shutter.readout_s * RowShare(y, camera.height());
      for (int c = 0; c < 3; ++c) {
        frame.color.rgb.push_back(
            static_cast<uint8_t>(std::lround(Brightness(at_stamp(row_s)))));
      }
      // z of the point of the plane on this ray, in the camera as it is then.
      const double z = kPlane_m / at_stamp(row_s + motion.depth_delay_s).z;
      frame.depth->values.push_back(
          static_cast<uint16_t>(std::lround(z / frame.depth->unit_m)));
    }
  }
  return frame;
}

TEST(AtTimeStamp, UndoesTheTurnOfACameraWhoseRowsWereReadOneByOne) {
  const camera::RgbdCalibration calibration = Calibration();
  const RollingShutter shutter{.readout_s = 0.03, .offset_s = -0.005};
  const FrameMotion motion{.turn_rate_rad_s = {0.7, -0.5, 1.5},
                           .depth_delay_s = 0.015};
  const Frame still = Seen(calibration, {}, {});
  const Frame seen = Seen(calibration, shutter, motion);
  const Frame undone = AtTimeStamp(seen, calibration, shutter, motion);
  double before = 0;
  double after = 0;
  // Of what stays in the picture.
  constexpr int kBorder_px = 12;
  for (int y = kBorder_px; y < 120 - kBorder_px; ++y) {
    for (int x = kBorder_px; x < 160 - kBorder_px; ++x) {
      const size_t i = static_cast<size_t>(y * 160 + x);
      const auto difference = [&](const Frame& frame) {
        return std::abs(1.0 * frame.color.rgb[3 * i] - still.color.rgb[3 * i]);
      };
      before = std::max(before, difference(seen));
      after = std::max(after, difference(undone));
      // The plane, to half a pixel's worth of its slant (2 m * 0.03 / 200) and
      // the unit.
      EXPECT_NEAR(undone.depth->values[i] * undone.depth->unit_m, kPlane_m,
                  0.0007);
    }
  }
  EXPECT_GT(before, 15);
  // Rounding twice, and what is between pixels.
  EXPECT_LE(after, 2);
}

TEST(AtTimeStamp, LeavesAStandingCameraAlone) {
  const camera::RgbdCalibration calibration = Calibration();
  const Frame seen = Seen(calibration, {.readout_s = 0.03}, {});
  const Frame undone =
      AtTimeStamp(seen, calibration, {.readout_s = 0.03}, FrameMotion{});
  EXPECT_EQ(undone.color.rgb, seen.color.rgb);
  EXPECT_EQ(undone.depth->values, seen.depth->values);
}

TEST(AtTimeStamp, MeasuresNoDepthOutsideThePicture) {
  const camera::RgbdCalibration calibration = Calibration();
  const FrameMotion motion{.turn_rate_rad_s = {0, 1, 0}};
  const RollingShutter shutter{.offset_s = 0.1};
  const Frame undone = AtTimeStamp(Seen(calibration, shutter, motion),
                                   calibration, shutter, motion);
  // Turned to the right by 0.1 rad, 20 px at the left are not seen.
  EXPECT_EQ(undone.depth->values[60 * 160 + 5], 0);
  EXPECT_NE(undone.depth->values[60 * 160 + 40], 0);
}

// To a camera that is turned by a radian such a lens shows what was at an edge
// 10^9 px away.
TEST(AtTimeStamp, ALensThatSendsRaysAnywhereLeavesThemWhereTheyAre) {
  camera::RgbdCalibration calibration = Calibration();
  const Frame seen = Seen(calibration, {}, {});
  calibration.color =
      camera::Camera::Parse("FULL_OPENCV,100,100,80,60,0,0,0,0,100,0,0,0", 160,
                            120)
          .value();
  calibration.depth = calibration.color;
  const Frame undone = AtTimeStamp(seen, calibration, {.offset_s = 0.1},
                                   {.turn_rate_rad_s = {0, 10, 0}});
  const auto left_alone = [&](size_t x) {
    const size_t i = 60 * 160 + x;
    return undone.color.rgb[3 * i] == seen.color.rgb[3 * i] &&
           undone.depth->values[i] == seen.depth->values[i];
  };
  EXPECT_NE(left_alone(0), left_alone(159));
}

}  // namespace
}  // namespace treeline::image
