#include "common/camera/derived_camera.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"

namespace treeline::camera {
namespace {

using Parameters = std::array<double, Camera::kMaxParameters>;

// Where the parameters stand whose meaning depends on the axes.
constexpr size_t kTangential = 6;  // p1, p2
constexpr size_t kThinPrism = 10;  // sx1, sy1

bool HasTangential(CameraModel model) {
  return model == CameraModel::kOpenCv || model == CameraModel::kFullOpenCv ||
         model == CameraModel::kThinPrismFisheye;
}

bool HasThinPrism(CameraModel model) {
  return model == CameraModel::kThinPrismFisheye;
}

size_t PrincipalPoint(const Camera& camera) {
  return static_cast<size_t>(CameraPrincipalPointIndex(camera.model()));
}

absl::StatusOr<Camera> WithParameters(const Camera& camera, int width,
                                      int height,
                                      const Parameters& parameters) {
  return Camera::Create(camera.model(), width, height, parameters.data(),
                        CameraParameterCount(camera.model()));
}

}  // namespace

Camera Mirrored(const Camera& camera) {
  Parameters p = camera.parameters();
  p[PrincipalPoint(camera)] = camera.width() - 1 - camera.cx();
  if (HasTangential(camera.model())) p[kTangential + 1] *= -1;
  if (HasThinPrism(camera.model())) p[kThinPrism] *= -1;
  return *WithParameters(camera, camera.width(), camera.height(), p);
}

absl::StatusOr<Camera> Cropped(const Camera& camera, int left, int top,
                               int width, int height) {
  if (left < 0 || top < 0 || width < 1 || height < 1 ||
      width > camera.width() - left || height > camera.height() - top) {
    return absl::InvalidArgumentError(
        absl::StrCat("a window of ", width, " x ", height, " pixels at (", left,
                     ", ", top, ") does not lie in a picture of ",
                     camera.width(), " x ", camera.height()));
  }
  Parameters p = camera.parameters();
  const size_t c = PrincipalPoint(camera);
  p[c] -= left;
  p[c + 1] -= top;
  return WithParameters(camera, width, height, p);
}

absl::StatusOr<Camera> Resized(const Camera& camera, double factor) {
  // Camera::Create refuses sizes that are none, but they have to fit an int.
  if (!(factor > 0) || factor * camera.width() > 1e6 ||
      factor * camera.height() > 1e6) {
    return absl::InvalidArgumentError(
        absl::StrCat("a picture cannot be resized by ", factor));
  }
  Parameters p = camera.parameters();
  const size_t c = PrincipalPoint(camera);
  for (size_t i = 0; i < c; ++i) p[i] *= factor;
  for (const size_t i : {c, c + 1}) p[i] = (p[i] + 0.5) * factor - 0.5;
  return WithParameters(
      camera, static_cast<int>(std::lround(factor * camera.width())),
      static_cast<int>(std::lround(factor * camera.height())), p);
}

absl::StatusOr<Camera> WithFocalScaled(const Camera& camera, double factor) {
  Parameters p = camera.parameters();
  for (size_t i = 0; i < PrincipalPoint(camera); ++i) p[i] *= factor;
  return WithParameters(camera, camera.width(), camera.height(), p);
}

absl::StatusOr<Camera> WithPrincipalPointMoved(const Camera& camera, double x,
                                               double y) {
  Parameters p = camera.parameters();
  const size_t c = PrincipalPoint(camera);
  p[c] += x;
  p[c + 1] += y;
  return WithParameters(camera, camera.width(), camera.height(), p);
}

absl::StatusOr<Camera> WithRadialAdded(const Camera& camera, double k) {
  Parameters p = camera.parameters();
  CameraModel model = camera.model();
  const size_t k1 = PrincipalPoint(camera) + 2;
  switch (model) {
    case CameraModel::kSimplePinhole:
    case CameraModel::kPinhole:
      model = model == CameraModel::kPinhole ? CameraModel::kOpenCv
                                             : CameraModel::kSimpleRadial;
      std::fill(p.begin() + k1, p.end(), 0);
      break;
    case CameraModel::kSimpleRadial:
    case CameraModel::kRadial:
    case CameraModel::kOpenCv:
    case CameraModel::kFullOpenCv:
      break;
    case CameraModel::kOpenCvFisheye:
    case CameraModel::kFov:
    case CameraModel::kSimpleRadialFisheye:
    case CameraModel::kRadialFisheye:
    case CameraModel::kThinPrismFisheye:
      return absl::InvalidArgumentError(absl::StrCat(
          CameraModelName(model), " has no coefficients of an ordinary lens"));
  }
  p[k1] += k;
  return Camera::Create(model, camera.width(), camera.height(), p.data(),
                        CameraParameterCount(model));
}

}  // namespace treeline::camera
