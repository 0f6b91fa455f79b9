#include "common/camera/assumed_camera.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/camera/derived_camera.h"

namespace treeline::camera {
namespace {

const double kFilmDiagonal_mm = std::hypot(36.0, 24.0);
// Fisheyes and telescopes.
constexpr double kMinFocal35_mm = 5;
constexpr double kMaxFocal35_mm = 500;
// Focal length of a usual lens, in longer sides.
constexpr double kUsualFocal = 0.75;
// Rounded sizes.
constexpr double kSameShape = 0.01;
// What EXIF rounds, and lenses breathe.
constexpr double kSameFocal = 0.05;
// The lenses of a phone differ by half as much again and more.
const double kOtherLens = std::log(1.25);

bool IsNear(double a, double b, double tolerance) {
  return std::abs(std::log(a / b)) <= tolerance;
}

// nullopt: not stated, or absurd.
std::optional<double> StatedFocal_px(std::optional<double> focal_35mm,
                                     int width, int height) {
  if (!focal_35mm || !(*focal_35mm >= kMinFocal35_mm) ||
      !(*focal_35mm <= kMaxFocal35_mm)) {
    return std::nullopt;
  }
  return *focal_35mm / kFilmDiagonal_mm * std::hypot(width, height);
}

double Shape(double width, double height) { return width / height; }

// The camera of the resized picture; a rounded size is made that of the
// picture.
std::optional<Camera> ResizedTo(const Camera& camera, int width, int height) {
  const absl::StatusOr<Camera> resized =
      Resized(camera, static_cast<double>(width) / camera.width());
  if (!resized.ok()) return std::nullopt;
  const absl::StatusOr<Camera> exact = Camera::Create(
      resized->model(), width, height, resized->parameters().data(),
      CameraParameterCount(resized->model()));
  if (!exact.ok()) return std::nullopt;
  return *exact;
}

}  // namespace

Camera AssumedCamera(int width, int height, std::optional<double> focal_35mm,
                     const Camera& scene) {
  const std::optional<double> stated =
      StatedFocal_px(focal_35mm, width, height);
  const double focal_px =
      stated.value_or(kUsualFocal * std::max(width, height));
  if (IsNear(Shape(width, height), Shape(scene.width(), scene.height()),
             kSameShape)) {
    const std::optional<Camera> resized = ResizedTo(scene, width, height);
    if (resized &&
        (!stated || IsNear(focal_px, MeanFocal_px(*resized), kSameFocal))) {
      return *resized;
    }
  }
  const std::array<double, 3> parameters = {focal_px, 0.5 * (width - 1),
                                            0.5 * (height - 1)};
  return *Camera::Create(CameraModel::kSimplePinhole, width, height,
                         parameters.data(), parameters.size());
}

bool IsOfAnotherLens(std::optional<double> focal_35mm, const Camera& scene) {
  const std::optional<double> stated =
      StatedFocal_px(focal_35mm, scene.width(), scene.height());
  return stated && !IsNear(*stated, MeanFocal_px(scene), kOtherLens);
}

}  // namespace treeline::camera
