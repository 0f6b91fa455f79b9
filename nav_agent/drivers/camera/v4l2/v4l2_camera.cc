#include "nav_agent/drivers/camera/v4l2/v4l2_camera.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"

namespace treeline::v4l2_camera {
namespace {

uint8_t Byte(double value) {
  return static_cast<uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

// ITU-R BT.601, full range.
void PutRgb(double y, double cb, double cr, uint8_t* rgb) {
  rgb[0] = Byte(y + 1.402 * cr);
  rgb[1] = Byte(y - 0.344136 * cb - 0.714136 * cr);
  rgb[2] = Byte(y + 1.772 * cb);
}

class Device final : public camera_driver::CameraDevice {
 public:
  Device(const V4l2CameraOptions& options, std::unique_ptr<V4l2Device> device)
      : options_(options), device_(std::move(device)) {}

  camera::RgbdCalibration Calibration() const override {
    return options_.calibration;
  }

  absl::StatusOr<std::optional<core::RgbdFrame>> Read(
      std::chrono::milliseconds timeout) override {
    TL_ASSIGN_OR_RETURN(const std::optional<V4l2Image> image,
                        device_->Read(timeout));
    if (!image) return std::nullopt;
    core::RgbdFrame frame;
    TL_ASSIGN_OR_RETURN(frame.frame.color, DecodeV4l2(*image));
    frame.stamp = image->stamp -
                  std::chrono::duration_cast<base::MonotonicTime::duration>(
                      std::chrono::duration<double>(options_.latency_s));
    frame.sequence = image->sequence;
    return frame;
  }

 private:
  const V4l2CameraOptions options_;
  const std::unique_ptr<V4l2Device> device_;
};

class Opener final : public camera_driver::CameraOpener {
 public:
  Opener(const V4l2CameraOptions& options, std::unique_ptr<V4l2System> system)
      : options_(options), system_(std::move(system)) {}

  absl::StatusOr<std::unique_ptr<camera_driver::CameraDevice>> Open() override {
    TL_ASSIGN_OR_RETURN(std::unique_ptr<V4l2Device> device,
                        system_->Open(options_.mode));
    return std::make_unique<Device>(options_, std::move(device));
  }

 private:
  const V4l2CameraOptions options_;
  const std::unique_ptr<V4l2System> system_;
};

}  // namespace

absl::Status V4l2CameraOptions::Validate() const {
  if (mode.width < 1 || mode.height < 1 || mode.frames_per_s < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("a camera mode of ", mode.width, " x ", mode.height,
                     " at ", mode.frames_per_s, " Hz is none"));
  }
  if (calibration.color.width() != mode.width ||
      calibration.color.height() != mode.height) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the calibration is for ", calibration.color.width(), " x ",
        calibration.color.height(), " pixels, the camera is to send ",
        mode.width, " x ", mode.height));
  }
  if (!(latency_s >= 0) || !(latency_s <= 1)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a camera's latency_s of ", latency_s, " is outside [0, 1]"));
  }
  return live.Validate();
}

absl::StatusOr<image::ColorImage> ColorFromYuyv(const V4l2Image& image) {
  const auto width = static_cast<size_t>(std::max(0, image.width));
  const auto height = static_cast<size_t>(std::max(0, image.height));
  const auto stride = static_cast<size_t>(std::max(0, image.stride_bytes));
  if (width == 0 || height == 0 || width % 2 != 0 || stride < 2 * width ||
      image.bytes.size() < stride * (height - 1) + 2 * width) {
    return absl::InvalidArgumentError(
        absl::StrCat(image.bytes.size(), " bytes are no YUYV image of ", width,
                     " x ", height, " in rows of ", stride));
  }
  image::ColorImage color = {
      .width = image.width, .height = image.height, .rgb = {}};
  color.rgb.resize(3 * width * height);
  for (size_t y = 0; y < height; ++y) {
    const auto* from =
        reinterpret_cast<const uint8_t*>(image.bytes.data()) + y * stride;
    uint8_t* to = color.rgb.data() + 3 * width * y;
    for (size_t x = 0; x < width; x += 2, from += 4, to += 6) {
      const double cb = from[1] - 128.0;
      const double cr = from[3] - 128.0;
      PutRgb(from[0], cb, cr, to);
      PutRgb(from[2], cb, cr, to + 3);
    }
  }
  return color;
}

absl::StatusOr<image::ColorImage> DecodeV4l2(const V4l2Image& image) {
  if (image.corrupt) {
    return absl::DataLossError("the camera has sent an incomplete image");
  }
  absl::StatusOr<image::ColorImage> color =
      image.format == V4l2Format::kYuyv ? ColorFromYuyv(image)
                                        : image::DecodeColor(image.bytes);
  if (!color.ok()) return absl::DataLossError(color.status().message());
  if (color->width != image.width || color->height != image.height) {
    return absl::DataLossError(absl::StrCat("an image of ", color->width, " x ",
                                            color->height, " instead of ",
                                            image.width, " x ", image.height));
  }
  return color;
}

absl::StatusOr<std::unique_ptr<core::RgbdCamera>> MakeV4l2Camera(
    const V4l2CameraOptions& options, std::unique_ptr<V4l2System> system,
    const base::Clock& clock) {
  TL_RETURN_IF_ERROR(options.Validate());
  if (system == nullptr) {
    return absl::InvalidArgumentError("the camera has no video system");
  }
  return camera_driver::LiveCamera::Create(
      options.live, std::make_unique<Opener>(options, std::move(system)),
      clock);
}

}  // namespace treeline::v4l2_camera
