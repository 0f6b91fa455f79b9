// Pictures whose rows were exposed one after the other, by a camera that turned
// meanwhile, and what they would look like had all been exposed at once.
#ifndef COMMON_IMAGE_ROLLING_SHUTTER_H_
#define COMMON_IMAGE_ROLLING_SHUTTER_H_

#include "common/camera/rgbd_calibration.h"
#include "common/image/frame.h"
#include "common/image/image.h"

namespace treeline::image {

// When row y of h rows is exposed, after the picture's time stamp:
//   offset_s + readout_s * RowShare(y, h)
struct RollingShutter {
  // From the first to the last row (s), in [0, 0.2]; 0: all at once.
  double readout_s = 0;
  // Of the middle row (s), in [-0.1, 0.1]. What time stamps mean differs from
  // driver to driver, and so may the clock of the poses.
  double offset_s = 0;

  bool operator==(const RollingShutter&) const = default;
};

inline constexpr double kMaxReadout_s = 0.2;
inline constexpr double kMaxShutterOffset_s = 0.1;

// -1/2 for the first of `height` rows, 1/2 for the last.
inline double RowShare(double y, int height) {
  return (y + 0.5) / height - 0.5;
}

// How a frame's camera turned about its time stamp.
struct FrameMotion {
  // Of the pose sensor, about its own axes (rad/s): t seconds after the stamp
  // its rotation is world_from_camera * exp(turn_rate * t).
  geometry::Vec3 turn_rate_rad_s;
  // The depth picture's time stamp less the colour picture's (s).
  double depth_delay_s = 0;
};

// The turn rate of either camera of the pair, about its own axes (rad/s).
geometry::Vec3 TurnRateOf(camera::RgbdSensor sensor,
                          const camera::RgbdCalibration& calibration,
                          const FrameMotion& motion);

// What the frame would be if all of it was seen at its time stamp. Depth is
// read row by row like colour. Rotation alone is undone: while rows are read, a
// camera in a hand moves by millimetres. Colour that was outside the picture is
// that of its border, depth is not measured there.
Frame AtTimeStamp(const Frame& frame,
                  const camera::RgbdCalibration& calibration,
                  const RollingShutter& shutter, const FrameMotion& motion);

}  // namespace treeline::image

#endif  // COMMON_IMAGE_ROLLING_SHUTTER_H_
