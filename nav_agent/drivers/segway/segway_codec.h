// The bytes of the Segway RMP100 on its USB serial line (FTDI 0403:e729,
// 460800 baud, 8N1): frames of 18 bytes that carry messages of 8. Pure: no
// input or output, no clock.
//
// Source: what public drivers of the RMP100 agree on, gathered in
// docs/reference/base-driver.md; where they disagree, SegwayWire says which one
// is meant.
#ifndef NAV_AGENT_DRIVERS_SEGWAY_SEGWAY_CODEC_H_
#define NAV_AGENT_DRIVERS_SEGWAY_SEGWAY_CODEC_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "absl/status/status.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::segway {

// ---- frames ----

inline constexpr size_t kSegwayFrameBytes = 18;
using SegwayFrame = std::array<uint8_t, kSegwayFrameBytes>;

// The two CAN buses of the base, as the first bytes of its frames call them.
inline constexpr uint8_t kSegwayChannelA = 0xAA;
inline constexpr uint8_t kSegwayChannelB = 0xBB;

struct SegwayMessage {
  uint8_t channel = 0;
  uint16_t id = 0;
  std::array<uint8_t, 8> data = {};

  bool operator==(const SegwayMessage&) const = default;
};

// Of the first 17 bytes of a frame: their sum, its high byte added to its low
// one twice, negated. Like every sum of ones' complement it cannot tell 00 from
// FF.
uint8_t SegwayChecksum(std::span<const uint8_t, kSegwayFrameBytes - 1> bytes);

// F0 55, channel [2], data [9..16], checksum [17]. Towards the base the id is
// big-endian in [6..7]; from the base its 11 bits are in [4..5], left-aligned
// as in a CAN controller: id = [4] << 3 | [5] >> 5.
SegwayFrame EncodeToBase(const SegwayMessage& message);
SegwayFrame EncodeFromBase(const SegwayMessage& message);
// Of frames with a correct start and checksum.
SegwayMessage DecodeToBase(const SegwayFrame& frame);
SegwayMessage DecodeFromBase(const SegwayFrame& frame);

enum class SegwayDirection { kFromBase, kToBase };

// Finds frames in a stream of bytes that may have been cut, merged, corrupted
// or lost anywhere. A frame is what begins with F0 55, from the base has one of
// the two channels, and has the right checksum; where it has not, the search
// goes on from the next byte, so that the first whole frame after any damage is
// found (but where a wrong beginning has the right checksum by chance, one in
// 256). Holds at most 17 bytes.
class SegwayFrameParser {
 public:
  explicit SegwayFrameParser(SegwayDirection direction)
      : direction_(direction) {}

  std::vector<SegwayFrame> Parse(std::span<const uint8_t> bytes);
  // Forgets the beginning of a frame, as after a new connection.
  void Reset();

  // Bytes that belonged to no frame, and in how many runs they came.
  int64_t discarded_bytes() const { return discarded_bytes_; }
  int64_t discarded_runs() const { return discarded_runs_; }

 private:
  // Whether these bytes, up to all of a frame's, can be the beginning of one.
  bool MayBegin(std::span<const uint8_t> bytes) const;

  const SegwayDirection direction_;
  std::vector<uint8_t> waiting_;
  int64_t discarded_bytes_ = 0;
  int64_t discarded_runs_ = 0;
  bool discarding_ = false;
};

// ---- messages to the base ----

inline constexpr uint16_t kSegwayMotion = 0x413;
inline constexpr uint16_t kSegwayShutDown = 0x412;

// What a motion message may set on its way. Scales are of 16 parts, the current
// limit of 256.
enum class SegwaySetting : uint16_t {
  kNone = 0,
  kMaxVelocityScale = 10,
  kMaxAccelerationScale = 11,
  kMaxTurnScale = 12,
  kGainSchedule = 13,
  kCurrentLimitScale = 14,
  kBalanceLock = 15,
  kMode = 16,
  kResetIntegrators = 50
};

enum class SegwayMode : uint16_t {
  kDisabled = 0,
  kTractor = 1,  // on two wheels and casters
  kBalanced = 2,
  kOff = 3
};
const char* SegwayModeName(SegwayMode mode);

// What kResetIntegrators takes: left, right, yaw, fore and aft.
inline constexpr uint16_t kSegwayAllIntegrators = 1 | 2 | 4 | 8;

// What sources disagree about; docs/reference/base-driver.md tells how to find
// out.
struct SegwayWire {
  enum class TurnScale {
    kPerDegree,   // 7.8 counts are 1 deg/s
    kPerHalfTurn  // 1024 counts are pi rad/s
  };
  // Of the turn command. Measured rates are always 7.8 per deg/s.
  TurnScale turn_scale = TurnScale::kPerDegree;
  // 1 or -1. What a positive count of the turn command is: 1 for to the left.
  int turn_sign = 1;
  // And of the measured yaw rate (1: to the left is positive), pitch (1: nose
  // down is positive) and roll (1: right side down is positive).
  int yaw_rate_sign = 1;
  int pitch_sign = 1;
  int roll_sign = 1;
  // Of frames to the base.
  uint8_t transmit_channel = 0;

  absl::Status Validate() const;
};

// Counts that a motion message can carry; what is beyond is cut. Velocities are
// rounded towards zero: never faster than asked.
inline constexpr int kSegwayMaxVelocityCounts = 1176;
inline constexpr int kSegwayMaxTurnCounts = 1024;
int SegwayVelocityCounts(double forward_mps);
int SegwayTurnCounts(double yaw_rate_radps, const SegwayWire& wire);
// And back, for the base's side.
double SegwayVelocity_mps(int counts);
double SegwayTurn_radps(int counts, const SegwayWire& wire);

struct SegwayMotion {
  int16_t velocity_counts = 0;
  int16_t turn_counts = 0;
  SegwaySetting setting = SegwaySetting::kNone;
  uint16_t value = 0;

  bool operator==(const SegwayMotion&) const = default;
};
SegwayMessage ToMessage(const SegwayMotion& motion, const SegwayWire& wire);
// nullopt for messages of other ids.
std::optional<SegwayMotion> ToMotion(const SegwayMessage& message);

// ---- messages from the base ----

// A status cycle is eight messages, 0x400 to 0x407, in this order.
inline constexpr uint16_t kSegwayCycleBegin = 0x400;
inline constexpr uint16_t kSegwayCycleEnd = 0x407;
inline constexpr int kSegwayCycleMessages = 8;
// "Motors enabled": data[3] is kSegwayMotorsEnabled.
inline constexpr uint16_t kSegwayPowerStatus = 0x680;
inline constexpr uint8_t kSegwayMotorsEnabled = 0x80;
inline constexpr uint16_t kSegwayHeartbeat = 0x688;

// Counts as they are sent.
inline constexpr double kSegwayCountsPerMps = 401;
inline constexpr double kSegwayCountsPerMetre = 40181;
inline constexpr double kSegwayCountsPerTurn = 117031;
inline constexpr double kSegwayCountsPerDegree = 7.8;
inline constexpr double kSegwayCountsPerNewtonMetre = 1463;
inline constexpr double kSegwayServoFrame_s = 0.01;

// What one status cycle says, in counts.
struct SegwayCycle {
  int16_t pitch = 0;  // 401; angles per degree, rates per deg/s
  int16_t pitch_rate = 0;
  int16_t roll = 0;
  int16_t roll_rate = 0;
  int16_t left_velocity = 0;  // 402; per m/s
  int16_t right_velocity = 0;
  int16_t yaw_rate = 0;
  uint16_t servo_frames = 0;  // of 0.01 s; wraps
  int32_t left_position = 0;  // 403; per metre; wraps
  int32_t right_position = 0;
  int32_t forward_position = 0;  // 404; per metre
  int32_t turn_position = 0;     // per revolution
  int16_t left_torque = 0;       // 405; per Nm
  int16_t right_torque = 0;
  uint16_t mode = 0;  // 406
  uint16_t gain = 0;
  uint16_t ui_battery = 0;
  uint16_t base_battery = 0;
  int16_t velocity_command = 0;  // 407
  int16_t turn_command = 0;

  bool operator==(const SegwayCycle&) const = default;
};

// The cycle's messages, on `channel`.
std::array<SegwayMessage, kSegwayCycleMessages> ToMessages(
    const SegwayCycle& cycle, uint8_t channel);
// Puts what the message says into `cycle`; messages of other ids change
// nothing.
void ReadInto(const SegwayMessage& message, SegwayCycle& cycle);

double SegwayUiBattery_v(const SegwayCycle& cycle);
double SegwayBaseBattery_v(const SegwayCycle& cycle);
// But for stamp, wheels and motors_enabled, which a cycle alone does not tell.
core::BaseReading ToReading(const SegwayCycle& cycle, const SegwayWire& wire);

}  // namespace treeline::segway

#endif  // NAV_AGENT_DRIVERS_SEGWAY_SEGWAY_CODEC_H_
