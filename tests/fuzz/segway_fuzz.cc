// A Segway base's bytes, as arbitrary ones in arbitrary pieces: no crash,
// nothing sent that is not a valid frame within the limits, nothing but stop
// frames 300 ms after the last command, and readings that are finite and whose
// wheels do not jump.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <span>
#include <vector>

#include "nav_agent/core/devices.h"
#include "nav_agent/drivers/segway/segway_codec.h"
#include "nav_agent/drivers/segway/segway_protocol.h"

namespace treeline {
namespace {

using std::chrono::milliseconds;

void Require(bool condition) {
  if (!condition) std::abort();
}

class Conversation {
 public:
  Conversation() { protocol_.Connected(now_); }

  // A piece of what the base says, and what this machine does meanwhile.
  void Step(std::span<const uint8_t> bytes, uint8_t control) {
    now_ += milliseconds(control & 0x1F);
    protocol_.Receive(bytes, now_);
    if ((control & 0x20) != 0) {
      const double speed_mps = (control & 0x40) != 0 ? 1e6 : 0.5;
      if (protocol_
              .SetVelocity({.forward_mps = speed_mps, .yaw_rate_radps = -9},
                           now_)
              .ok()) {
        commanded_at_ = now_;
      }
    }
    if ((control & 0xE0) == 0x80) protocol_.Stop();
    if ((control & 0xE0) == 0xC0) {
      protocol_.SetVelocity({.forward_mps = std::nan("")}, now_).IgnoreError();
    }
    CheckSent(protocol_.Send(now_));
    CheckReadings();
  }

 private:
  void CheckSent(const std::vector<uint8_t>& bytes) {
    Require(bytes.empty() || bytes.size() == segway::kSegwayFrameBytes);
    for (const segway::SegwayFrame& frame : base_.Parse(bytes)) {
      const std::optional<segway::SegwayMotion> motion =
          segway::ToMotion(segway::DecodeToBase(frame));
      Require(motion.has_value());
      Require(motion->velocity_counts >= -120 &&
              motion->velocity_counts <= 320);
      Require(std::abs(motion->turn_counts) <= 671);
      const bool moves =
          motion->velocity_counts != 0 || motion->turn_counts != 0;
      // Stop() may still be braking; from 0.8 m/s that takes 0.54 s.
      if (moves) {
        Require(commanded_at_ &&
                now_ - *commanded_at_ < milliseconds(300 + 600));
        Require(motion->setting == segway::SegwaySetting::kNone);
      }
    }
    Require(base_.discarded_bytes() == 0);
  }

  void CheckReadings() {
    for (const core::BaseReading& reading : protocol_.TakeReadings()) {
      for (const double value :
           {reading.left_wheel_m, reading.right_wheel_m, reading.forward_mps,
            reading.yaw_rate_radps, reading.pitch_rad, reading.roll_rad,
            reading.pitch_rate_radps, reading.roll_rate_radps,
            reading.battery_v}) {
        Require(std::isfinite(value));
      }
      Require(reading.stamp <= now_);
      if (last_) Require(reading.stamp >= last_->stamp);
      last_ = reading;
    }
  }

  segway::SegwayProtocol protocol_{segway::SegwayOptions{}};
  segway::SegwayFrameParser base_{segway::SegwayDirection::kToBase};
  base::MonotonicTime now_{std::chrono::hours(1)};
  std::optional<base::MonotonicTime> commanded_at_;
  std::optional<core::BaseReading> last_;
};

}  // namespace
}  // namespace treeline

// The input: pieces, each after a byte for what happens meanwhile and one for
// its length.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::span<const uint8_t> rest(data, size);
  treeline::Conversation conversation;
  while (rest.size() >= 2) {
    const uint8_t control = rest[0];
    const size_t length = std::min<size_t>(rest[1], rest.size() - 2);
    conversation.Step(rest.subspan(2, length), control);
    rest = rest.subspan(2 + length);
  }
  return 0;
}
