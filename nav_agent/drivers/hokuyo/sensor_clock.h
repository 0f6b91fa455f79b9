// From the sensor's own time to the host's.
#ifndef NAV_AGENT_DRIVERS_HOKUYO_SENSOR_CLOCK_H_
#define NAV_AGENT_DRIVERS_HOKUYO_SENSOR_CLOCK_H_

#include <chrono>
#include <cstdint>
#include <deque>
#include <optional>

#include "common/base/clock.h"

namespace treeline::hokuyo {

// A Hokuyo sensor stamps a scan with its own clock: whole milliseconds in 24
// bits, that began at some time and run a little too fast or slow. With s the
// unwrapped stamp, taken as the middle of its millisecond,
//
//   host time(s) = s + offset,    offset = sync + min W(now) - min W(0)
//
// sync    from the TM commands: a time s that the sensor told between the
//         host's t0 and t1 began its millisecond at most 1 ms earlier, so
//         t0 - (s + 1 ms) <= offset <= t1 - s (s here the whole number). All
//         samples' intervals are intersected; sync is the middle of what
//         remains, and exact to half its width.
// W(t)    the differences arrival - s of the scans that arrived within
//         kWindow before t. Transport only ever delays, so their minimum
//         follows the offset and the least delay, whatever the others suffer.
// W(0)    the first kBaselineScans of them. The least delay, which both minima
//         hold, cancels; what is left is how far the sensor has drifted.
//
// Without TM samples sync is min W(0) - assumed delay. A drift of 100 ppm is
// followed with a lag of kWindow * 100 ppm = 0.5 ms at most. Not thread-safe.
class SensorClock {
 public:
  static constexpr std::chrono::seconds kWindow{5};
  static constexpr int kBaselineScans = 40;

  explicit SensorClock(std::chrono::nanoseconds assumed_delay)
      : assumed_delay_(assumed_delay) {}

  // The sensor told `raw_ms` in answer to a request that left at `sent`.
  void AddTimeReply(int64_t raw_ms, base::MonotonicTime sent,
                    base::MonotonicTime received);

  // A scan with the stamp `raw_ms` was complete at `arrived`. Returns when
  // that stamp was; nothing if it came more than a second too early or five
  // too late: the sensor's clock has jumped, since the sensor has restarted,
  // and nothing here is of use any more.
  std::optional<base::MonotonicTime> HostTimeOfScan(
      int64_t raw_ms, base::MonotonicTime arrived);

  // Half the width that the TM samples leave; nothing without any, or where
  // they contradict each other.
  std::optional<std::chrono::nanoseconds> SyncUncertainty() const;

 private:
  using Offset = std::chrono::nanoseconds;  // host time minus sensor time
  struct Arrival {
    base::MonotonicTime arrived;
    Offset offset;
  };

  // The sensor's time since its clock was first seen, plus its value then:
  // the 24 bits continued by what the host's clock says has passed.
  int64_t Unwrap(int64_t raw_ms, base::MonotonicTime at);
  void AddArrival(base::MonotonicTime arrived, Offset offset);

  std::chrono::nanoseconds assumed_delay_;
  // The latest unwrapped time, and when that was.
  std::optional<int64_t> last_ms_;
  base::MonotonicTime last_at_;
  // What the TM samples leave of the offset.
  std::optional<Offset> sync_low_;
  std::optional<Offset> sync_high_;
  // W: ascending in both members, so that the first is the minimum.
  std::deque<Arrival> window_;
  int scans_ = 0;
  std::optional<Offset> baseline_;
};

}  // namespace treeline::hokuyo

#endif  // NAV_AGENT_DRIVERS_HOKUYO_SENSOR_CLOCK_H_
