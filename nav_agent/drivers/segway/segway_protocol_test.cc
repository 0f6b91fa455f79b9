#include "nav_agent/drivers/segway/segway_protocol.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::segway {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr core::VelocityCommand kArc = {.forward_mps = 0.4,
                                        .yaw_rate_radps = 0.5};
constexpr uint16_t kTractor = 1;

struct Sent {
  base::MonotonicTime at;
  SegwayMotion motion;

  bool IsStop() const {
    return motion.velocity_counts == 0 && motion.turn_counts == 0;
  }
};

// A protocol with a base that answers at once, on a clock of its own that
// advances in milliseconds.
class SegwayProtocolTest : public ::testing::Test {
 protected:
  void SetUp() override { Restart({}); }
  void Restart(const SegwayOptions& options) {
    protocol_.emplace(options);
    protocol_->Connected(now_);
  }

  // One millisecond after another: a status cycle every ten while talking_,
  // and whatever the protocol sends.
  void Run(int ms) {
    for (int i = 0; i < ms; ++i) {
      now_ += milliseconds(1);
      ++cycle_ms_;
      if (talking_ && cycle_ms_ % 10 == 0) SendCycle();
      Collect();
    }
  }
  void Collect() {
    const std::vector<uint8_t> bytes = protocol_->Send(now_);
    for (const SegwayFrame& frame : base_parser_.Parse(bytes)) {
      const auto motion = ToMotion(DecodeToBase(frame));
      ASSERT_TRUE(motion.has_value());
      sent_.push_back({.at = now_, .motion = *motion});
      if (motion->setting == SegwaySetting::kMode && takes_mode_) {
        cycle_.mode = motion->value;
      }
    }
  }
  void SendCycle() {
    cycle_.servo_frames = static_cast<uint16_t>(cycle_ms_ / 10);
    for (const SegwayMessage& message : ToMessages(cycle_, channel_)) {
      Receive(message);
    }
  }
  void Receive(const SegwayMessage& message) {
    protocol_->Receive(EncodeFromBase(message), now_);
  }
  void SendPowerStatus(bool enabled) {
    SegwayMessage message = {.channel = channel_, .id = kSegwayPowerStatus};
    message.data[3] = enabled ? kSegwayMotorsEnabled : 0;
    Receive(message);
  }
  // Starts up, and forgets what that took.
  void MakeReady() {
    Run(600);
    ASSERT_EQ(protocol_->Health().state, core::DeviceState::kRunning);
    protocol_->TakeReadings();
    sent_.clear();
  }
  // Drives as kArc, with a new command every 20 ms.
  void Drive(int ms) {
    for (int i = 0; i < ms; i += 20) {
      ASSERT_TRUE(protocol_->SetVelocity(kArc, now_).ok());
      Run(20);
    }
  }
  bool OnlyStopsSent() const {
    return std::ranges::all_of(sent_, [](const Sent& s) { return s.IsStop(); });
  }

  std::optional<SegwayProtocol> protocol_;
  SegwayFrameParser base_parser_{SegwayDirection::kToBase};
  base::MonotonicTime now_{std::chrono::hours(1)};
  int cycle_ms_ = 0;
  bool talking_ = true;
  bool takes_mode_ = true;
  uint8_t channel_ = kSegwayChannelA;
  SegwayCycle cycle_;
  std::vector<Sent> sent_;
};

TEST_F(SegwayProtocolTest, SendsOnlyStopFramesUntilTheBaseIsHeard) {
  talking_ = false;
  EXPECT_EQ(protocol_->SetVelocity(kArc, now_).code(),
            absl::StatusCode::kUnavailable);
  Run(200);
  EXPECT_EQ(protocol_->Health().state, core::DeviceState::kStarting);
  EXPECT_FALSE(sent_.empty());
  for (const Sent& sent : sent_) EXPECT_EQ(sent.motion, SegwayMotion{});
}

TEST_F(SegwayProtocolTest, StartUpSetsEverythingWhileStandingStill) {
  Run(600);
  EXPECT_EQ(protocol_->Health().state, core::DeviceState::kRunning);
  EXPECT_TRUE(protocol_->Health().cause.ok());
  EXPECT_TRUE(OnlyStopsSent());
  std::vector<std::pair<SegwaySetting, int>> settings;
  for (const Sent& sent : sent_) {
    if (sent.motion.setting == SegwaySetting::kNone) continue;
    const std::pair<SegwaySetting, int> setting = {sent.motion.setting,
                                                   sent.motion.value};
    // Each is sent twice.
    if (settings.empty() || settings.back() != setting) {
      settings.push_back(setting);
    }
  }
  const std::vector<std::pair<SegwaySetting, int>> expected = {
      {SegwaySetting::kResetIntegrators, 15},
      {SegwaySetting::kMaxVelocityScale, 16},
      {SegwaySetting::kMaxAccelerationScale, 16},
      {SegwaySetting::kMaxTurnScale, 16},
      {SegwaySetting::kGainSchedule, 0},
      {SegwaySetting::kCurrentLimitScale, 256},
      {SegwaySetting::kBalanceLock, 1},
      {SegwaySetting::kMode, 1}};
  EXPECT_EQ(settings, expected);
}

TEST_F(SegwayProtocolTest, ABaseThatRefusesItsModeIsAskedAgainAndReported) {
  takes_mode_ = false;
  Run(4000);
  EXPECT_EQ(protocol_->Health().state, core::DeviceState::kStarting);
  EXPECT_THAT(std::string(protocol_->Health().cause.message()),
              HasSubstr("stays in 'disabled'"));
  EXPECT_EQ(protocol_->SetVelocity(kArc, now_).code(),
            absl::StatusCode::kUnavailable);
  EXPECT_GE(std::ranges::count_if(sent_,
                                  [](const Sent& sent) {
                                    return sent.motion.setting ==
                                           SegwaySetting::kMode;
                                  }),
            4);
  EXPECT_TRUE(OnlyStopsSent());
  takes_mode_ = true;
  Run(2000);
  EXPECT_EQ(protocol_->Health().state, core::DeviceState::kRunning);
}

TEST_F(SegwayProtocolTest, FramesGoOutEveryInterval) {
  MakeReady();
  Drive(1000);
  Run(1000);
  for (size_t i = 1; i < sent_.size(); ++i) {
    EXPECT_EQ(sent_[i].at - sent_[i - 1].at, milliseconds(20)) << i;
  }
  EXPECT_EQ(sent_.size(), 100u);
}

TEST_F(SegwayProtocolTest, OneReadingACycleWithTheBasesValues) {
  MakeReady();
  cycle_.left_position += 401;
  cycle_.pitch = 78;
  cycle_.base_battery = 288;
  Run(30);
  const std::vector<core::BaseReading> readings = protocol_->TakeReadings();
  ASSERT_EQ(readings.size(), 3u);
  EXPECT_NEAR(readings[0].pitch_rad, 10 * std::numbers::pi / 180, 1e-12);
  EXPECT_EQ(readings[0].battery_v, 72);
  EXPECT_EQ(readings[1].stamp - readings[0].stamp, milliseconds(10));
  EXPECT_TRUE(readings[0].motors_enabled);
  EXPECT_THAT(protocol_->TakeReadings(), IsEmpty());
}

TEST_F(SegwayProtocolTest, ReadingsThatNobodyTakesAreDroppedAndCounted) {
  MakeReady();
  Run(1000);
  EXPECT_EQ(protocol_->Health().dropped, 100 - core::kMaxWaiting);
  EXPECT_EQ(protocol_->TakeReadings().size(), size_t{core::kMaxWaiting});
}

TEST_F(SegwayProtocolTest, RampsUpToTheCommandAndHoldsIt) {
  MakeReady();
  Drive(1000);
  double before_mps = 0;
  for (const Sent& sent : sent_) {
    const double speed_mps = SegwayVelocity_mps(sent.motion.velocity_counts);
    // 0.8 m/s2 for 20 ms, and a count of rounding.
    EXPECT_LE(speed_mps - before_mps, 0.016 + 1 / kSegwayCountsPerMps);
    before_mps = speed_mps;
  }
  EXPECT_EQ(sent_.back().motion.velocity_counts, 160);
  EXPECT_EQ(sent_.back().motion.turn_counts, 223);
}

TEST_F(SegwayProtocolTest, NothingIsSentBeyondTheLimits) {
  MakeReady();
  for (int i = 0; i < 2000; i += 20) {
    ASSERT_TRUE(
        protocol_
            ->SetVelocity({.forward_mps = 1e300, .yaw_rate_radps = -1e9}, now_)
            .ok());
    Run(20);
  }
  for (const Sent& sent : sent_) {
    EXPECT_LE(sent.motion.velocity_counts, 320);
    EXPECT_GE(sent.motion.turn_counts, -671);
  }
}

TEST_F(SegwayProtocolTest, ACommandEnds300msAfterItWasGiven) {
  MakeReady();
  Drive(1000);
  ASSERT_TRUE(protocol_->SetVelocity(kArc, now_).ok());
  const base::MonotonicTime given = now_;
  sent_.clear();
  Run(2000);
  ASSERT_FALSE(sent_.empty());
  for (const Sent& sent : sent_) {
    EXPECT_EQ(sent.IsStop(), sent.at - given >= milliseconds(300))
        << (sent.at - given) / milliseconds(1);
  }
  EXPECT_EQ(protocol_->Statistics().expired_commands, 1);
}

TEST_F(SegwayProtocolTest, AnExpiredCommandNeverComesBack) {
  MakeReady();
  Drive(500);
  Run(400);
  sent_.clear();
  // Whatever else happens, without a new command nothing moves.
  SendPowerStatus(true);
  protocol_->SetEmergencyStop(true);
  Run(50);
  protocol_->SetEmergencyStop(false);
  Run(100);
  talking_ = false;
  Run(500);
  talking_ = true;
  Run(1000);
  protocol_->Disconnected(absl::UnavailableError("unplugged"), now_);
  Run(100);
  protocol_->Connected(now_);
  Run(1000);
  EXPECT_EQ(protocol_->Health().state, core::DeviceState::kRunning);
  EXPECT_TRUE(OnlyStopsSent());
}

// Time passes without a call, as when this machine was busy: the first frame
// afterwards is a stop frame.
TEST_F(SegwayProtocolTest, ACommandThatAgedUnnoticedIsNotSent) {
  MakeReady();
  Drive(200);
  ASSERT_TRUE(protocol_->SetVelocity(kArc, now_).ok());
  now_ += milliseconds(300);
  SendCycle();
  sent_.clear();
  Collect();
  ASSERT_EQ(sent_.size(), 1u);
  EXPECT_TRUE(sent_[0].IsStop());
}

TEST_F(SegwayProtocolTest, StopBrakesByTheLimit) {
  MakeReady();
  Drive(1000);
  sent_.clear();
  protocol_->Stop();
  Run(1000);
  // From 0.4 m/s by 1.5 m/s2: 0.27 s, which is 14 intervals.
  int moving = 0;
  int before = 161;
  for (const Sent& sent : sent_) {
    EXPECT_LT(sent.motion.velocity_counts, std::max(1, before));
    before = sent.motion.velocity_counts;
    moving += sent.IsStop() ? 0 : 1;
  }
  EXPECT_GE(moving, 12);
  EXPECT_LE(moving, 14);
}

TEST_F(SegwayProtocolTest, NanStopsAndIsRefused) {
  for (const double bad :
       {std::nan(""), std::numeric_limits<double>::infinity(),
        -std::numeric_limits<double>::infinity()}) {
    for (const core::VelocityCommand& command :
         {core::VelocityCommand{.forward_mps = bad, .yaw_rate_radps = 0},
          core::VelocityCommand{.forward_mps = 0, .yaw_rate_radps = bad}}) {
      MakeReady();
      Drive(500);
      EXPECT_EQ(protocol_->SetVelocity(command, now_).code(),
                absl::StatusCode::kInvalidArgument);
      Run(290);
      sent_.clear();
      Run(500);
      EXPECT_TRUE(OnlyStopsSent());
      EXPECT_EQ(protocol_->Statistics().expired_commands, 0);
    }
  }
}

TEST_F(SegwayProtocolTest, SilenceStopsAndIsReported) {
  MakeReady();
  Drive(400);
  talking_ = false;
  Run(250);
  EXPECT_EQ(protocol_->Health().state, core::DeviceState::kLost);
  EXPECT_EQ(protocol_->Health().losses, 1);
  EXPECT_THAT(std::string(protocol_->Health().cause.message()),
              HasSubstr("fallen silent"));
  EXPECT_EQ(protocol_->SetVelocity(kArc, now_).code(),
            absl::StatusCode::kUnavailable);
  sent_.clear();
  Run(1700);
  EXPECT_FALSE(protocol_->ShouldReopen(now_));
  EXPECT_GT(sent_.size(), 50u);
  EXPECT_TRUE(OnlyStopsSent());
  Run(100);
  EXPECT_TRUE(protocol_->ShouldReopen(now_));
  EXPECT_EQ(protocol_->Health().losses, 1);
}

TEST_F(SegwayProtocolTest, ADisconnectionIsReportedWithItsCause) {
  MakeReady();
  Drive(100);
  sent_.clear();
  protocol_->Disconnected(absl::NotFoundError("no /dev/ttyUSB0"), now_);
  EXPECT_EQ(protocol_->Health().state, core::DeviceState::kLost);
  EXPECT_EQ(protocol_->Health().cause, absl::NotFoundError("no /dev/ttyUSB0"));
  EXPECT_EQ(protocol_->SetVelocity(kArc, now_),
            absl::UnavailableError("no /dev/ttyUSB0"));
  SendCycle();
  Run(100);
  EXPECT_THAT(sent_, IsEmpty());
  EXPECT_THAT(protocol_->TakeReadings().size(), 10);
}

TEST_F(SegwayProtocolTest, AReconnectionConfiguresAgainButKeepsTheCounters) {
  MakeReady();
  cycle_.left_position = 5000;
  Run(100);
  protocol_->Disconnected(absl::UnavailableError("unplugged"), now_);
  Run(100);
  const double before_m = protocol_->TakeReadings().back().left_wheel_m;
  cycle_.left_position = 5401;  // it coasted on
  sent_.clear();
  protocol_->Connected(now_);
  Run(600);
  EXPECT_EQ(protocol_->Health().state, core::DeviceState::kRunning);
  int modes = 0;
  for (const Sent& sent : sent_) {
    EXPECT_NE(sent.motion.setting, SegwaySetting::kResetIntegrators);
    modes += sent.motion.setting == SegwaySetting::kMode ? 1 : 0;
  }
  EXPECT_EQ(modes, 2);
  EXPECT_NEAR(protocol_->TakeReadings().back().left_wheel_m - before_m,
              401 / kSegwayCountsPerMetre, 1e-12);
}

TEST_F(SegwayProtocolTest, DisabledMotorsForgetTheCommand) {
  MakeReady();
  Drive(400);
  SendPowerStatus(false);
  EXPECT_EQ(protocol_->SetVelocity(kArc, now_).code(),
            absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(protocol_->Health().cause.message()),
              HasSubstr("motors are disabled"));
  protocol_->TakeReadings();
  sent_.clear();
  Run(100);
  const std::vector<core::BaseReading> readings = protocol_->TakeReadings();
  ASSERT_FALSE(readings.empty());
  EXPECT_FALSE(readings.back().motors_enabled);
  SendPowerStatus(true);
  Run(100);
  EXPECT_TRUE(OnlyStopsSent());
  EXPECT_TRUE(protocol_->SetVelocity(kArc, now_).ok());
}

TEST_F(SegwayProtocolTest, PowerStatusOfTheOtherChannelIsNotHeeded) {
  MakeReady();
  Receive({.channel = kSegwayChannelB, .id = kSegwayPowerStatus});
  EXPECT_TRUE(protocol_->SetVelocity(kArc, now_).ok());
  Receive({.channel = kSegwayChannelA, .id = kSegwayPowerStatus});
  EXPECT_FALSE(protocol_->SetVelocity(kArc, now_).ok());
}

TEST_F(SegwayProtocolTest, ABaseThatLeavesItsModeIsStoppedAndPutBack) {
  MakeReady();
  Drive(400);
  cycle_.mode = 0;
  Run(20);
  EXPECT_EQ(protocol_->SetVelocity(kArc, now_).code(),
            absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(protocol_->Health().cause.message()),
              HasSubstr("left the mode 'tractor' and is in 'disabled'"));
  sent_.clear();
  Run(1600);
  EXPECT_EQ(cycle_.mode, kTractor);
  EXPECT_TRUE(OnlyStopsSent());
  EXPECT_TRUE(protocol_->SetVelocity(kArc, now_).ok());
}

TEST_F(SegwayProtocolTest, TheModeIsLeftAloneIfNotToBeRestored) {
  Restart({.restore_mode = false});
  MakeReady();
  cycle_.mode = 0;
  Run(5000);
  EXPECT_EQ(cycle_.mode, 0);
  EXPECT_EQ(protocol_->SetVelocity(kArc, now_).code(),
            absl::StatusCode::kFailedPrecondition);
}

TEST_F(SegwayProtocolTest, AnEmergencyStopHoldsUntilItIsReleased) {
  MakeReady();
  Drive(600);
  sent_.clear();
  protocol_->SetEmergencyStop(true);
  EXPECT_EQ(protocol_->SetVelocity(kArc, now_).code(),
            absl::StatusCode::kFailedPrecondition);
  Run(500);
  EXPECT_EQ(protocol_->Health().state, core::DeviceState::kRunning);
  protocol_->SetEmergencyStop(false);
  Run(100);
  EXPECT_TRUE(OnlyStopsSent());
  Drive(400);
  EXPECT_FALSE(OnlyStopsSent());
}

TEST_F(SegwayProtocolTest, ABaseThatTurnsTheWrongWayIsStoppedForGood) {
  MakeReady();
  int driven = 0;
  // To the left is asked for; the left wheel rolls on, the right one back.
  while (driven < 200 && protocol_->SetVelocity(kArc, now_).ok()) {
    ++driven;
    cycle_.left_position += 120;
    cycle_.right_position -= 120;
    Run(10);
  }
  // 0.1 rad of 0.54 m are 2170 counts, 10 cycles; after 0.5 s, and the ramp to
  // 0.1 rad/s.
  EXPECT_GE(driven, 50);
  EXPECT_LE(driven, 70);
  EXPECT_THAT(std::string(protocol_->Health().cause.message()),
              HasSubstr("turn_sign"));
  sent_.clear();
  Run(1000);
  EXPECT_TRUE(OnlyStopsSent());
  EXPECT_EQ(protocol_->SetVelocity(kArc, now_).code(),
            absl::StatusCode::kFailedPrecondition);
}

TEST_F(SegwayProtocolTest, WhatIsWrongWithTheLineIsSaid) {
  talking_ = false;
  Run(300);
  EXPECT_THAT(std::string(protocol_->Health().cause.message()),
              HasSubstr("sends nothing"));
  const uint8_t noise[] = {1, 2, 3};
  protocol_->Receive(noise, now_);
  Run(10);
  EXPECT_THAT(std::string(protocol_->Health().cause.message()),
              HasSubstr("baud rate"));
  SendPowerStatus(true);
  Run(10);
  EXPECT_THAT(std::string(protocol_->Health().cause.message()),
              HasSubstr("no whole status cycle"));
}

TEST_F(SegwayProtocolTest, CorruptCyclesAreCountedAndDoNotStopTheBase) {
  MakeReady();
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(protocol_->SetVelocity(kArc, now_).ok());
    const uint8_t noise[] = {0xF0, 0x55, 0x00};
    protocol_->Receive(noise, now_);
    Receive(ToMessages(cycle_, channel_)[3]);
    Run(20);
  }
  EXPECT_EQ(protocol_->Health().state, core::DeviceState::kRunning);
  EXPECT_GT(protocol_->Statistics().discarded_bytes, 0);
  EXPECT_FALSE(OnlyStopsSent());
}

TEST_F(SegwayProtocolTest, HeartbeatsAreCounted) {
  MakeReady();
  Receive({.channel = channel_, .id = kSegwayHeartbeat});
  EXPECT_EQ(protocol_->Statistics().heartbeats, 1);
}

TEST(SegwayOptions, OptionsThatAreNoneAreRefused) {
  EXPECT_TRUE(SegwayOptions{}.Validate().ok());
  const SegwayOptions bad[] = {
      {.wire = {.turn_sign = 0}},
      {.receive_channel = 0},
      {.mode = SegwayMode::kOff},
      {.gain_schedule = 3},
      {.max_velocity_scale = 0},
      {.max_turn_scale = 17},
      {.current_limit_scale = 257},
      {.command_interval_s = 0.3},
      {.command_interval_s = std::nan("")},
      {.link_timeout_s = 1},
      {.reopen_after_s = 0},
  };
  for (const SegwayOptions& options : bad) {
    EXPECT_EQ(options.Validate().code(), absl::StatusCode::kInvalidArgument);
  }
}

}  // namespace
}  // namespace treeline::segway
