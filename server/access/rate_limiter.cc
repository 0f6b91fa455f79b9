#include "server/access/rate_limiter.h"

#include <algorithm>

namespace treeline::access {

std::optional<std::chrono::nanoseconds> RateBucket::Take(
    base::MonotonicTime now, std::chrono::nanoseconds period, int64_t burst) {
  const base::MonotonicTime full = std::max(full_, now);
  const std::chrono::nanoseconds wait = full - now - period * (burst - 1);
  if (wait.count() > 0) return wait;
  full_ = full + period;
  return std::nullopt;
}

RateLimiter::RateLimiter(size_t capacity) : buckets_(capacity) {}

std::optional<std::chrono::nanoseconds> RateLimiter::Take(
    const std::string& caller, base::MonotonicTime now, double rate_per_s,
    int64_t burst) {
  const double rate = std::clamp(rate_per_s, 1e-6, 1e9);
  const std::chrono::nanoseconds period(static_cast<int64_t>(1e9 / rate));
  // So that no product overflows: a burst spans 100 days at most.
  const int64_t longest = std::max<int64_t>(
      1, std::chrono::nanoseconds(std::chrono::hours(2400)) / period);

  const absl::MutexLock lock(&mutex_);
  if (RateBucket* const bucket = buckets_.Find(caller); bucket != nullptr) {
    return bucket->Take(now, period, std::clamp<int64_t>(burst, 1, longest));
  }
  RateBucket bucket;
  bucket.Take(now, period, 1);
  buckets_.Insert(caller, bucket);
  return std::nullopt;
}

size_t RateLimiter::size() const {
  const absl::MutexLock lock(&mutex_);
  return buckets_.size();
}

}  // namespace treeline::access
