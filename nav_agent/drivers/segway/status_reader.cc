#include "nav_agent/drivers/segway/status_reader.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace treeline::segway {
namespace {

constexpr int64_t kFrame_ns = 10'000'000;
constexpr int64_t kFramesPerWrap = 65536;
// A cycle is late by what waits in buffers, and early by nothing but the
// difference of the clocks' rates.
constexpr int64_t kMaxLate_ns = 5'000'000'000;
constexpr int64_t kMaxEarly_ns = 200'000'000;
// The rates of two quartz clocks differ by less, by far.
constexpr double kMaxDrift = 0.002;
constexpr std::chrono::seconds kWindow(1);
// The base's top speed is 2.9 m/s.
constexpr double kMaxRolled_mps = 5;
constexpr double kMaxRolledSlack_m = 0.05;

int64_t Nanoseconds(base::MonotonicTime time) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             time.time_since_epoch())
      .count();
}

// Modulo 2^32, as the counters wrap.
int32_t Rolled(int32_t from, int32_t to) {
  return static_cast<int32_t>(static_cast<uint32_t>(to) -
                              static_cast<uint32_t>(from));
}

}  // namespace

SegwayStatusReader::SegwayStatusReader(const SegwayWire& wire,
                                       std::optional<uint8_t> channel)
    : wire_(wire), only_channel_(channel), channel_(channel) {}

void SegwayStatusReader::Reconnected() {
  channel_ = only_channel_;
  assemblies_ = {};
  suspect_.reset();
}

void SegwayStatusReader::CountersReset() { recount_ = true; }

std::optional<core::BaseReading> SegwayStatusReader::Take(
    const SegwayMessage& message, base::MonotonicTime arrival) {
  const std::optional<SegwayCycle> cycle = Assemble(message);
  if (!cycle) return std::nullopt;
  return Accept(*cycle, arrival);
}

std::optional<SegwayCycle> SegwayStatusReader::Assemble(
    const SegwayMessage& message) {
  if (message.channel != kSegwayChannelA &&
      message.channel != kSegwayChannelB) {
    return std::nullopt;
  }
  if (channel_ && message.channel != *channel_) return std::nullopt;
  if (message.id < kSegwayCycleBegin || message.id > kSegwayCycleEnd) {
    return std::nullopt;
  }
  Assembly& assembly = assemblies_[message.channel == kSegwayChannelA ? 0 : 1];
  const int place = message.id - kSegwayCycleBegin;
  if (place != assembly.messages) {
    if (assembly.messages != kSkipping) ++incomplete_;
    const bool between_cycles = place == 0 || message.id == kSegwayCycleEnd;
    assembly.messages = between_cycles ? 0 : kSkipping;
    if (place != 0) return std::nullopt;
  }
  ReadInto(message, assembly.cycle);
  if (++assembly.messages < kSegwayCycleMessages) return std::nullopt;
  assembly.messages = 0;
  channel_ = message.channel;
  return assembly.cycle;
}

std::optional<int64_t> SegwayStatusReader::FramesBetween(
    const Timed& before, const SegwayCycle& cycle,
    base::MonotonicTime arrival) {
  const int64_t passed_ns = Nanoseconds(arrival) - Nanoseconds(before.arrival);
  const int64_t frames =
      static_cast<uint16_t>(cycle.servo_frames - before.cycle.servo_frames);
  // The count wraps every 11 minutes: as often as makes it come nearest.
  const int64_t wraps = std::max<int64_t>(
      0, std::llround(static_cast<double>(passed_ns - frames * kFrame_ns) /
                      static_cast<double>(kFramesPerWrap * kFrame_ns)));
  const int64_t total = frames + wraps * kFramesPerWrap;
  const int64_t drift_ns =
      std::llround(kMaxDrift * static_cast<double>(passed_ns));
  const int64_t late_ns = passed_ns - total * kFrame_ns;
  // `before` itself may have been late.
  if (late_ns > kMaxLate_ns + drift_ns ||
      late_ns < -(kMaxLate_ns + kMaxEarly_ns + drift_ns)) {
    return std::nullopt;
  }
  return total;
}

bool SegwayStatusReader::WheelsCanHaveRolled(const SegwayCycle& before,
                                             const SegwayCycle& after,
                                             int64_t frames) {
  const double max_counts =
      kSegwayCountsPerMetre *
      (kMaxRolled_mps * kSegwayServoFrame_s * static_cast<double>(frames) +
       kMaxRolledSlack_m);
  return std::abs(1.0 * Rolled(before.left_position, after.left_position)) <=
             max_counts &&
         std::abs(1.0 * Rolled(before.right_position, after.right_position)) <=
             max_counts;
}

void SegwayStatusReader::BeginAt(const SegwayCycle& cycle,
                                 base::MonotonicTime arrival) {
  last_ = {
      .cycle = cycle, .arrival = arrival, .device_frames = cycle.servo_frames};
  min_offset_ns_ = min_offset_before_ns_ =
      Nanoseconds(arrival) - last_->device_frames * kFrame_ns;
  window_begin_ = arrival;
}

base::MonotonicTime SegwayStatusReader::StampOf(const Timed& timed) {
  const int64_t device_ns = timed.device_frames * kFrame_ns;
  const int64_t offset_ns = Nanoseconds(timed.arrival) - device_ns;
  if (timed.arrival - window_begin_ >= kWindow) {
    // After a gap the window before has nothing to say either.
    const bool gap = timed.arrival - window_begin_ >= 3 * kWindow;
    min_offset_before_ns_ = gap ? offset_ns : min_offset_ns_;
    min_offset_ns_ = offset_ns;
    window_begin_ = timed.arrival;
  }
  min_offset_ns_ = std::min(min_offset_ns_, offset_ns);
  const base::MonotonicTime stamp(
      std::chrono::duration_cast<base::MonotonicTime::duration>(
          std::chrono::nanoseconds(
              device_ns + std::min(min_offset_ns_, min_offset_before_ns_))));
  last_stamp_ = std::max(stamp, last_stamp_);
  return last_stamp_;
}

std::optional<core::BaseReading> SegwayStatusReader::Accept(
    const SegwayCycle& cycle, base::MonotonicTime arrival) {
  if (!last_) {
    BeginAt(cycle, arrival);
  } else if (const std::optional<int64_t> frames =
                 FramesBetween(*last_, cycle, arrival);
             frames.has_value() &&
             (recount_ || WheelsCanHaveRolled(last_->cycle, cycle, *frames))) {
    if (!recount_) {
      left_ += Rolled(last_->cycle.left_position, cycle.left_position);
      right_ += Rolled(last_->cycle.right_position, cycle.right_position);
    }
    last_ = {.cycle = cycle,
             .arrival = arrival,
             .device_frames = last_->device_frames + *frames};
  } else {
    std::optional<int64_t> after_suspect;
    if (suspect_) after_suspect = FramesBetween(*suspect_, cycle, arrival);
    if (!after_suspect ||
        !WheelsCanHaveRolled(suspect_->cycle, cycle, *after_suspect)) {
      ++implausible_;
      suspect_ = {.cycle = cycle, .arrival = arrival, .device_frames = 0};
      return std::nullopt;
    }
    BeginAt(cycle, arrival);
  }
  recount_ = false;
  suspect_.reset();
  last_cycle_ = cycle;
  core::BaseReading reading = ToReading(cycle, wire_);
  reading.stamp = StampOf(*last_);
  reading.left_wheel_m = static_cast<double>(left_) / kSegwayCountsPerMetre;
  reading.right_wheel_m = static_cast<double>(right_) / kSegwayCountsPerMetre;
  return reading;
}

}  // namespace treeline::segway
