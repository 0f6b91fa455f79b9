// Who drives by hand: one at a time, whose commands come in order.
#ifndef NAV_AGENT_SERVICE_DRIVER_SEAT_H_
#define NAV_AGENT_SERVICE_DRIVER_SEAT_H_

#include <cstdint>
#include <optional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"

namespace treeline::agent_service {

inline constexpr size_t kMaxDriverBytes = 64;

// Thread-safe.
class DriverSeat {
 public:
  // Whether this command of `driver` counts at `now`, of a real clock.
  // INVALID_ARGUMENT: no name, or too long a one; UNAVAILABLE: somebody else's
  // command is not stale yet; ABORTED: not higher than the last sequence of the
  // same driver.
  absl::Status Take(const std::string& driver, uint64_t sequence,
                    base::MonotonicTime now);

 private:
  absl::Mutex mutex_;
  std::string driver_ ABSL_GUARDED_BY(mutex_);
  uint64_t sequence_ ABSL_GUARDED_BY(mutex_) = 0;
  std::optional<base::MonotonicTime> last_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_DRIVER_SEAT_H_
