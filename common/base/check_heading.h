#ifndef COMMON_BASE_CHECK_HEADING_H_
#define COMMON_BASE_CHECK_HEADING_H_

#include <cmath>
#include <numbers>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace treeline::base {

// INVALID_ARGUMENT if a heading that somebody wrote is more than a whole turn:
// who writes 90 thinks of degrees, and 90 rad would be 117 of them.
inline absl::Status CheckHeading(absl::string_view written,
                                 double heading_rad) {
  if (std::abs(heading_rad) <= 2 * std::numbers::pi) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(written, ": a heading of ", heading_rad,
                   " rad is more than a whole turn; headings are in rad, 90 "
                   "degrees are 1.5708"));
}

}  // namespace treeline::base

#endif  // COMMON_BASE_CHECK_HEADING_H_
