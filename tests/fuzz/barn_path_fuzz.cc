// Paths of the BARN data set as arbitrary bytes: refused, or points that are
// finite.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "absl/strings/string_view.h"
#include "evaluation/fields/best_way.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const absl::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto points = treeline::fields::ParseBarnPath(bytes, "path");
  if (!points.ok()) return 0;
  if (points->empty()) std::abort();
  for (const treeline::geometry::Vec2 point : *points) {
    if (!std::isfinite(point.x) || !std::isfinite(point.y)) std::abort();
  }
  return 0;
}
