#include "server/access/rate_limiter.h"

#include <algorithm>

namespace treeline {

std::optional<std::chrono::nanoseconds> RateBucket::Take(
    MonotonicTime now, std::chrono::nanoseconds period, int64_t burst) {
  const MonotonicTime full = std::max(full_, now);
  const std::chrono::nanoseconds wait = full - now - period * (burst - 1);
  if (wait.count() > 0) return wait;
  full_ = full + period;
  return std::nullopt;
}

RateLimiter::RateLimiter(size_t capacity) : capacity_(capacity) {}

std::optional<std::chrono::nanoseconds> RateLimiter::Take(
    const std::string& caller, MonotonicTime now, double rate_per_s,
    int64_t burst) {
  const double rate = std::clamp(rate_per_s, 1e-6, 1e9);
  const std::chrono::nanoseconds period(static_cast<int64_t>(1e9 / rate));
  // So that no product overflows: a burst spans 100 days at most.
  const int64_t longest = std::max<int64_t>(
      1, std::chrono::nanoseconds(std::chrono::hours(2400)) / period);

  const absl::MutexLock lock(&mutex_);
  const auto found = by_caller_.find(caller);
  if (found != by_caller_.end()) {
    entries_.splice(entries_.begin(), entries_, found->second);
  } else {
    entries_.push_front({caller, {}});
    by_caller_[caller] = entries_.begin();
    if (entries_.size() > capacity_) {
      by_caller_.erase(entries_.back().caller);
      entries_.pop_back();
    }
  }
  return entries_.front().bucket.Take(now, period,
                                      std::clamp<int64_t>(burst, 1, longest));
}

size_t RateLimiter::size() const {
  const absl::MutexLock lock(&mutex_);
  return entries_.size();
}

}  // namespace treeline
