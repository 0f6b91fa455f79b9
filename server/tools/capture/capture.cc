#include "server/tools/capture/capture.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "server/tools/capture/conventions.h"

namespace treeline::capture {

void LeftOut::Add(const std::string& reason, const std::string& example) {
  const auto found = std::ranges::find(reasons_, reason, &Reason::text);
  if (found == reasons_.end()) {
    reasons_.push_back({reason, example, 1});
  } else {
    ++found->count;
  }
}

int LeftOut::count() const {
  int count = 0;
  for (const Reason& reason : reasons_) count += reason.count;
  return count;
}

std::vector<std::string> LeftOut::Lines() const {
  std::vector<std::string> lines;
  for (const auto& [text, example, count] : reasons_) {
    lines.push_back(absl::StrCat(count, count == 1 ? " frame: " : " frames: ",
                                 text, " (the first: ", example, ")"));
  }
  return lines;
}

absl::Status OpenOptions::Validate() const {
  if (!std::isfinite(depth_unit_m) || depth_unit_m < 0 || depth_unit_m > 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("depth unit of ", depth_unit_m, " m is outside 0..1"));
  }
  if (min_confidence < 0 || min_confidence > 2) {
    return absl::InvalidArgumentError(absl::StrCat(
        "least confidence of ", min_confidence, " is none of 0, 1 and 2"));
  }
  return up.empty() ? absl::OkStatus() : ZUpFromAxis(up).status();
}

}  // namespace treeline::capture
