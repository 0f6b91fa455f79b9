#include "common/base/nearest_name.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_replace.h"

namespace treeline::base {
namespace {

size_t EditDistance(absl::string_view a, absl::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  for (size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = std::exchange(row[0], i);
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({substituted, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row[b.size()];
}

}  // namespace

std::string NearestName(absl::string_view unknown,
                        std::span<const absl::string_view> known) {
  // Nothing this long is a slip of the finger.
  if (unknown.size() > 64) return "";
  const std::string as_key = absl::StrReplaceAll(absl::AsciiStrToLower(unknown),
                                                 {{"-", "_"}, {" ", "_"}});
  std::string nearest;
  size_t best = std::max<size_t>(2, as_key.size() / 3) + 1;
  for (const absl::string_view name : known) {
    const size_t distance = EditDistance(as_key, name);
    if (distance < best) {
      best = distance;
      nearest = std::string(name);
    }
  }
  return nearest;
}

}  // namespace treeline::base
