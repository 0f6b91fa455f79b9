#include "nav_agent/mapping/seen_place.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"

namespace treeline::mapping {
namespace {

constexpr const char* kPrefix = "seen at ";
// A rotation's norm may be so far from 1: six digits were written.
constexpr double kMaxNormError = 1e-3;

}  // namespace

std::string SeenPlaceText(const geometry::Rigid3& map_from_base) {
  const geometry::Vec3& t = map_from_base.translation;
  const geometry::Rotation3& q = map_from_base.rotation;
  return absl::StrFormat("%s%.4f %.4f %.4f %.6f %.6f %.6f %.6f", kPrefix, t.x,
                         t.y, t.z, q.x, q.y, q.z, q.w);
}

std::optional<geometry::Rigid3> ParseSeenPlace(absl::string_view text) {
  if (!absl::ConsumePrefix(&text, kPrefix)) return std::nullopt;
  const std::vector<absl::string_view> words = absl::StrSplit(text, ' ');
  std::array<double, 7> v{};
  if (words.size() != v.size()) return std::nullopt;
  for (size_t i = 0; i < v.size(); ++i) {
    if (!absl::SimpleAtod(words[i], &v[i]) || !std::isfinite(v[i])) {
      return std::nullopt;
    }
  }
  const double norm =
      std::sqrt(v[3] * v[3] + v[4] * v[4] + v[5] * v[5] + v[6] * v[6]);
  if (!(std::abs(norm - 1) < kMaxNormError)) return std::nullopt;
  return geometry::Rigid3{.rotation = {.w = v[6] / norm,
                                       .x = v[3] / norm,
                                       .y = v[4] / norm,
                                       .z = v[5] / norm},
                          .translation = {v[0], v[1], v[2]}};
}

}  // namespace treeline::mapping
