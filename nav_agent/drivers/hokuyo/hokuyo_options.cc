#include "nav_agent/drivers/hokuyo/hokuyo_options.h"

#include <cmath>

#include "absl/strings/str_cat.h"

namespace treeline::hokuyo {
namespace {

// NaN lies nowhere.
bool Within(double value, double low, double high) {
  return value >= low && value <= high;
}

}  // namespace

absl::Status HokuyoOptions::Validate() const {
  const auto error = [](absl::string_view message) {
    return absl::InvalidArgumentError(absl::StrCat("laser: ", message));
  };
  constexpr double kTurn_rad = 2 * std::numbers::pi;
  if (!Within(angle_min_rad, -kTurn_rad, kTurn_rad) ||
      !Within(angle_max_rad, -kTurn_rad, kTurn_rad) ||
      angle_min_rad >= angle_max_rad) {
    return error(
        "angle_min_rad must be smaller than angle_max_rad, and both "
        "within a turn");
  }
  if (cluster < 1 || cluster > 99) return error("cluster must be 1 to 99");
  if (skipped_scans < 0 || skipped_scans > 9) {
    return error("skipped_scans must be 0 to 9");
  }
  if (!Within(max_range_m, 0.1, 300)) {
    return error("max_range_m must be 0.1 to 300");
  }
  if (!Within(assumed_delay_s, 0, 1)) {
    return error("assumed_delay_s must be 0 to 1");
  }
  if (!Within(stamp_offset_s, -1, 1)) {
    return error("stamp_offset_s must be -1 to 1");
  }
  if (!Within(reply_timeout_s, 0.01, 60)) {
    return error("reply_timeout_s must be 0.01 to 60");
  }
  if (!Within(first_scan_timeout_s, 0.1, 120)) {
    return error("first_scan_timeout_s must be 0.1 to 120");
  }
  if (!Within(silence_timeout_s, 0.1, 10)) {
    return error("silence_timeout_s must be 0.1 to 10");
  }
  return backoff.Validate();
}

}  // namespace treeline::hokuyo
