// Trying again what may succeed later.
#ifndef SERVER_REPOSITORY_RETRY_H_
#define SERVER_REPOSITORY_RETRY_H_

#include <chrono>
#include <cstdint>
#include <functional>
#include <stop_token>

#include "absl/status/status.h"

namespace treeline::repository {

struct RetryOptions {
  // In a row without progress, the first one included; at least 1.
  int max_attempts = 5;
  // The first pause; each next one is twice as long, up to the longest. A
  // random half of it is left out, so that clients do not come in step.
  std::chrono::milliseconds first_pause{250};
  std::chrono::milliseconds longest_pause{10000};
  // A server that asks for a longer pause is not waited for.
  std::chrono::milliseconds longest_asked_pause{30000};
};

// Waits, but no longer than until `stop` is requested.
using Sleeper =
    std::function<void(std::chrono::milliseconds, const std::stop_token& stop)>;
void SleepUnlessStopped(std::chrono::milliseconds time,
                        const std::stop_token& stop);

// Calls `attempt` until it returns something else than UNAVAILABLE, attempts
// are used up (then: its last error), or `stop` is requested (CANCELLED).
// Pauses as long as RetryAfterOf(error) asks for where it does. `progress`:
// bytes so far; where they have grown by 1 MiB, attempts count from one again.
absl::Status Retry(const RetryOptions& options, uint64_t seed,
                   const Sleeper& sleep, const std::stop_token& stop,
                   const std::function<absl::Status()>& attempt,
                   const std::function<uint64_t()>& progress);

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_RETRY_H_
