// One number of an options struct, checked.
#ifndef COMMON_BASE_CHECK_RANGE_H_
#define COMMON_BASE_CHECK_RANGE_H_

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace treeline::base {

// INVALID_ARGUMENT, "NAME is 3; it must be 0..1", unless low <= value <= high;
// NaN is not.
inline absl::Status CheckRange(absl::string_view name, double value, double low,
                               double high) {
  if (value >= low && value <= high) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(name, " is ", value, "; it must be ", low, "..", high));
}

}  // namespace treeline::base

#endif  // COMMON_BASE_CHECK_RANGE_H_
