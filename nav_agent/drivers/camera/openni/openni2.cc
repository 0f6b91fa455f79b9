#include "nav_agent/drivers/camera/openni/openni2.h"

#include <OpenNI.h>

#include <atomic>
#include <cstddef>
#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline::openni_camera {
namespace {

constexpr double kMillimetre_m = 0.001;
constexpr double kTenthOfMillimetre_m = 0.0001;

absl::Status Failure(absl::StatusCode code, absl::string_view what) {
  return absl::Status(
      code, absl::StrCat(what, ": ", openni::OpenNI::getExtendedError()));
}

absl::Status Check(openni::Status status, absl::string_view what) {
  if (status == openni::STATUS_OK) return absl::OkStatus();
  return Failure(absl::StatusCode::kUnavailable, what);
}

// Tells of devices that were pulled out.
class Disconnection final : public openni::OpenNI::DeviceDisconnectedListener {
 public:
  explicit Disconnection(std::string uri) : uri_(std::move(uri)) {
    openni::OpenNI::addDeviceDisconnectedListener(this);
  }
  ~Disconnection() override {
    openni::OpenNI::removeDeviceDisconnectedListener(this);
  }
  void onDeviceDisconnected(const openni::DeviceInfo* info) override {
    if (info != nullptr && uri_ == info->getUri()) happened_ = true;
  }
  bool happened() const { return happened_; }

 private:
  const std::string uri_;
  std::atomic<bool> happened_{false};
};

template <typename Pixel>
void CopyRows(const openni::VideoFrameRef& frame, size_t values_per_row,
              std::vector<Pixel>& values) {
  const auto rows = static_cast<size_t>(frame.getHeight());
  const auto* from = static_cast<const std::byte*>(frame.getData());
  values.resize(rows * values_per_row);
  for (size_t y = 0; y < rows; ++y) {
    std::memcpy(values.data() + y * values_per_row,
                from + y * static_cast<size_t>(frame.getStrideInBytes()),
                values_per_row * sizeof(Pixel));
  }
}

class Device final : public OpenNiDevice {
 public:
  explicit Device(const base::Clock& clock) : clock_(clock) {}
  ~Device() override {
    for (openni::VideoStream* stream : {&color_, &depth_}) {
      stream->stop();
      stream->destroy();
    }
    device_.close();
  }

  absl::Status Open(const OpenNiMode& mode) {
    const char* uri = mode.uri.empty() ? openni::ANY_DEVICE : mode.uri.c_str();
    if (device_.open(uri) != openni::STATUS_OK) {
      return Failure(
          absl::StatusCode::kNotFound,
          "no OpenNI camera could be opened; is it plugged in, may this user "
          "open it (/dev/bus/usb), and is no other program using it?");
    }
    disconnection_.emplace(device_.getDeviceInfo().getUri());
    TL_RETURN_IF_ERROR(OpenStream(openni::SENSOR_COLOR,
                                  openni::PIXEL_FORMAT_RGB888, mode, color_));
    TL_RETURN_IF_ERROR(OpenStream(
        openni::SENSOR_DEPTH, openni::PIXEL_FORMAT_DEPTH_1_MM, mode, depth_));
    const auto registration = mode.registered
                                  ? openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR
                                  : openni::IMAGE_REGISTRATION_OFF;
    registered_ =
        mode.registered &&
        device_.isImageRegistrationModeSupported(registration) &&
        device_.setImageRegistrationMode(registration) == openni::STATUS_OK;
    if (!mode.registered) {
      device_.setImageRegistrationMode(registration);
    }
    // Where this is refused, pairing by time still does its part.
    device_.setDepthColorSyncEnabled(mode.synchronized);
    TL_RETURN_IF_ERROR(Check(color_.start(), "colour does not start"));
    return Check(depth_.start(), "depth does not start");
  }

  OpenNiFieldOfView ColorFieldOfView() const override {
    return FieldOfView(color_);
  }
  OpenNiFieldOfView DepthFieldOfView() const override {
    return FieldOfView(depth_);
  }
  bool registered() const override { return registered_; }

  absl::StatusOr<std::optional<OpenNiImage>> Read(
      std::chrono::milliseconds timeout) override {
    if (disconnection_->happened()) {
      return absl::UnavailableError("the camera has been unplugged");
    }
    openni::VideoStream* streams[] = {&color_, &depth_};
    int ready = -1;
    const openni::Status status = openni::OpenNI::waitForAnyStream(
        streams, 2, &ready, static_cast<int>(timeout.count()));
    if (status == openni::STATUS_TIME_OUT) return std::nullopt;
    TL_RETURN_IF_ERROR(Check(status, "the camera cannot be read"));
    openni::VideoFrameRef frame;
    TL_RETURN_IF_ERROR(
        Check(streams[ready]->readFrame(&frame), "the camera cannot be read"));
    return ToImage(frame);
  }

 private:
  absl::Status OpenStream(openni::SensorType sensor, openni::PixelFormat format,
                          const OpenNiMode& mode, openni::VideoStream& stream) {
    const char* name = sensor == openni::SENSOR_DEPTH ? "depth" : "colour";
    if (stream.create(device_, sensor) != openni::STATUS_OK) {
      return Failure(absl::StatusCode::kInvalidArgument,
                     absl::StrCat("the camera has no ", name));
    }
    openni::VideoMode video_mode;
    video_mode.setPixelFormat(format);
    video_mode.setResolution(mode.width, mode.height);
    video_mode.setFps(mode.frames_per_s);
    if (stream.setVideoMode(video_mode) != openni::STATUS_OK) {
      return Failure(
          absl::StatusCode::kInvalidArgument,
          absl::StrCat("the camera has no ", name, " of ", mode.width, " x ",
                       mode.height, " at ", mode.frames_per_s, " Hz"));
    }
    // OpenNI mirrors by default.
    return Check(stream.setMirroringEnabled(false),
                 absl::StrCat(name, " cannot be had unmirrored"));
  }

  static OpenNiFieldOfView FieldOfView(const openni::VideoStream& stream) {
    const openni::VideoMode mode = stream.getVideoMode();
    return {.width = mode.getResolutionX(),
            .height = mode.getResolutionY(),
            .horizontal_rad = stream.getHorizontalFieldOfView(),
            .vertical_rad = stream.getVerticalFieldOfView()};
  }

  std::optional<OpenNiImage> ToImage(const openni::VideoFrameRef& frame) {
    if (!frame.isValid()) return std::nullopt;
    OpenNiImage image;
    image.device_time = std::chrono::microseconds(frame.getTimestamp());
    image.arrival = clock_.Now();
    image.index = frame.getFrameIndex();
    const auto width = static_cast<size_t>(frame.getWidth());
    if (frame.getSensorType() == openni::SENSOR_DEPTH) {
      image::DepthImage depth;
      depth.width = frame.getWidth();
      depth.height = frame.getHeight();
      depth.unit_m = frame.getVideoMode().getPixelFormat() ==
                             openni::PIXEL_FORMAT_DEPTH_100_UM
                         ? kTenthOfMillimetre_m
                         : kMillimetre_m;
      CopyRows(frame, width, depth.values);
      image.image = std::move(depth);
    } else {
      image::ColorImage color;
      color.width = frame.getWidth();
      color.height = frame.getHeight();
      CopyRows(frame, 3 * width, color.rgb);
      image.image = std::move(color);
    }
    return image;
  }

  const base::Clock& clock_;
  openni::Device device_;
  openni::VideoStream color_;
  openni::VideoStream depth_;
  std::optional<Disconnection> disconnection_;
  bool registered_ = false;
};

class System final : public OpenNiSystem {
 public:
  explicit System(const base::Clock& clock) : clock_(clock) {}
  ~System() override {
    if (initialized_) openni::OpenNI::shutdown();
  }

  absl::StatusOr<std::unique_ptr<OpenNiDevice>> Open(
      const OpenNiMode& mode) override {
    if (!initialized_) {
      TL_RETURN_IF_ERROR(
          Check(openni::OpenNI::initialize(), "OpenNI2 does not start"));
      initialized_ = true;
    }
    auto device = std::make_unique<Device>(clock_);
    TL_RETURN_IF_ERROR(device->Open(mode));
    return device;
  }

 private:
  const base::Clock& clock_;
  bool initialized_ = false;
};

}  // namespace

std::unique_ptr<OpenNiSystem> MakeOpenNi2(const base::Clock& clock) {
  return std::make_unique<System>(clock);
}

}  // namespace treeline::openni_camera
