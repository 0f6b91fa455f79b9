// What a camera saw at one moment, with how it was seen.
#ifndef COMMON_IMAGE_FRAME_H_
#define COMMON_IMAGE_FRAME_H_

#include <optional>

#include "common/camera/rgbd_calibration.h"
#include "common/image/image.h"
#include "common/image/orientation.h"

namespace treeline::image {

// A query or a training frame.
struct Frame {
  // The calibration this frame was taken with. Where depth is absent, only
  // calibration.color and calibration.pose_sensor mean anything. nullopt: use
  // the one that is stored with the scene.
  std::optional<camera::RgbdCalibration> calibration;
  // Nobody says that `calibration`'s colour camera took the picture: its focal
  // length has to be confirmed by what is seen, or there is no answer.
  bool is_camera_assumed = false;
  ColorImage color;
  std::optional<DepthImage> depth;
  Orientation orientation = {};
};

}  // namespace treeline::image

#endif  // COMMON_IMAGE_FRAME_H_
