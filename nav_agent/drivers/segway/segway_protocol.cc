#include "nav_agent/drivers/segway/segway_protocol.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/clock.h"

namespace treeline::segway {
namespace {

// Each setting is sent this often: only the mode is ever confirmed.
constexpr int kSettingRepeats = 2;
// How long the base has for the mode after the last setting.
constexpr double kConfirmTimeout_s = 1.0;
// A base that leaves its mode is left in peace this long before it is put back.
constexpr double kAstray_s = 1.0;
// What an acceleration ramp takes as passed after a pause.
constexpr double kLongestStep_s = 0.1;

base::MonotonicTime::duration Duration(double seconds) {
  return std::chrono::duration_cast<base::MonotonicTime::duration>(
      std::chrono::duration<double>(seconds));
}

bool IsZero(const core::VelocityCommand& command) {
  return command == core::VelocityCommand{};
}

}  // namespace

SegwayProtocol::SegwayProtocol(const SegwayOptions& options)
    : options_(options),
      reader_(options.wire, options.receive_channel),
      turn_watch_(options.wheel_track_m),
      cause_(absl::UnavailableError("the base has not been reached yet")) {}

void SegwayProtocol::Connected(base::MonotonicTime now) {
  phase_ = Phase::kListening;
  cause_ = absl::OkStatus();
  parser_.Reset();
  reader_.Reconnected();
  connected_at_ = last_cycle_at_ = now;
  heard_bytes_ = heard_frames_ = heard_cycle_ = false;
  motors_enabled_ = true;
  attempts_ = 0;
  astray_since_.reset();
  ForgetCommand();
  last_send_ = next_send_ = now;
}

void SegwayProtocol::Disconnected(const absl::Status& cause,
                                  base::MonotonicTime now) {
  Lose(cause);
  phase_ = Phase::kDisconnected;
  last_cycle_at_ = now;
}

void SegwayProtocol::Lose(const absl::Status& cause) {
  if (phase_ == Phase::kReady) ++losses_;
  phase_ = Phase::kListening;
  cause_ = cause;
  astray_since_.reset();
  settings_.clear();
  attempts_ = 0;
  ForgetCommand();
}

void SegwayProtocol::ForgetCommand() {
  command_.reset();
  braking_ = false;
  sent_ = {};
}

void SegwayProtocol::Receive(std::span<const uint8_t> bytes,
                             base::MonotonicTime now) {
  if (phase_ == Phase::kDisconnected) return;
  if (!bytes.empty()) heard_bytes_ = true;
  for (const SegwayFrame& frame : parser_.Parse(bytes)) {
    heard_frames_ = true;
    TakeMessage(DecodeFromBase(frame), now);
  }
}

void SegwayProtocol::TakeMessage(const SegwayMessage& message,
                                 base::MonotonicTime now) {
  if (options_.receive_channel &&
      message.channel != *options_.receive_channel) {
    return;
  }
  // What the other channel says of motors may be of another device on it.
  const bool heeded =
      reader_.channel().has_value() && message.channel == *reader_.channel();
  switch (message.id) {
    case kSegwayPowerStatus:
      if (!heeded) return;
      motors_enabled_ = message.data[3] == kSegwayMotorsEnabled;
      if (!motors_enabled_) ForgetCommand();
      return;
    case kSegwayHeartbeat:
      ++heartbeats_;
      return;
    default:
      break;
  }
  if (const std::optional<core::BaseReading> reading =
          reader_.Take(message, now)) {
    TakeReading(*reading, now);
  }
}

void SegwayProtocol::TakeReading(const core::BaseReading& reading,
                                 base::MonotonicTime now) {
  last_cycle_at_ = now;
  heard_cycle_ = true;
  if (phase_ == Phase::kListening) BeginConfiguring();
  if (phase_ == Phase::kConfiguring) CheckConfigured(now);
  if (phase_ == Phase::kReady) {
    if (InWantedMode()) {
      astray_since_.reset();
    } else if (!astray_since_) {
      astray_since_ = now;
      ForgetCommand();
    } else if (options_.restore_mode &&
               base::SecondsBetween(*astray_since_, now) >= kAstray_s) {
      BeginConfiguring();
    }
  }
  // The counters may just have been reset before the first time.
  if (!ever_ready_) return;
  turn_watch_.Take(reading, now);
  if (readings_.size() >= core::kMaxWaiting) {
    readings_.pop_front();
    ++dropped_;
  }
  readings_.push_back(reading);
  readings_.back().motors_enabled = motors_enabled_;
  ++received_;
}

bool SegwayProtocol::InWantedMode() const {
  const std::optional<SegwayCycle>& cycle = reader_.last_cycle();
  return cycle && cycle->mode == static_cast<uint16_t>(options_.mode);
}

void SegwayProtocol::BeginConfiguring() {
  phase_ = Phase::kConfiguring;
  ++attempts_;
  settings_.clear();
  ForgetCommand();
  const auto add = [this](SegwaySetting setting, uint16_t value) {
    for (int i = 0; i < kSettingRepeats; ++i) {
      settings_.push_back({.setting = setting, .value = value});
    }
  };
  if (options_.reset_integrators && !ever_ready_) {
    add(SegwaySetting::kResetIntegrators, kSegwayAllIntegrators);
    reader_.CountersReset();
  }
  add(SegwaySetting::kMaxVelocityScale, options_.max_velocity_scale);
  add(SegwaySetting::kMaxAccelerationScale, options_.max_acceleration_scale);
  add(SegwaySetting::kMaxTurnScale, options_.max_turn_scale);
  add(SegwaySetting::kGainSchedule, options_.gain_schedule);
  add(SegwaySetting::kCurrentLimitScale, options_.current_limit_scale);
  // A robot on casters must never begin to balance.
  add(SegwaySetting::kBalanceLock, options_.mode == SegwayMode::kTractor);
  add(SegwaySetting::kMode, static_cast<uint16_t>(options_.mode));
}

void SegwayProtocol::CheckConfigured(base::MonotonicTime now) {
  if (!settings_.empty()) return;
  // The first cycle after the last setting may have been under way before it.
  const double passed_s = base::SecondsBetween(configured_at_, now);
  if (InWantedMode() && passed_s >= 2 * options_.command_interval_s) {
    phase_ = Phase::kReady;
    cause_ = absl::OkStatus();
    attempts_ = 0;
    astray_since_.reset();
    if (!ever_ready_) reader_.CountersReset();
    ever_ready_ = true;
  } else if (!InWantedMode() && passed_s >= kConfirmTimeout_s) {
    BeginConfiguring();
  }
}

void SegwayProtocol::CheckLink(base::MonotonicTime now) {
  if (phase_ == Phase::kDisconnected) return;
  if (base::SecondsBetween(last_cycle_at_, now) < options_.link_timeout_s)
    return;
  Lose(SilenceCause());
}

absl::Status SegwayProtocol::SilenceCause() const {
  if (!heard_bytes_) {
    return absl::UnavailableError(
        "the base sends nothing: is it switched on, and is this its port?");
  }
  if (!heard_frames_) {
    return absl::UnavailableError(
        "what comes from the port are no frames of a Segway RMP: is it another "
        "device, or is the baud rate not 460800?");
  }
  if (!heard_cycle_) {
    return absl::UnavailableError(
        options_.receive_channel
            ? "the base sends frames, but no status cycle on the channel that "
              "is listened to: try the other, or the automatic choice"
            : "the base sends frames, but no whole status cycle: is the "
              "emergency stop pressed, or the line disturbed?");
  }
  return absl::UnavailableError(
      "the base has fallen silent: check its cable, its power and its "
      "emergency stop");
}

bool SegwayProtocol::ShouldReopen(base::MonotonicTime now) const {
  return phase_ != Phase::kDisconnected &&
         base::SecondsBetween(last_cycle_at_, now) >= options_.reopen_after_s;
}

absl::Status SegwayProtocol::Readiness() const {
  if (emergency_stop_) {
    return absl::FailedPreconditionError(
        "an emergency stop is engaged; release it to drive");
  }
  if (turn_watch_.verdict() == TurnWatch::Verdict::kWrong) {
    return absl::FailedPreconditionError(
        "the base turns right when it is to turn left: change turn_sign, or "
        "if that is right, the wheels' cables; see "
        "docs/reference/base-driver.md");
  }
  if (phase_ == Phase::kReady) {
    if (!motors_enabled_) {
      return absl::FailedPreconditionError(
          "the base's motors are disabled: release its emergency stop");
    }
    if (InWantedMode()) return absl::OkStatus();
    return absl::FailedPreconditionError(absl::StrCat(
        "the base has left the mode '", SegwayModeName(options_.mode),
        "' and is in '",
        SegwayModeName(static_cast<SegwayMode>(reader_.last_cycle()->mode)),
        "'"));
  }
  if (phase_ == Phase::kConfiguring) {
    if (attempts_ < 2) {
      return absl::UnavailableError("the base is being configured");
    }
    return absl::UnavailableError(absl::StrCat(
        "the base does not take the mode '", SegwayModeName(options_.mode),
        "' and stays in '",
        SegwayModeName(static_cast<SegwayMode>(reader_.last_cycle()->mode)),
        "': is its emergency stop pressed?"));
  }
  return cause_.ok() ? absl::UnavailableError("the base has not answered yet")
                     : cause_;
}

absl::Status SegwayProtocol::SetVelocity(const core::VelocityCommand& command,
                                         base::MonotonicTime now) {
  if (!std::isfinite(command.forward_mps) ||
      !std::isfinite(command.yaw_rate_radps)) {
    Stop();
    return absl::InvalidArgumentError(
        absl::StrCat("a velocity of ", command.forward_mps, " m/s and ",
                     command.yaw_rate_radps, " rad/s is none; stopping"));
  }
  CheckLink(now);
  if (const absl::Status readiness = Readiness(); !readiness.ok()) {
    ForgetCommand();
    return readiness.code() == absl::StatusCode::kFailedPrecondition
               ? readiness
               : absl::UnavailableError(readiness.message());
  }
  command_ = Limited(command, options_.limits);
  command_at_ = now;
  braking_ = false;
  return absl::OkStatus();
}

void SegwayProtocol::Stop() {
  command_.reset();
  braking_ = true;
}

void SegwayProtocol::SetEmergencyStop(bool engaged) {
  emergency_stop_ = engaged;
  ForgetCommand();
}

core::VelocityCommand SegwayProtocol::NextVelocity(base::MonotonicTime now) {
  if (!Readiness().ok()) return {};
  if (command_ && base::SecondsBetween(command_at_, now) >=
                      core::BaseDriver::kCommandLifetime_s) {
    if (!IsZero(*command_)) ++expired_;
    command_.reset();
  }
  if (!command_ && !braking_) return {};
  const core::VelocityCommand target =
      command_.value_or(core::VelocityCommand{});
  return Approach(
      sent_, target, options_.limits,
      std::min(base::SecondsBetween(last_send_, now), kLongestStep_s));
}

SegwayMotion SegwayProtocol::NextMotion(base::MonotonicTime now) {
  sent_ = NextVelocity(now);
  turn_watch_.Sent(sent_.yaw_rate_radps, now);
  if (braking_ && IsZero(sent_)) braking_ = false;
  SegwayMotion motion = {.velocity_counts = static_cast<int16_t>(
                             SegwayVelocityCounts(sent_.forward_mps)),
                         .turn_counts = static_cast<int16_t>(SegwayTurnCounts(
                             sent_.yaw_rate_radps, options_.wire))};
  if (phase_ == Phase::kConfiguring && !settings_.empty()) {
    motion.setting = settings_.front().setting;
    motion.value = settings_.front().value;
    settings_.pop_front();
    configured_at_ = now;
  }
  return motion;
}

std::vector<uint8_t> SegwayProtocol::Send(base::MonotonicTime now) {
  CheckLink(now);
  if (phase_ == Phase::kDisconnected || now < next_send_) return {};
  const SegwayFrame frame =
      EncodeToBase(ToMessage(NextMotion(now), options_.wire));
  last_send_ = now;
  next_send_ = now + Duration(options_.command_interval_s);
  return {frame.begin(), frame.end()};
}

std::vector<core::BaseReading> SegwayProtocol::TakeReadings() {
  std::vector<core::BaseReading> readings(readings_.begin(), readings_.end());
  readings_.clear();
  return readings;
}

core::DeviceHealth SegwayProtocol::Health() const {
  core::DeviceHealth health = {
      .state = core::DeviceState::kRunning,
      .cause = Readiness(),
      .received = received_,
      .corrupt = reader_.incomplete_cycles() + reader_.implausible_cycles(),
      .dropped = dropped_,
      .losses = losses_};
  if (phase_ != Phase::kReady) {
    health.state =
        ever_ready_ ? core::DeviceState::kLost : core::DeviceState::kStarting;
  }
  return health;
}

SegwayStatistics SegwayProtocol::Statistics() const {
  return {.discarded_bytes = parser_.discarded_bytes(),
          .discarded_runs = parser_.discarded_runs(),
          .incomplete_cycles = reader_.incomplete_cycles(),
          .implausible_cycles = reader_.implausible_cycles(),
          .expired_commands = expired_,
          .heartbeats = heartbeats_,
          .cycle = reader_.last_cycle(),
          .channel = reader_.channel()};
}

}  // namespace treeline::segway
