#include "simulation/emulators/segway_emulator.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline::emulators {
namespace {

constexpr std::chrono::milliseconds kStep(10);
constexpr double kStep_s = 0.01;
constexpr std::chrono::milliseconds kSoonest(10);
// Of heartbeats and power states; how often a real base sends them is not known
// to us.
constexpr int64_t kStepsPerHeartbeat = 50;
constexpr int64_t kStepsPerPowerStatus = 100;
constexpr uint16_t kResetRight = 1;
constexpr uint16_t kResetLeft = 2;
constexpr uint16_t kResetYaw = 4;
constexpr uint16_t kResetForward = 8;
constexpr double kTurn_rad = 2 * std::numbers::pi;
constexpr double kDegree_rad = std::numbers::pi / 180;

int16_t Count16(double value) {
  return static_cast<int16_t>(
      std::lround(std::clamp(value, -32768.0, 32767.0)));
}

// Wraps as the base's counters do.
int32_t Count32(double value) {
  return static_cast<int32_t>(static_cast<uint32_t>(std::llround(value)));
}

int16_t Angle(double angle_rad) {
  return Count16(angle_rad / kDegree_rad * segway::kSegwayCountsPerDegree);
}

absl::Status CheckPositive(absl::string_view name, double value) {
  if (std::isfinite(value) && value > 0) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(name, " is ", value, "; it has to be positive"));
}

}  // namespace

absl::Status SegwayEmulatorOptions::Validate() const {
  TL_RETURN_IF_ERROR(wire.Validate());
  if (channel != segway::kSegwayChannelA &&
      channel != segway::kSegwayChannelB) {
    return absl::InvalidArgumentError("the channel is neither 0xAA nor 0xBB");
  }
  TL_RETURN_IF_ERROR(CheckPositive("wheel_track_m", wheel_track_m));
  TL_RETURN_IF_ERROR(
      CheckPositive("max_acceleration_mps2", max_acceleration_mps2));
  TL_RETURN_IF_ERROR(CheckPositive("max_yaw_acceleration_radps2",
                                   max_yaw_acceleration_radps2));
  TL_RETURN_IF_ERROR(CheckPositive("command_lifetime_s", command_lifetime_s));
  TL_RETURN_IF_ERROR(CheckPositive("battery_v", battery_v));
  if (!std::isfinite(battery_drain_v) || battery_drain_v < 0) {
    return absl::InvalidArgumentError("battery_drain_v is negative");
  }
  return absl::OkStatus();
}

absl::Status SegwayFaults::Validate() const {
  for (const double chance :
       {corrupt, drop_byte, drop_frame, corrupt_command, split}) {
    if (!(chance >= 0) || !(chance <= 1)) {
      return absl::InvalidArgumentError(
          absl::StrCat("a probability is ", chance, ", outside [0, 1]"));
    }
  }
  if (!(merge_s >= 0) || !(merge_s <= 10)) {
    return absl::InvalidArgumentError(
        absl::StrCat("merge_s is ", merge_s, ", outside [0, 10]"));
  }
  return absl::OkStatus();
}

SegwayEmulator::SegwayEmulator(const SegwayEmulatorOptions& options,
                               BasePlant& plant, base::MonotonicTime now)
    : options_(options),
      plant_(plant),
      random_(options.seed, /*stream=*/0),
      start_(now),
      next_cycle_(now + kStep),
      mode_(options.mode),
      next_delivery_(now) {}

void SegwayEmulator::SetFaults(const SegwayFaults& faults) {
  const bool power_changed = faults.motors_disabled != faults_.motors_disabled;
  if (faults.unplugged) {
    output_.clear();
    parser_.Reset();
  }
  faults_ = faults;
  if (power_changed) EmitPowerStatus();
}

void SegwayEmulator::Receive(std::span<const uint8_t> bytes,
                             base::MonotonicTime now) {
  AdvanceTo(now);
  if (faults_.unplugged) return;
  const int64_t broken = parser_.discarded_runs();
  for (const segway::SegwayFrame& frame : parser_.Parse(bytes)) {
    if (random_.NextUnit() < faults_.corrupt_command) {
      ++counts_.broken_commands;
      continue;
    }
    const segway::SegwayMessage message = segway::DecodeToBase(frame);
    if (message.id == segway::kSegwayShutDown) mode_ = segway::SegwayMode::kOff;
    if (message.channel != options_.wire.transmit_channel) continue;
    if (const auto motion = segway::ToMotion(message)) TakeMotion(*motion, now);
  }
  counts_.broken_commands += parser_.discarded_runs() - broken;
}

void SegwayEmulator::TakeMotion(const segway::SegwayMotion& motion,
                                base::MonotonicTime now) {
  ++counts_.commands;
  if (motion_at_) {
    if (now - *motion_at_ < kSoonest) ++counts_.too_soon;
    if (std::chrono::duration<double>(now - *motion_at_).count() >
        options_.command_lifetime_s) {
      ++counts_.too_late;
    }
  }
  motion_ = motion;
  motion_at_ = now;
  if (motion.setting != segway::SegwaySetting::kNone) {
    ++counts_.settings;
    Set(motion.setting, motion.value);
  }
}

void SegwayEmulator::Set(segway::SegwaySetting setting, uint16_t value) {
  const auto scale = [value] { return std::min<int>(value, 16); };
  switch (setting) {
    case segway::SegwaySetting::kMaxVelocityScale:
      velocity_scale_ = scale();
      return;
    case segway::SegwaySetting::kMaxAccelerationScale:
      acceleration_scale_ = scale();
      return;
    case segway::SegwaySetting::kMaxTurnScale:
      turn_scale_ = scale();
      return;
    case segway::SegwaySetting::kGainSchedule:
      gain_ = value;
      return;
    case segway::SegwaySetting::kMode:
      if (value <= static_cast<uint16_t>(segway::SegwayMode::kOff)) {
        mode_ = static_cast<segway::SegwayMode>(value);
      }
      return;
    case segway::SegwaySetting::kResetIntegrators:
      if ((value & kResetRight) != 0) zero_.right_m = integrated_.right_m;
      if ((value & kResetLeft) != 0) zero_.left_m = integrated_.left_m;
      if ((value & kResetYaw) != 0) zero_.yaw_rad = integrated_.yaw_rad;
      if ((value & kResetForward) != 0) {
        zero_.forward_m = integrated_.forward_m;
      }
      return;
    default:
      return;
  }
}

core::VelocityCommand SegwayEmulator::Wanted() const {
  const bool drives = mode_ == segway::SegwayMode::kTractor ||
                      mode_ == segway::SegwayMode::kBalanced;
  const bool obeys =
      motion_at_ &&
      std::chrono::duration<double>(next_cycle_ - *motion_at_).count() <=
          options_.command_lifetime_s;
  if (!drives || !obeys || faults_.motors_disabled) return {};
  const int max_velocity =
      segway::kSegwayMaxVelocityCounts * velocity_scale_ / 16;
  const int max_turn = segway::kSegwayMaxTurnCounts * turn_scale_ / 16;
  return {.forward_mps = segway::SegwayVelocity_mps(std::clamp<int>(
              motion_.velocity_counts, -max_velocity, max_velocity)),
          .yaw_rate_radps = segway::SegwayTurn_radps(
              std::clamp<int>(motion_.turn_counts, -max_turn, max_turn),
              options_.wire)};
}

core::VelocityCommand SegwayEmulator::WithStuckWheels(
    const core::VelocityCommand& wanted) const {
  if (!faults_.stuck_left_wheel && !faults_.stuck_right_wheel) return wanted;
  const double half_turn_mps =
      0.5 * options_.wheel_track_m * wanted.yaw_rate_radps;
  const double left_mps =
      faults_.stuck_left_wheel ? 0 : wanted.forward_mps - half_turn_mps;
  const double right_mps =
      faults_.stuck_right_wheel ? 0 : wanted.forward_mps + half_turn_mps;
  return {.forward_mps = 0.5 * (left_mps + right_mps),
          .yaw_rate_radps = (right_mps - left_mps) / options_.wheel_track_m};
}

void SegwayEmulator::Step() {
  const double scale = acceleration_scale_ / 16.0;
  const segway::VelocityLimits limits = {
      .max_acceleration_mps2 = options_.max_acceleration_mps2 * scale,
      .max_deceleration_mps2 = options_.max_acceleration_mps2 * scale,
      .max_yaw_acceleration_radps2 =
          options_.max_yaw_acceleration_radps2 * scale};
  moving_ = segway::Approach(moving_, Wanted(), limits, kStep_s);
  state_ = plant_.Step(WithStuckWheels(moving_), kStep_s);
  integrated_.yaw_rad += state_.yaw_rate_radps * kStep_s;
  integrated_.left_m = state_.left_wheel_m;
  integrated_.right_m = state_.right_wheel_m;
  integrated_.forward_m = 0.5 * (state_.left_wheel_m + state_.right_wheel_m);
  ++steps_;
}

void SegwayEmulator::AdvanceTo(base::MonotonicTime now) {
  for (; next_cycle_ <= now; next_cycle_ += kStep) {
    Step();
    if (mode_ == segway::SegwayMode::kOff) continue;
    ++counts_.cycles;
    for (const segway::SegwayMessage& message :
         segway::ToMessages(Cycle(), options_.channel)) {
      Emit(message);
    }
    if (steps_ % kStepsPerHeartbeat == 0) {
      Emit({.channel = options_.channel,
            .id = segway::kSegwayHeartbeat,
            .data = {}});
    }
    if (steps_ % kStepsPerPowerStatus == 0) EmitPowerStatus();
  }
}

segway::SegwayCycle SegwayEmulator::Cycle() const {
  const segway::SegwayWire& wire = options_.wire;
  segway::SegwayCycle cycle;
  cycle.pitch = Angle(wire.pitch_sign * state_.pitch_rad);
  cycle.pitch_rate = Angle(wire.pitch_sign * state_.pitch_rate_radps);
  cycle.roll = Angle(wire.roll_sign * state_.roll_rad);
  cycle.roll_rate = Angle(wire.roll_sign * state_.roll_rate_radps);
  cycle.left_velocity =
      Count16(state_.left_wheel_mps * segway::kSegwayCountsPerMps);
  cycle.right_velocity =
      Count16(state_.right_wheel_mps * segway::kSegwayCountsPerMps);
  cycle.yaw_rate = Angle(wire.yaw_rate_sign * state_.yaw_rate_radps);
  cycle.servo_frames = static_cast<uint16_t>(steps_);
  cycle.left_position = Count32((integrated_.left_m - zero_.left_m) *
                                segway::kSegwayCountsPerMetre);
  cycle.right_position = Count32((integrated_.right_m - zero_.right_m) *
                                 segway::kSegwayCountsPerMetre);
  cycle.forward_position = Count32((integrated_.forward_m - zero_.forward_m) *
                                   segway::kSegwayCountsPerMetre);
  cycle.turn_position =
      Count32(wire.yaw_rate_sign * (integrated_.yaw_rad - zero_.yaw_rad) /
              kTurn_rad * segway::kSegwayCountsPerTurn);
  cycle.mode = static_cast<uint16_t>(mode_);
  cycle.gain = gain_;
  const double hours = static_cast<double>(steps_) * kStep_s / 3600;
  const double battery_v =
      std::max(0.0, options_.battery_v - options_.battery_drain_v * hours);
  cycle.base_battery = static_cast<uint16_t>(std::lround(4 * battery_v));
  cycle.ui_battery = 480;  // 7.4 V
  cycle.velocity_command = motion_.velocity_counts;
  cycle.turn_command = motion_.turn_counts;
  return cycle;
}

void SegwayEmulator::EmitPowerStatus() {
  segway::SegwayMessage message = {.channel = options_.channel,
                                   .id = segway::kSegwayPowerStatus,
                                   .data = {}};
  message.data[3] = faults_.motors_disabled ? 0 : segway::kSegwayMotorsEnabled;
  Emit(message);
}

void SegwayEmulator::Emit(const segway::SegwayMessage& message) {
  if (faults_.unplugged) return;
  const segway::SegwayFrame frame = segway::EncodeFromBase(message);
  if (random_.NextUnit() < faults_.drop_frame) return;
  const size_t begin = output_.size();
  output_.insert(output_.end(), frame.begin(), frame.end());
  if (random_.NextUnit() < faults_.corrupt) {
    output_[begin + random_.NextBelow(segway::kSegwayFrameBytes)] ^=
        static_cast<uint8_t>(1 + random_.NextBelow(255));
  }
  if (random_.NextUnit() < faults_.drop_byte) {
    output_.erase(output_.begin() +
                  static_cast<std::ptrdiff_t>(
                      begin + random_.NextBelow(segway::kSegwayFrameBytes)));
  }
}

std::vector<uint8_t> SegwayEmulator::Advance(base::MonotonicTime now) {
  AdvanceTo(now);
  if (now < next_delivery_) return {};
  next_delivery_ =
      now + std::chrono::duration_cast<base::MonotonicTime::duration>(
                std::chrono::duration<double>(faults_.merge_s));
  size_t count = output_.size();
  if (count > 0 && random_.NextUnit() < faults_.split) {
    count = random_.NextBelow(static_cast<uint32_t>(count));
  }
  const auto end = output_.begin() + static_cast<std::ptrdiff_t>(count);
  std::vector<uint8_t> delivered(output_.begin(), end);
  output_.erase(output_.begin(), end);
  return delivered;
}

}  // namespace treeline::emulators
