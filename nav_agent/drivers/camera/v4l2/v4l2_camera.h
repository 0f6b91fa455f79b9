// Cameras without depth: any USB camera that the kernel knows.
//
// Straight through Video4Linux2 rather than OpenCV's videoio: that gives the
// kernel's own time stamps, time limits on reading, and notice of unplugging
// and of broken frames, which videoio hides; and the agent need not link the
// hundred libraries behind videoio for 300 lines.
#ifndef NAV_AGENT_DRIVERS_CAMERA_V4L2_V4L2_CAMERA_H_
#define NAV_AGENT_DRIVERS_CAMERA_V4L2_V4L2_CAMERA_H_

#include <chrono>
#include <memory>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "common/camera/rgbd_calibration.h"
#include "common/image/image.h"
#include "nav_agent/drivers/camera/live_camera.h"
#include "nav_agent/drivers/camera/v4l2/v4l2_device.h"

namespace treeline::v4l2_camera {

struct V4l2CameraOptions {
  V4l2Mode mode{};
  // Of `color`, for images of this mode's size. There is no useful default for
  // a camera that nobody knows.
  camera::RgbdCalibration calibration{};
  // From the middle of the exposure to the kernel's stamp. [0, 1]
  double latency_s = 0.0;
  camera_driver::LiveCameraOptions live{};

  absl::Status Validate() const;
};

// YCbCr 4:2:2 in the order Y0 Cb Y1 Cr, full range (JFIF, as USB cameras
// send). INVALID_ARGUMENT if the bytes are fewer than the size says, or the
// width is odd.
absl::StatusOr<image::ColorImage> ColorFromYuyv(const V4l2Image& image);
// Of either format. DATA_LOSS for what is corrupt.
absl::StatusOr<image::ColorImage> DecodeV4l2(const V4l2Image& image);

// Begins to look for the camera. Its frames have no depth.
absl::StatusOr<std::unique_ptr<core::RgbdCamera>> MakeV4l2Camera(
    const V4l2CameraOptions& options, std::unique_ptr<V4l2System> system,
    const base::Clock& clock);

}  // namespace treeline::v4l2_camera

#endif  // NAV_AGENT_DRIVERS_CAMERA_V4L2_V4L2_CAMERA_H_
