#include "nav_agent/drivers/hokuyo/sensor_clock.h"

#include <algorithm>
#include <cmath>

#include "nav_agent/drivers/hokuyo/scip_codec.h"

namespace treeline::hokuyo {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr nanoseconds kHalfMillisecond(500'000);
// A connection that stalls delivers late; nothing delivers early.
constexpr std::chrono::seconds kLargestDelay(5);
constexpr std::chrono::seconds kLargestLead(1);

}  // namespace

int64_t SensorClock::Unwrap(int64_t raw_ms, base::MonotonicTime at) {
  int64_t unwrapped = raw_ms;
  if (last_ms_) {
    const double expected_ms = static_cast<double>(*last_ms_) +
                               base::MillisecondsBetween(last_at_, at);
    const double turns = (expected_ms - static_cast<double>(raw_ms)) /
                         static_cast<double>(kScipTimeSpan_ms);
    unwrapped += kScipTimeSpan_ms * std::llround(turns);
  }
  last_ms_ = unwrapped;
  last_at_ = at;
  return unwrapped;
}

void SensorClock::AddTimeReply(int64_t raw_ms, base::MonotonicTime sent,
                               base::MonotonicTime received) {
  const milliseconds s(Unwrap(raw_ms, received));
  const Offset low = sent.time_since_epoch() - (s + milliseconds(1));
  const Offset high = received.time_since_epoch() - s;
  sync_low_ = sync_low_ ? std::max(*sync_low_, low) : low;
  sync_high_ = sync_high_ ? std::min(*sync_high_, high) : high;
}

std::optional<nanoseconds> SensorClock::SyncUncertainty() const {
  if (!sync_low_ || *sync_low_ > *sync_high_) return std::nullopt;
  return (*sync_high_ - *sync_low_) / 2;
}

void SensorClock::AddArrival(base::MonotonicTime arrived, Offset offset) {
  // Later and smaller: those before it will never be the minimum again.
  while (!window_.empty() && window_.back().offset >= offset) {
    window_.pop_back();
  }
  window_.push_back({arrived, offset});
  while (window_.front().arrived < arrived - kWindow) window_.pop_front();
}

std::optional<base::MonotonicTime> SensorClock::HostTimeOfScan(
    int64_t raw_ms, base::MonotonicTime arrived) {
  const nanoseconds s =
      milliseconds(Unwrap(raw_ms, arrived)) + kHalfMillisecond;
  const Offset offset = arrived.time_since_epoch() - s;
  if (!window_.empty() && (offset > window_.front().offset + kLargestDelay ||
                           offset < window_.front().offset - kLargestLead)) {
    return std::nullopt;
  }
  AddArrival(arrived, offset);
  const Offset least = window_.front().offset;
  if (++scans_ <= kBaselineScans) baseline_ = least;
  const auto uncertainty = SyncUncertainty();
  const Offset sync =
      uncertainty ? *sync_low_ + *uncertainty : *baseline_ - assumed_delay_;
  return base::MonotonicTime(
      std::chrono::duration_cast<base::MonotonicTime::duration>(
          s + sync + (least - *baseline_)));
}

}  // namespace treeline::hokuyo
