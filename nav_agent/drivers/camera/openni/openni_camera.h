// RGB-D cameras that OpenNI2 knows: the Asus Xtion and its relatives.
#ifndef NAV_AGENT_DRIVERS_CAMERA_OPENNI_OPENNI_CAMERA_H_
#define NAV_AGENT_DRIVERS_CAMERA_OPENNI_OPENNI_CAMERA_H_

#include <chrono>
#include <memory>
#include <optional>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "common/camera/rgbd_calibration.h"
#include "nav_agent/drivers/camera/device_clock.h"
#include "nav_agent/drivers/camera/live_camera.h"
#include "nav_agent/drivers/camera/openni/openni_device.h"

namespace treeline::openni_camera {

struct OpenNiCameraOptions {
  OpenNiMode mode{};
  // nullopt: pinholes after the device's field of view, and for depth that is
  // not registered 25 mm between the cameras, as the Xtion has them. Good to a
  // few pixels; measure your own for more.
  std::optional<camera::RgbdCalibration> calibration{};
  // Colour and depth that were taken further apart do not belong together; half
  // a frame interval, where they are not synchronized. (0, 0.1]

  double max_pair_difference_s = 0.017;
  // From the middle of the exposure to the quickest arrival. [0, 1]. Not known
  // to us for any device; see docs/reference/cameras.md.
  double latency_s = 0.0;
  camera_driver::LiveCameraOptions live{};

  absl::Status Validate() const;
};

// Puts colour and depth together.
class OpenNiCameraDevice final : public camera_driver::CameraDevice {
 public:
  // Valid options.
  OpenNiCameraDevice(const OpenNiCameraOptions& options,
                     std::unique_ptr<OpenNiDevice> device);

  camera::RgbdCalibration Calibration() const override { return calibration_; }
  // DATA_LOSS for an image that found no partner.
  absl::StatusOr<std::optional<core::RgbdFrame>> Read(
      std::chrono::milliseconds timeout) override;

 private:
  absl::StatusOr<std::optional<core::RgbdFrame>> Pair(OpenNiImage image);

  const OpenNiCameraOptions options_;
  const std::unique_ptr<OpenNiDevice> device_;
  const camera::RgbdCalibration calibration_;
  camera_driver::DeviceClock clock_;
  // Waits for its partner.
  std::optional<OpenNiImage> waiting_;
};

// The calibration of a device that nobody has calibrated: see
// OpenNiCameraOptions.
absl::StatusOr<camera::RgbdCalibration> CalibrationByFieldOfView(
    const OpenNiFieldOfView& color, const OpenNiFieldOfView& depth,
    bool registered);

// Begins to look for the device. `system` is OpenNI2 (MakeOpenNi2) or a fake.
absl::StatusOr<std::unique_ptr<core::RgbdCamera>> MakeOpenNiCamera(
    const OpenNiCameraOptions& options, std::unique_ptr<OpenNiSystem> system,
    const base::Clock& clock);

}  // namespace treeline::openni_camera

#endif  // NAV_AGENT_DRIVERS_CAMERA_OPENNI_OPENNI_CAMERA_H_
