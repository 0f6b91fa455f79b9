#include "server/core/localizer/stated_camera.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

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

bool IsOffCentre(const camera::Camera& camera) {
  const double x_px = camera.cx() - 0.5 * (camera.width() - 1);
  const double y_px = camera.cy() - 0.5 * (camera.height() - 1);
  return std::max(std::abs(x_px), std::abs(y_px)) >
         kMaxGuessedOffset * LongerSide(camera);
}

}  // namespace

bool MayBeGuessed(const camera::Camera& stated, const camera::Camera& learnt) {
  if (IsSame(RelativeFocal(stated), RelativeFocal(learnt))) return false;
  if (MayBeWindowOf(stated, learnt) || IsOffCentre(stated)) return false;
  return !stated.has_distortion() || HasSameDistortion(stated, learnt);
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
