#include "server/core/localizer/stated_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "absl/status/statusor.h"
#include "common/camera/derived_camera.h"
#include "server/core/features/scale_space.h"
#include "server/core/localizer/parameters.h"

namespace treeline::localizer {
namespace {

int LongerSide(const camera::Camera& camera) {
  return std::max(camera.width(), camera.height());
}

bool IsSame(double a, double b) {
  return std::abs(std::log(a / b)) <= kSameFocal;
}

// In pictures whose longer side is 1.
double RelativeFocal(const camera::Camera& camera) {
  return MeanFocal_px(camera) / LongerSide(camera);
}

bool MayBeWindowOf(const camera::Camera& stated, const camera::Camera& learnt) {
  return LongerSide(stated) <= LongerSide(learnt) &&
         IsSame(MeanFocal_px(stated), MeanFocal_px(learnt));
}

// Distortion stands behind the principal point.
bool HasSameDistortion(const camera::Camera& a, const camera::Camera& b) {
  if (!a.has_distortion() || !b.has_distortion()) {
    return a.has_distortion() == b.has_distortion();
  }
  if (a.model() != b.model()) return false;
  const auto rest = static_cast<std::ptrdiff_t>(
      camera::CameraPrincipalPointIndex(a.model()) + 2);
  return std::equal(a.parameters().begin() + rest, a.parameters().end(),
                    b.parameters().begin() + rest);
}

// Of the principal point from the middle, in longer sides.
struct Offset {
  double x = 0;
  double y = 0;
};

Offset OffsetOf(const camera::Camera& camera) {
  return {(camera.cx() - 0.5 * (camera.width() - 1)) / LongerSide(camera),
          (camera.cy() - 0.5 * (camera.height() - 1)) / LongerSide(camera)};
}

bool IsFar(double x, double y) {
  return std::max(std::abs(x), std::abs(y)) > kMaxGuessedOffset;
}

bool IsOffCentre(const camera::Camera& camera) {
  const Offset offset = OffsetOf(camera);
  return IsFar(offset.x, offset.y);
}

// To within what it is rounded to.
bool IsCentred(const camera::Camera& camera) {
  constexpr double kRounding_px = 1;
  const Offset offset = OffsetOf(camera);
  return std::max(std::abs(offset.x), std::abs(offset.y)) *
             LongerSide(camera) <=
         kRounding_px;
}

// With its focal lengths times `scale` and the principal point in the middle.
std::optional<camera::Camera> Centred(const camera::Camera& camera,
                                      double scale) {
  absl::StatusOr<camera::Camera> scaled =
      camera::WithFocalScaled(camera, scale);
  if (!scaled.ok()) return std::nullopt;
  std::array<double, camera::Camera::kMaxParameters> p = scaled->parameters();
  const auto centre =
      static_cast<size_t>(camera::CameraPrincipalPointIndex(camera.model()));
  p[centre] = 0.5 * (camera.width() - 1);
  p[centre + 1] = 0.5 * (camera.height() - 1);
  scaled = camera::Camera::Create(camera.model(), camera.width(),
                                  camera.height(), p.data(),
                                  camera::CameraParameterCount(camera.model()));
  if (!scaled.ok()) return std::nullopt;
  return *std::move(scaled);
}

// By how much the picture would have to be resized for a principal point in the
// middle; nullopt: by different factors, or absurd ones.
std::optional<double> CentringScale(const camera::Camera& camera) {
  constexpr double kMaxDifference = 0.05;  // of logarithms
  constexpr double kMaxScale = 8;
  const double x = 0.5 * camera.width() / (camera.cx() + 0.5);
  const double y = 0.5 * camera.height() / (camera.cy() + 0.5);
  if (!(x > 0) || !(y > 0) || std::abs(std::log(x / y)) > kMaxDifference) {
    return std::nullopt;
  }
  const double scale = std::sqrt(x * y);
  if (std::abs(std::log(scale)) > std::log(kMaxScale)) return std::nullopt;
  return scale;
}

}  // namespace

bool MayBeGuessed(const camera::Camera& stated, const camera::Camera& learnt) {
  if (IsSame(RelativeFocal(stated), RelativeFocal(learnt))) return false;
  if (MayBeWindowOf(stated, learnt) || IsOffCentre(stated)) return false;
  return !stated.has_distortion() || HasSameDistortion(stated, learnt);
}

bool MayBeCutElsewhere(const camera::Camera& stated,
                       const camera::Camera& learnt) {
  return !IsSame(RelativeFocal(stated), RelativeFocal(learnt)) &&
         MayBeWindowOf(stated, learnt) && IsCentred(stated);
}

std::vector<camera::Camera> CentredCameras(const camera::Camera& stated,
                                           const camera::Camera& learnt) {
  const Offset of_stated = OffsetOf(stated);
  const Offset of_learnt = OffsetOf(learnt);
  if (!IsFar(of_stated.x, of_stated.y) ||
      !IsFar(of_stated.x - of_learnt.x, of_stated.y - of_learnt.y)) {
    return {};
  }
  std::vector<camera::Camera> cameras;
  const auto add = [&](double scale) {
    if (auto camera = Centred(stated, scale)) {
      cameras.push_back(*std::move(camera));
    }
  };
  if (const auto scale = CentringScale(stated)) add(*scale);
  add(1);
  return cameras;
}

double Narrowness(const camera::Camera& stated, const camera::Camera& learnt) {
  return std::max(1.0, RelativeFocal(stated) / RelativeFocal(learnt));
}

int FeatureReduction(const camera::Camera& stated,
                     const camera::Camera& learnt) {
  const int learnt_reduction =
      features::ScaleSpace::ReductionOf(learnt.width(), learnt.height());
  const double same =
      learnt_reduction * MeanFocal_px(stated) / MeanFocal_px(learnt);
  const int most =
      std::min(stated.width(), stated.height()) / kMinReducedSide_px;
  return std::clamp(static_cast<int>(std::lround(std::min(same, 1000.0))), 1,
                    std::max(1, most));
}

}  // namespace treeline::localizer
