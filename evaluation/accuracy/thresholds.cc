#include "evaluation/accuracy/thresholds.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"

namespace treeline::accuracy {

absl::StatusOr<ThresholdRequest> ParseThreshold(absl::string_view text) {
  const std::vector<absl::string_view> parts = absl::StrSplit(text, ',');
  ThresholdRequest request;
  if (parts.size() == 2) {
    absl::string_view translation = parts[0];
    request.relative = absl::ConsumeSuffix(&translation, "%");
    if (absl::SimpleAtod(translation, &request.translation) &&
        absl::SimpleAtod(parts[1], &request.rotation_deg) &&
        request.translation > 0 && request.rotation_deg > 0 &&
        std::isfinite(request.translation) &&
        std::isfinite(request.rotation_deg)) {
      return request;
    }
  }
  return absl::InvalidArgumentError(
      absl::StrCat("\"", text,
                   "\" is no threshold: it must be CM,DEG or PERCENT%,DEG, "
                   "both above 0"));
}

std::vector<ThresholdRequest> StandardThresholds() {
  return {{.translation = 5, .rotation_deg = 5},
          {.translation = 2, .rotation_deg = 2},
          {.translation = 10, .rotation_deg = 10}};
}

std::optional<double> SceneSize_m(const std::vector<FrameResult>& results) {
  std::optional<geometry::Vec3> low;
  geometry::Vec3 high;
  for (const FrameResult& result : results) {
    if (!result.true_world_from_camera) continue;
    const geometry::Vec3 at = result.true_world_from_camera->translation;
    if (!low) low = high = at;
    low = geometry::Vec3{std::min(low->x, at.x), std::min(low->y, at.y),
                         std::min(low->z, at.z)};
    high = {std::max(high.x, at.x), std::max(high.y, at.y),
            std::max(high.z, at.z)};
  }
  if (!low || !(geometry::Norm(high - *low) > 0)) return std::nullopt;
  return geometry::Norm(high - *low);
}

std::optional<PoseThreshold> Resolve(const ThresholdRequest& request,
                                     const std::optional<double>& size_m) {
  if (request.relative && !size_m) return std::nullopt;
  return PoseThreshold{
      request.translation / 100 * (request.relative ? *size_m : 1),
      request.rotation_deg};
}

std::string ThresholdText(const ThresholdRequest& request) {
  return absl::StrFormat("%g %s / %g°", request.translation,
                         request.relative ? "%" : "cm", request.rotation_deg);
}

}  // namespace treeline::accuracy
