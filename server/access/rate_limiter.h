// A token bucket for each of many callers, of which it remembers a bounded
// number.
#ifndef SERVER_ACCESS_RATE_LIMITER_H_
#define SERVER_ACCESS_RATE_LIMITER_H_

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "server/access/lru_map.h"

namespace treeline::access {

// The bucket of one caller, as one point in time (the "generic cell rate
// algorithm"): when it would be full. In any window of length t, at most
// burst + t / period requests are let in; whole nanoseconds, so that this holds
// exactly. Not thread-safe.
class RateBucket {
 public:
  // Takes one request, of which one comes back every `period`, and the bucket
  // holds `burst` (1 or more). nullopt: taken. Else it is not, and would be
  // after what is returned.
  std::optional<std::chrono::nanoseconds> Take(base::MonotonicTime now,
                                               std::chrono::nanoseconds period,
                                               int64_t burst);

 private:
  base::MonotonicTime full_ = base::MonotonicTime::min();
};

// Thread-safe.
class RateLimiter {
 public:
  // Remembers the `capacity` (1 or more) callers that asked last. One that is
  // forgotten starts with a full bucket.
  explicit RateLimiter(size_t capacity);

  // See RateBucket. `rate_per_s` is 1e-6 to 1e9.
  std::optional<std::chrono::nanoseconds> Take(const std::string& caller,
                                               base::MonotonicTime now,
                                               double rate_per_s,
                                               int64_t burst);

  size_t size() const;

 private:
  mutable absl::Mutex mutex_;
  LruMap<RateBucket> buckets_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::access

#endif  // SERVER_ACCESS_RATE_LIMITER_H_
