#include "nav_agent/drivers/camera/openni/openni_camera.h"

#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline::openni_camera {
namespace {

constexpr double kXtionBaseline_m = 0.025;

class Opener final : public camera_driver::CameraOpener {
 public:
  Opener(const OpenNiCameraOptions& options,
         std::unique_ptr<OpenNiSystem> system)
      : options_(options), system_(std::move(system)) {}

  absl::StatusOr<std::unique_ptr<camera_driver::CameraDevice>> Open() override {
    TL_ASSIGN_OR_RETURN(std::unique_ptr<OpenNiDevice> device,
                        system_->Open(options_.mode));
    OpenNiCameraOptions options = options_;
    if (options.calibration) {
      TL_RETURN_IF_ERROR(CheckCalibration(*options.calibration));
    } else {
      TL_ASSIGN_OR_RETURN(options.calibration,
                          CalibrationByFieldOfView(device->ColorFieldOfView(),
                                                   device->DepthFieldOfView(),
                                                   device->registered()));
    }
    return std::make_unique<OpenNiCameraDevice>(options, std::move(device));
  }

 private:
  absl::Status CheckCalibration(
      const camera::RgbdCalibration& calibration) const {
    for (const camera::Camera* camera :
         {&calibration.color, &calibration.depth}) {
      if (camera->width() == options_.mode.width &&
          camera->height() == options_.mode.height) {
        continue;
      }
      return absl::InvalidArgumentError(
          absl::StrCat("the calibration is for ", camera->width(), " x ",
                       camera->height(), " pixels, the camera is to send ",
                       options_.mode.width, " x ", options_.mode.height));
    }
    return absl::OkStatus();
  }

  const OpenNiCameraOptions options_;
  const std::unique_ptr<OpenNiSystem> system_;
};

absl::StatusOr<camera::Camera> PinholeOf(const OpenNiFieldOfView& view) {
  const double focal_lengths_px[] = {
      0.5 * view.width / std::tan(0.5 * view.horizontal_rad),
      0.5 * view.height / std::tan(0.5 * view.vertical_rad)};
  const double parameters[] = {focal_lengths_px[0], focal_lengths_px[1],
                               0.5 * (view.width - 1), 0.5 * (view.height - 1)};
  return camera::Camera::Create(camera::CameraModel::kPinhole, view.width,
                                view.height, parameters, 4);
}

}  // namespace

absl::Status OpenNiCameraOptions::Validate() const {
  if (mode.width < 1 || mode.height < 1 || mode.frames_per_s < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("a camera mode of ", mode.width, " x ", mode.height,
                     " at ", mode.frames_per_s, " Hz is none"));
  }
  if (!(max_pair_difference_s > 0) || !(max_pair_difference_s <= 0.1)) {
    return absl::InvalidArgumentError(absl::StrCat("max_pair_difference_s of ",
                                                   max_pair_difference_s,
                                                   " is outside (0, 0.1]"));
  }
  if (!(latency_s >= 0) || !(latency_s <= 1)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a camera's latency_s of ", latency_s, " is outside [0, 1]"));
  }
  return live.Validate();
}

absl::StatusOr<camera::RgbdCalibration> CalibrationByFieldOfView(
    const OpenNiFieldOfView& color, const OpenNiFieldOfView& depth,
    bool registered) {
  camera::RgbdCalibration calibration;
  TL_ASSIGN_OR_RETURN(calibration.color, PinholeOf(color));
  if (registered) {
    calibration.depth = calibration.color;
    return calibration;
  }
  TL_ASSIGN_OR_RETURN(calibration.depth, PinholeOf(depth));
  // The colour camera sits to the right of the depth camera, seen from behind.
  calibration.color_from_depth.translation = {-kXtionBaseline_m, 0, 0};
  return calibration;
}

OpenNiCameraDevice::OpenNiCameraDevice(const OpenNiCameraOptions& options,
                                       std::unique_ptr<OpenNiDevice> device)
    : options_(options),
      device_(std::move(device)),
      calibration_(options.calibration.value_or(camera::RgbdCalibration{})) {}

absl::StatusOr<std::optional<core::RgbdFrame>> OpenNiCameraDevice::Read(
    std::chrono::milliseconds timeout) {
  TL_ASSIGN_OR_RETURN(std::optional<OpenNiImage> image, device_->Read(timeout));
  if (!image) return std::nullopt;
  return Pair(*std::move(image));
}

absl::StatusOr<std::optional<core::RgbdFrame>> OpenNiCameraDevice::Pair(
    OpenNiImage image) {
  if (!waiting_) {
    waiting_ = std::move(image);
    return std::nullopt;
  }
  const std::chrono::duration<double> difference =
      image.device_time - waiting_->device_time;
  if (image.is_depth() == waiting_->is_depth() ||
      std::abs(difference.count()) > options_.max_pair_difference_s) {
    // The later one may still find its partner.
    if (difference.count() >= 0) waiting_ = std::move(image);
    return absl::DataLossError("colour without depth, or depth without colour");
  }
  OpenNiImage& color = image.is_depth() ? *waiting_ : image;
  OpenNiImage& depth = image.is_depth() ? image : *waiting_;
  core::RgbdFrame frame;
  frame.stamp = clock_.StampOf(color.device_time, color.arrival) -
                std::chrono::duration_cast<base::MonotonicTime::duration>(
                    std::chrono::duration<double>(options_.latency_s));
  frame.sequence = color.index;
  frame.frame.color = std::get<image::ColorImage>(std::move(color.image));
  frame.frame.depth = std::get<image::DepthImage>(std::move(depth.image));
  waiting_.reset();
  return frame;
}

absl::StatusOr<std::unique_ptr<core::RgbdCamera>> MakeOpenNiCamera(
    const OpenNiCameraOptions& options, std::unique_ptr<OpenNiSystem> system,
    const base::Clock& clock) {
  TL_RETURN_IF_ERROR(options.Validate());
  if (system == nullptr) {
    return absl::InvalidArgumentError("the camera has no OpenNI");
  }
  return camera_driver::LiveCamera::Create(
      options.live, std::make_unique<Opener>(options, std::move(system)),
      clock);
}

}  // namespace treeline::openni_camera
