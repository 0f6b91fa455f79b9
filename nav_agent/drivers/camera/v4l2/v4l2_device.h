// What this driver needs of a video device, so that everything else can be
// tested without one.
#ifndef NAV_AGENT_DRIVERS_CAMERA_V4L2_V4L2_DEVICE_H_
#define NAV_AGENT_DRIVERS_CAMERA_V4L2_V4L2_DEVICE_H_

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "common/base/clock.h"

namespace treeline::v4l2_camera {

enum class V4l2Format { kMjpeg, kYuyv };

struct V4l2Mode {
  // Names that survive replugging lie under /dev/v4l/by-id.
  std::string path = "/dev/video0";
  int width = 640;
  int height = 480;
  int frames_per_s = 30;
  V4l2Format format = V4l2Format::kMjpeg;
};

// An image as the device sent it.
struct V4l2Image {
  V4l2Format format = V4l2Format::kMjpeg;
  int width = 0;
  int height = 0;
  // Of a row, for kYuyv.
  int stride_bytes = 0;
  std::string bytes;
  // By the kernel, when the first byte or the last was received; which, and
  // whether by the monotonic clock, depends on the driver.
  base::MonotonicTime stamp;
  int64_t sequence = 0;
  // The device itself says that something is missing.
  bool corrupt = false;
};

// Streams. Used by one thread.
class V4l2Device {
 public:
  virtual ~V4l2Device() = default;
  // nullopt if none came within `timeout`; UNAVAILABLE once it is gone.
  virtual absl::StatusOr<std::optional<V4l2Image>> Read(
      std::chrono::milliseconds timeout) = 0;
};

class V4l2System {
 public:
  virtual ~V4l2System() = default;
  // NOT_FOUND, PERMISSION_DENIED; INVALID_ARGUMENT: no camera, or it does not
  // know the mode; UNAVAILABLE: another program uses it, or the kernel's own
  // reason.
  virtual absl::StatusOr<std::unique_ptr<V4l2Device>> Open(
      const V4l2Mode& mode) = 0;
};

}  // namespace treeline::v4l2_camera

#endif  // NAV_AGENT_DRIVERS_CAMERA_V4L2_V4L2_DEVICE_H_
