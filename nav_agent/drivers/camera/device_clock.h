// A device's clock on ours.
#ifndef NAV_AGENT_DRIVERS_CAMERA_DEVICE_CLOCK_H_
#define NAV_AGENT_DRIVERS_CAMERA_DEVICE_CLOCK_H_

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>

#include "common/base/clock.h"

namespace treeline::camera_driver {

// Turns a device's own times into ours: device time plus the least offset of
// the last ten to twenty seconds' arrivals, so that waiting in buffers does not
// move a stamp. What is common to all arrivals (exposure, transfer) remains,
// and is for the caller to subtract. A device time that jumps by more than a
// second against ours begins anew.
class DeviceClock {
 public:
  base::MonotonicTime StampOf(std::chrono::nanoseconds device_time,
                              base::MonotonicTime arrival) {
    const std::chrono::nanoseconds offset =
        arrival.time_since_epoch() - device_time;
    const bool jumped = min_ && std::chrono::abs(offset - *min_) > kMaxJump;
    if (!min_ || jumped) {
      min_ = min_before_ = offset;
      window_begin_ = arrival;
    } else if (arrival - window_begin_ >= kWindow) {
      min_before_ = *min_;
      min_ = offset;
      window_begin_ = arrival;
    }
    min_ = std::min(*min_, offset);
    return base::MonotonicTime(
        std::chrono::duration_cast<base::MonotonicTime::duration>(
            device_time + std::min(*min_, min_before_)));
  }

 private:
  static constexpr std::chrono::seconds kWindow{10};
  static constexpr std::chrono::seconds kMaxJump{1};

  std::optional<std::chrono::nanoseconds> min_;
  std::chrono::nanoseconds min_before_{0};
  base::MonotonicTime window_begin_;
};

}  // namespace treeline::camera_driver

#endif  // NAV_AGENT_DRIVERS_CAMERA_DEVICE_CLOCK_H_
