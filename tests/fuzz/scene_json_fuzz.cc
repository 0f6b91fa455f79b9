// scene.json as arbitrary bytes: no crash, errors that name the file, and no
// value that a query could stumble over.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "absl/strings/match.h"
#include "absl/strings/string_view.h"
#include "server/repository/scene_metadata.h"

namespace treeline {
namespace {

void Check(absl::string_view text) {
  const auto metadata = repository::ParseSceneMetadata(text);
  if (!metadata.ok()) {
    if (!absl::IsInvalidArgument(metadata.status()) ||
        !absl::StartsWith(metadata.status().message(), "scene.json: ")) {
      std::abort();
    }
    return;
  }
  if (metadata->display_name.size() > repository::kMaxDisplayNameBytes)
    std::abort();
  if (metadata->geo_anchor) {
    const repository::GeoAnchor& anchor = *metadata->geo_anchor;
    const geometry::Rotation3& q = anchor.enu_from_world;
    const double norm =
        std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    // Written so that NaN aborts.
    if (!(std::abs(norm - 1) < 1e-9) ||
        !(std::abs(anchor.latitude_deg) <= 90) ||
        !(std::abs(anchor.longitude_deg) <= 180) ||
        !std::isfinite(anchor.height_m)) {
      std::abort();
    }
  }
  if (metadata->camera &&
      (!(metadata->camera->fx() > 0) || metadata->camera->width() < 1)) {
    std::abort();
  }
}

}  // namespace
}  // namespace treeline

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  treeline::Check(absl::string_view(reinterpret_cast<const char*>(data), size));
  return 0;
}
