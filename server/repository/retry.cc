#include "server/repository/retry.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <optional>

#include "common/base/error_info.h"
#include "common/base/random.h"

namespace treeline::repository {
namespace {

constexpr uint64_t kProgressBytes = 1u << 20;

}  // namespace

void SleepUnlessStopped(std::chrono::milliseconds time,
                        const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait_for(lock, stop, time, [] { return false; });
}

absl::Status Retry(const RetryOptions& options, uint64_t seed,
                   const Sleeper& sleep, const std::stop_token& stop,
                   const std::function<absl::Status()>& attempt,
                   const std::function<uint64_t()>& progress) {
  base::Random random(seed, 0);
  std::chrono::milliseconds pause = options.first_pause;
  uint64_t best = progress();
  int attempts = 0;
  while (true) {
    if (stop.stop_requested()) return absl::CancelledError("cancelled");
    absl::Status status = attempt();
    if (!absl::IsUnavailable(status)) return status;
    if (const uint64_t now = progress(); now >= best + kProgressBytes) {
      best = now;
      attempts = 0;
      pause = options.first_pause;
    }
    ++attempts;
    const std::optional<std::chrono::milliseconds> asked =
        base::RetryAfterOf(status);
    if (attempts >= options.max_attempts ||
        (asked && *asked > options.longest_asked_pause)) {
      return status;
    }
    const auto half = std::chrono::milliseconds(static_cast<int64_t>(
        static_cast<double>(pause.count()) * random.NextUniform(0.5, 1)));
    sleep(asked ? *asked : half, stop);
    pause = std::min(2 * pause, options.longest_pause);
  }
}

}  // namespace treeline::repository
