#include "nav_agent/drivers/camera/v4l2/v4l2.h"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/descriptor.h"
#include "common/base/status_macros.h"

namespace treeline::v4l2_camera {
namespace {

constexpr uint32_t kBuffers = 4;

absl::Status SystemFailure(absl::string_view what, int error) {
  absl::StatusCode code = absl::StatusCode::kUnavailable;
  if (error == ENOENT || error == ENODEV || error == ENXIO) {
    code = absl::StatusCode::kNotFound;
  } else if (error == EACCES || error == EPERM) {
    code = absl::StatusCode::kPermissionDenied;
  }
  return absl::Status(
      code,
      absl::StrCat(what, ": ", std::strerror(error),
                   error == EACCES ? " (is the user in group video?)" : ""));
}

int Control(int fd, unsigned long request, void* argument) {
  int result = 0;
  do {
    result = ioctl(fd, request, argument);
  } while (result < 0 && errno == EINTR);
  return result;
}

uint32_t FourCc(V4l2Format format) {
  return format == V4l2Format::kMjpeg ? V4L2_PIX_FMT_MJPEG : V4L2_PIX_FMT_YUYV;
}

v4l2_buffer CaptureBuffer() {
  v4l2_buffer buffer = {};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  return buffer;
}

class Device final : public V4l2Device {
 public:
  Device(const V4l2Mode& mode, int fd) : mode_(mode), fd_(fd) {}
  ~Device() override {
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    Control(fd_.get(), VIDIOC_STREAMOFF, &type);
    for (const auto& [start, length] : mapped_) munmap(start, length);
  }

  absl::Status Begin() {
    v4l2_capability capability = {};
    if (Control(fd_.get(), VIDIOC_QUERYCAP, &capability) < 0) {
      return absl::InvalidArgumentError(
          absl::StrCat(mode_.path, " is no video device"));
    }
    const uint32_t can = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0
                             ? capability.device_caps
                             : capability.capabilities;
    if ((can & V4L2_CAP_VIDEO_CAPTURE) == 0 ||
        (can & V4L2_CAP_STREAMING) == 0) {
      return absl::InvalidArgumentError(
          absl::StrCat(mode_.path,
                       " is not a camera; many have a second device, try the "
                       "one before"));
    }
    TL_RETURN_IF_ERROR(SetFormat());
    TL_RETURN_IF_ERROR(MapBuffers());
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (Control(fd_.get(), VIDIOC_STREAMON, &type) < 0) {
      return SystemFailure(absl::StrCat(mode_.path, " does not stream"), errno);
    }
    return absl::OkStatus();
  }

  absl::StatusOr<std::optional<V4l2Image>> Read(
      std::chrono::milliseconds timeout) override {
    pollfd waiting = {.fd = fd_.get(), .events = POLLIN, .revents = 0};
    const int ready = poll(&waiting, 1, static_cast<int>(timeout.count()));
    if (ready == 0 || (ready < 0 && errno == EINTR)) return std::nullopt;
    if (ready < 0) return Gone(errno);
    v4l2_buffer buffer = CaptureBuffer();
    if (Control(fd_.get(), VIDIOC_DQBUF, &buffer) < 0) {
      if (errno == EAGAIN) return std::nullopt;
      return Gone(errno);
    }
    if (buffer.index >= mapped_.size()) return Gone(EINVAL);
    V4l2Image image = ImageOf(buffer);
    if (Control(fd_.get(), VIDIOC_QBUF, &buffer) < 0) return Gone(errno);
    return image;
  }

 private:
  struct Mapping {
    void* start = nullptr;
    size_t length = 0;
  };

  absl::Status Gone(int error) const {
    return absl::UnavailableError(absl::StrCat(
        mode_.path, " is gone (unplugged?): ", std::strerror(error)));
  }

  absl::Status SetFormat() {
    v4l2_format format = {};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    format.fmt.pix.width = static_cast<uint32_t>(mode_.width);
    format.fmt.pix.height = static_cast<uint32_t>(mode_.height);
    format.fmt.pix.pixelformat = FourCc(mode_.format);
    format.fmt.pix.field = V4L2_FIELD_NONE;
    if (Control(fd_.get(), VIDIOC_S_FMT, &format) < 0) {
      return SystemFailure(
          absl::StrCat(mode_.path, " is in use, or takes no format"), errno);
    }
    // The kernel answers with what is nearest.
    if (format.fmt.pix.width != static_cast<uint32_t>(mode_.width) ||
        format.fmt.pix.height != static_cast<uint32_t>(mode_.height) ||
        format.fmt.pix.pixelformat != FourCc(mode_.format)) {
      return absl::InvalidArgumentError(absl::StrCat(
          mode_.path, " does not know ", mode_.width, " x ", mode_.height,
          mode_.format == V4l2Format::kMjpeg ? " MJPEG" : " YUYV",
          "; `v4l2-ctl --list-formats-ext` tells what it knows"));
    }
    stride_bytes_ = static_cast<int>(format.fmt.pix.bytesperline);
    v4l2_streamparm rate = {};
    rate.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    rate.parm.capture.timeperframe.numerator = 1;
    rate.parm.capture.timeperframe.denominator =
        static_cast<uint32_t>(mode_.frames_per_s);
    // A camera that keeps its own rate is fine: frames carry their stamps.
    Control(fd_.get(), VIDIOC_S_PARM, &rate);
    return absl::OkStatus();
  }

  absl::Status MapBuffers() {
    v4l2_requestbuffers request = {};
    request.count = kBuffers;
    request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    request.memory = V4L2_MEMORY_MMAP;
    if (Control(fd_.get(), VIDIOC_REQBUFS, &request) < 0) {
      return SystemFailure(absl::StrCat(mode_.path, " has no buffers"), errno);
    }
    for (uint32_t i = 0; i < request.count; ++i) {
      v4l2_buffer buffer = CaptureBuffer();
      buffer.index = i;
      if (Control(fd_.get(), VIDIOC_QUERYBUF, &buffer) < 0) return Gone(errno);
      void* start = mmap(nullptr, buffer.length, PROT_READ | PROT_WRITE,
                         MAP_SHARED, fd_.get(), buffer.m.offset);
      if (start == MAP_FAILED) return Gone(errno);
      mapped_.push_back({.start = start, .length = buffer.length});
      if (Control(fd_.get(), VIDIOC_QBUF, &buffer) < 0) return Gone(errno);
    }
    return absl::OkStatus();
  }

  V4l2Image ImageOf(const v4l2_buffer& buffer) const {
    V4l2Image image;
    image.format = mode_.format;
    image.width = mode_.width;
    image.height = mode_.height;
    image.stride_bytes = stride_bytes_;
    const Mapping& mapping = mapped_[buffer.index];
    image.bytes.assign(static_cast<const char*>(mapping.start),
                       std::min<size_t>(buffer.bytesused, mapping.length));
    image.sequence = buffer.sequence;
    image.corrupt = (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0;
    const bool monotonic = (buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) ==
                           V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
    // The steady clock is CLOCK_MONOTONIC on Linux.
    image.stamp = monotonic
                      ? base::MonotonicTime(
                            std::chrono::seconds(buffer.timestamp.tv_sec) +
                            std::chrono::microseconds(buffer.timestamp.tv_usec))
                      : std::chrono::steady_clock::now();
    return image;
  }

  const V4l2Mode mode_;
  const base::Descriptor fd_;
  int stride_bytes_ = 0;
  std::vector<Mapping> mapped_;
};

class System final : public V4l2System {
 public:
  absl::StatusOr<std::unique_ptr<V4l2Device>> Open(
      const V4l2Mode& mode) override {
    const int fd = open(mode.path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    if (fd < 0) {
      return SystemFailure(absl::StrCat("cannot open ", mode.path), errno);
    }
    auto device = std::make_unique<Device>(mode, fd);
    TL_RETURN_IF_ERROR(device->Begin());
    return device;
  }
};

}  // namespace

std::unique_ptr<V4l2System> MakeV4l2() { return std::make_unique<System>(); }

}  // namespace treeline::v4l2_camera
