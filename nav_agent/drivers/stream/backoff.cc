#include "nav_agent/drivers/stream/backoff.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "common/base/random.h"

namespace treeline::stream {

absl::Status BackoffOptions::Validate() const {
  const auto error = [](absl::string_view message) {
    return absl::InvalidArgumentError(absl::StrCat("back-off: ", message));
  };
  if (!(first_s > 0)) return error("first_s must be positive");
  if (!(factor >= 1) || !std::isfinite(factor)) {
    return error("factor must be at least 1");
  }
  if (!(longest_s >= first_s) || !(longest_s <= 3600)) {
    return error("longest_s must lie between first_s and an hour");
  }
  if (!(jitter >= 0 && jitter < 1)) return error("jitter must lie in [0, 1)");
  return absl::OkStatus();
}

std::chrono::nanoseconds Backoff::Next() {
  // The power overflows to infinity at worst, which min() cuts off.
  const double wait_s =
      std::min(options_.longest_s,
               options_.first_s * std::pow(options_.factor, failures_));
  base::Random random(seed_, drawn_++);
  if (failures_ < 1'000'000) ++failures_;
  const double spread = 1 + options_.jitter * random.NextUniform(-1.0, 1.0);
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::duration<double>(wait_s * spread));
}

}  // namespace treeline::stream
