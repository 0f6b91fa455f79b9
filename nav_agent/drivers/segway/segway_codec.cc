#include "nav_agent/drivers/segway/segway_codec.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"

namespace treeline::segway {
namespace {

constexpr uint8_t kStart[] = {0xF0, 0x55};
constexpr size_t kChannelAt = 2;
constexpr size_t kIdFromBaseAt = 4;
constexpr size_t kIdToBaseAt = 6;
constexpr size_t kDataAt = 9;
constexpr size_t kChecksumAt = kSegwayFrameBytes - 1;
constexpr double kDegree_rad = std::numbers::pi / 180;
// 1024 counts are half a turn a second.
constexpr double kCountsPerHalfTurn = 1024;
// Absorbs the rounding of a conversion to radians and back.
constexpr double kCountSlack = 1e-6;

using Data = std::array<uint8_t, 8>;

void PutWord(Data& data, size_t at, uint16_t value) {
  data[at] = static_cast<uint8_t>(value >> 8);
  data[at + 1] = static_cast<uint8_t>(value);
}

void PutWord(Data& data, size_t at, int16_t value) {
  PutWord(data, at, static_cast<uint16_t>(value));
}

// The low word first, each word big-endian.
void PutLong(Data& data, size_t at, int32_t value) {
  const auto bits = static_cast<uint32_t>(value);
  PutWord(data, at, static_cast<uint16_t>(bits));
  PutWord(data, at + 2, static_cast<uint16_t>(bits >> 16));
}

uint16_t Word(const Data& data, size_t at) {
  return static_cast<uint16_t>(data[at] << 8 | data[at + 1]);
}

int16_t SignedWord(const Data& data, size_t at) {
  return static_cast<int16_t>(Word(data, at));
}

int32_t Long(const Data& data, size_t at) {
  return static_cast<int32_t>(uint32_t{Word(data, at)} |
                              uint32_t{Word(data, at + 2)} << 16);
}

SegwayFrame Begin(const SegwayMessage& message) {
  SegwayFrame frame = {};
  frame[0] = kStart[0];
  frame[1] = kStart[1];
  frame[kChannelAt] = message.channel;
  std::ranges::copy(message.data, frame.begin() + kDataAt);
  return frame;
}

uint8_t ChecksumOf(std::span<const uint8_t> frame) {
  return SegwayChecksum(frame.first<kChecksumAt>());
}

SegwayMessage Decode(const SegwayFrame& frame, uint16_t id) {
  SegwayMessage message = {.channel = frame[kChannelAt], .id = id, .data = {}};
  std::copy_n(frame.begin() + kDataAt, message.data.size(),
              message.data.begin());
  return message;
}

double TurnCountsPerRadps(const SegwayWire& wire) {
  return wire.turn_sign * (wire.turn_scale == SegwayWire::TurnScale::kPerDegree
                               ? kSegwayCountsPerDegree / kDegree_rad
                               : kCountsPerHalfTurn / std::numbers::pi);
}

// Towards zero, and cut at +-max.
int ToCounts(double counts, int max) {
  if (std::isnan(counts)) return 0;
  counts = std::clamp(counts, -1.0 * max, 1.0 * max);
  return static_cast<int>(counts + std::copysign(kCountSlack, counts));
}

}  // namespace

uint8_t SegwayChecksum(std::span<const uint8_t, kSegwayFrameBytes - 1> bytes) {
  uint32_t sum = 0;
  for (const uint8_t byte : bytes) sum += byte;
  sum = (sum & 0xFF) + (sum >> 8);
  sum = (sum & 0xFF) + (sum >> 8);
  return static_cast<uint8_t>(0x100 - sum);
}

SegwayFrame EncodeToBase(const SegwayMessage& message) {
  SegwayFrame frame = Begin(message);
  frame[kIdToBaseAt] = static_cast<uint8_t>(message.id >> 8);
  frame[kIdToBaseAt + 1] = static_cast<uint8_t>(message.id);
  frame[kChecksumAt] = ChecksumOf(frame);
  return frame;
}

SegwayFrame EncodeFromBase(const SegwayMessage& message) {
  SegwayFrame frame = Begin(message);
  frame[kIdFromBaseAt] = static_cast<uint8_t>(message.id >> 3);
  frame[kIdFromBaseAt + 1] = static_cast<uint8_t>(message.id << 5);
  frame[kChecksumAt] = ChecksumOf(frame);
  return frame;
}

SegwayMessage DecodeToBase(const SegwayFrame& frame) {
  return Decode(frame, static_cast<uint16_t>(frame[kIdToBaseAt] << 8 |
                                             frame[kIdToBaseAt + 1]));
}

SegwayMessage DecodeFromBase(const SegwayFrame& frame) {
  return Decode(frame, static_cast<uint16_t>((frame[kIdFromBaseAt] << 3 |
                                              frame[kIdFromBaseAt + 1] >> 5) &
                                             0xFFF));
}

bool SegwayFrameParser::MayBegin(std::span<const uint8_t> bytes) const {
  if (bytes[0] != kStart[0]) return false;
  if (bytes.size() > 1 && bytes[1] != kStart[1]) return false;
  if (direction_ == SegwayDirection::kFromBase && bytes.size() > kChannelAt &&
      bytes[kChannelAt] != kSegwayChannelA &&
      bytes[kChannelAt] != kSegwayChannelB) {
    return false;
  }
  return bytes.size() < kSegwayFrameBytes ||
         bytes[kChecksumAt] == ChecksumOf(bytes);
}

std::vector<SegwayFrame> SegwayFrameParser::Parse(
    std::span<const uint8_t> bytes) {
  waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
  std::vector<SegwayFrame> frames;
  size_t at = 0;
  while (at < waiting_.size()) {
    const std::span<const uint8_t> rest =
        std::span<const uint8_t>(waiting_).subspan(at);
    if (!MayBegin(rest)) {
      if (!discarding_) ++discarded_runs_;
      discarding_ = true;
      ++discarded_bytes_;
      ++at;
      continue;
    }
    if (rest.size() < kSegwayFrameBytes) break;
    std::copy_n(rest.begin(), kSegwayFrameBytes, frames.emplace_back().begin());
    at += kSegwayFrameBytes;
    discarding_ = false;
  }
  waiting_.erase(waiting_.begin(),
                 waiting_.begin() + static_cast<std::ptrdiff_t>(at));
  return frames;
}

void SegwayFrameParser::Reset() {
  waiting_.clear();
  discarding_ = false;
}

const char* SegwayModeName(SegwayMode mode) {
  switch (mode) {
    case SegwayMode::kDisabled:
      return "disabled";
    case SegwayMode::kTractor:
      return "tractor";
    case SegwayMode::kBalanced:
      return "balanced";
    case SegwayMode::kOff:
      return "off";
  }
  return "unknown";
}

absl::Status SegwayWire::Validate() const {
  for (const int sign : {turn_sign, yaw_rate_sign, pitch_sign, roll_sign}) {
    if (sign != 1 && sign != -1) {
      return absl::InvalidArgumentError(absl::StrCat("a sign of the base is ",
                                                     sign,
                                                     "; it has to be 1 or "
                                                     "-1"));
    }
  }
  return absl::OkStatus();
}

int SegwayVelocityCounts(double forward_mps) {
  return ToCounts(forward_mps * kSegwayCountsPerMps, kSegwayMaxVelocityCounts);
}

int SegwayTurnCounts(double yaw_rate_radps, const SegwayWire& wire) {
  return ToCounts(yaw_rate_radps * TurnCountsPerRadps(wire),
                  kSegwayMaxTurnCounts);
}

double SegwayVelocity_mps(int counts) { return counts / kSegwayCountsPerMps; }

double SegwayTurn_radps(int counts, const SegwayWire& wire) {
  return counts / TurnCountsPerRadps(wire);
}

SegwayMessage ToMessage(const SegwayMotion& motion, const SegwayWire& wire) {
  SegwayMessage message = {
      .channel = wire.transmit_channel, .id = kSegwayMotion, .data = {}};
  PutWord(message.data, 0, motion.velocity_counts);
  PutWord(message.data, 2, motion.turn_counts);
  PutWord(message.data, 4, static_cast<uint16_t>(motion.setting));
  PutWord(message.data, 6, motion.value);
  return message;
}

std::optional<SegwayMotion> ToMotion(const SegwayMessage& message) {
  if (message.id != kSegwayMotion) return std::nullopt;
  return SegwayMotion{
      .velocity_counts = SignedWord(message.data, 0),
      .turn_counts = SignedWord(message.data, 2),
      .setting = static_cast<SegwaySetting>(Word(message.data, 4)),
      .value = Word(message.data, 6)};
}

std::array<SegwayMessage, kSegwayCycleMessages> ToMessages(
    const SegwayCycle& cycle, uint8_t channel) {
  std::array<SegwayMessage, kSegwayCycleMessages> messages;
  for (size_t i = 0; i < messages.size(); ++i) {
    messages[i].channel = channel;
    messages[i].id = static_cast<uint16_t>(kSegwayCycleBegin + i);
  }
  PutWord(messages[1].data, 0, cycle.pitch);
  PutWord(messages[1].data, 2, cycle.pitch_rate);
  PutWord(messages[1].data, 4, cycle.roll);
  PutWord(messages[1].data, 6, cycle.roll_rate);
  PutWord(messages[2].data, 0, cycle.left_velocity);
  PutWord(messages[2].data, 2, cycle.right_velocity);
  PutWord(messages[2].data, 4, cycle.yaw_rate);
  PutWord(messages[2].data, 6, cycle.servo_frames);
  PutLong(messages[3].data, 0, cycle.left_position);
  PutLong(messages[3].data, 4, cycle.right_position);
  PutLong(messages[4].data, 0, cycle.forward_position);
  PutLong(messages[4].data, 4, cycle.turn_position);
  PutWord(messages[5].data, 0, cycle.left_torque);
  PutWord(messages[5].data, 2, cycle.right_torque);
  PutWord(messages[6].data, 0, cycle.mode);
  PutWord(messages[6].data, 2, cycle.gain);
  PutWord(messages[6].data, 4, cycle.ui_battery);
  PutWord(messages[6].data, 6, cycle.base_battery);
  PutWord(messages[7].data, 0, cycle.velocity_command);
  PutWord(messages[7].data, 2, cycle.turn_command);
  return messages;
}

void ReadInto(const SegwayMessage& message, SegwayCycle& cycle) {
  const Data& data = message.data;
  switch (message.id) {
    case 0x401:
      cycle.pitch = SignedWord(data, 0);
      cycle.pitch_rate = SignedWord(data, 2);
      cycle.roll = SignedWord(data, 4);
      cycle.roll_rate = SignedWord(data, 6);
      break;
    case 0x402:
      cycle.left_velocity = SignedWord(data, 0);
      cycle.right_velocity = SignedWord(data, 2);
      cycle.yaw_rate = SignedWord(data, 4);
      cycle.servo_frames = Word(data, 6);
      break;
    case 0x403:
      cycle.left_position = Long(data, 0);
      cycle.right_position = Long(data, 4);
      break;
    case 0x404:
      cycle.forward_position = Long(data, 0);
      cycle.turn_position = Long(data, 4);
      break;
    case 0x405:
      cycle.left_torque = SignedWord(data, 0);
      cycle.right_torque = SignedWord(data, 2);
      break;
    case 0x406:
      cycle.mode = Word(data, 0);
      cycle.gain = Word(data, 2);
      cycle.ui_battery = Word(data, 4);
      cycle.base_battery = Word(data, 6);
      break;
    case kSegwayCycleEnd:
      cycle.velocity_command = SignedWord(data, 0);
      cycle.turn_command = SignedWord(data, 2);
      break;
    default:
      break;
  }
}

double SegwayUiBattery_v(const SegwayCycle& cycle) {
  return cycle.ui_battery * 0.0125 + 1.4;
}

double SegwayBaseBattery_v(const SegwayCycle& cycle) {
  return cycle.base_battery / 4.0;
}

core::BaseReading ToReading(const SegwayCycle& cycle, const SegwayWire& wire) {
  constexpr double kCount_rad = kDegree_rad / kSegwayCountsPerDegree;
  core::BaseReading reading;
  reading.forward_mps =
      0.5 * (cycle.left_velocity + cycle.right_velocity) / kSegwayCountsPerMps;
  reading.yaw_rate_radps = wire.yaw_rate_sign * cycle.yaw_rate * kCount_rad;
  reading.pitch_rad = wire.pitch_sign * cycle.pitch * kCount_rad;
  reading.pitch_rate_radps = wire.pitch_sign * cycle.pitch_rate * kCount_rad;
  reading.roll_rad = wire.roll_sign * cycle.roll * kCount_rad;
  reading.roll_rate_radps = wire.roll_sign * cycle.roll_rate * kCount_rad;
  reading.battery_v = SegwayBaseBattery_v(cycle);
  return reading;
}

}  // namespace treeline::segway
