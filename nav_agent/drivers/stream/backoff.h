// How long to wait before the next attempt to reach a device.
#ifndef NAV_AGENT_DRIVERS_STREAM_BACKOFF_H_
#define NAV_AGENT_DRIVERS_STREAM_BACKOFF_H_

#include <chrono>
#include <cstdint>

#include "absl/status/status.h"

namespace treeline::stream {

struct BackoffOptions {
  // After the first failure; times `factor` after each further one, but never
  // more than longest_s.
  double first_s = 0.1;
  double factor = 2.0;
  double longest_s = 3.0;
  // Each wait is drawn uniformly from 1 - jitter to 1 + jitter of that, so
  // that devices that fell out together do not come back in step. [0, 1).
  double jitter = 0.2;

  absl::Status Validate() const;
};

// The n-th wait after Reset() is
//   min(longest_s, first_s * factor^n) * (1 + jitter * u),  u in [-1, 1),
// where u is a function of the seed and of how many waits were drawn before.
class Backoff {
 public:
  // `options` must be valid.
  Backoff(const BackoffOptions& options, uint64_t seed)
      : options_(options), seed_(seed) {}

  std::chrono::nanoseconds Next();
  // After a success: begins again with first_s.
  void Reset() { failures_ = 0; }
  // Waits since the last success.
  int failures() const { return failures_; }

 private:
  BackoffOptions options_;
  uint64_t seed_;
  uint64_t drawn_ = 0;
  int failures_ = 0;
};

}  // namespace treeline::stream

#endif  // NAV_AGENT_DRIVERS_STREAM_BACKOFF_H_
