// What this driver needs of OpenNI2, so that everything else can be tested
// without it.
#ifndef NAV_AGENT_DRIVERS_CAMERA_OPENNI_OPENNI_DEVICE_H_
#define NAV_AGENT_DRIVERS_CAMERA_OPENNI_OPENNI_DEVICE_H_

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "common/image/image.h"

namespace treeline::openni_camera {

// One image of one stream.
struct OpenNiImage {
  // By the device's clock, which both streams share.
  std::chrono::microseconds device_time{0};
  base::MonotonicTime arrival;
  // Counts the images of its stream.
  int64_t index = 0;
  std::variant<image::ColorImage, image::DepthImage> image;

  bool is_depth() const {
    return std::holds_alternative<image::DepthImage>(image);
  }
};

// What a device says of one of its cameras.
struct OpenNiFieldOfView {
  int width = 0;
  int height = 0;
  double horizontal_rad = 0;
  double vertical_rad = 0;
};

struct OpenNiMode {
  // As OpenNI names devices; empty: the first one found.
  std::string uri{};
  int width = 640;
  int height = 480;
  int frames_per_s = 30;
  // The device computes depth as the colour camera would see it.
  bool registered = true;
  // The device takes both at the same moment.
  bool synchronized = true;
};

// A device that streams. Images are not mirrored. Used by one thread.
class OpenNiDevice {
 public:
  virtual ~OpenNiDevice() = default;
  virtual OpenNiFieldOfView ColorFieldOfView() const = 0;
  virtual OpenNiFieldOfView DepthFieldOfView() const = 0;
  // Whether depth is registered to colour: not every device can.
  virtual bool registered() const = 0;
  // The next image of either stream; nullopt if none came within `timeout`.
  // UNAVAILABLE once the device is gone.
  virtual absl::StatusOr<std::optional<OpenNiImage>> Read(
      std::chrono::milliseconds timeout) = 0;
};

class OpenNiSystem {
 public:
  virtual ~OpenNiSystem() = default;
  // NOT_FOUND: there is no such device. INVALID_ARGUMENT: it does not know the
  // mode. UNAVAILABLE: it is used by another program, or OpenNI's own reason.
  virtual absl::StatusOr<std::unique_ptr<OpenNiDevice>> Open(
      const OpenNiMode& mode) = 0;
};

}  // namespace treeline::openni_camera

#endif  // NAV_AGENT_DRIVERS_CAMERA_OPENNI_OPENNI_DEVICE_H_
