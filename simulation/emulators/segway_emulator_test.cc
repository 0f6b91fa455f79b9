// The driver's protocol against the emulated base, on a clock of their own.
#include "simulation/emulators/segway_emulator.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/drivers/segway/segway_protocol.h"

namespace treeline::emulators {
namespace {

using std::chrono::milliseconds;

constexpr double kCount_m = 1 / segway::kSegwayCountsPerMetre;
constexpr core::VelocityCommand kArc = {.forward_mps = 0.5,
                                        .yaw_rate_radps = 0.6};

class SegwayEmulatorTest : public ::testing::Test {
 protected:
  void SetUp() override { Restart({}, {}); }
  void Restart(const segway::SegwayOptions& driver,
               const SegwayEmulatorOptions& base) {
    ASSERT_TRUE(driver.Validate().ok());
    ASSERT_TRUE(base.Validate().ok());
    plant_ = std::make_unique<FlatFloorPlant>(0.54);
    base_.emplace(base, *plant_, now_);
    driver_.emplace(driver);
    driver_->Connected(now_);
  }

  // Both sides, a millisecond after another.
  void Run(int ms) {
    for (int i = 0; i < ms; ++i) {
      now_ += milliseconds(1);
      const std::vector<uint8_t> commands = driver_->Send(now_);
      if (!commands.empty()) base_->Receive(commands, now_);
      const std::vector<uint8_t> status = base_->Advance(now_);
      if (!status.empty()) driver_->Receive(status, now_);
      for (const core::BaseReading& reading : driver_->TakeReadings()) {
        readings_.push_back(reading);
      }
      truth_.push_back(base_->state());
    }
  }
  void MakeReady() {
    Run(700);
    ASSERT_EQ(driver_->Health().state, core::DeviceState::kRunning)
        << driver_->Health().cause;
    readings_.clear();
  }
  void Drive(const core::VelocityCommand& command, int ms) {
    for (int i = 0; i < ms; i += 50) {
      ASSERT_TRUE(driver_->SetVelocity(command, now_).ok());
      Run(50);
    }
  }
  double TurnRate() const { return base_->state().yaw_rate_radps; }

  base::MonotonicTime now_{std::chrono::hours(2)};
  std::unique_ptr<BasePlant> plant_;
  std::optional<SegwayEmulator> base_;
  std::optional<segway::SegwayProtocol> driver_;
  std::vector<core::BaseReading> readings_;
  std::vector<BasePlantState> truth_;
};

// Positions are whole counts, so a difference is exact to one of them; the
// speeds lose less than a count each on the way to the base.
TEST_F(SegwayEmulatorTest, DrivesAnArcAndItsOdometryAgrees) {
  MakeReady();
  const BasePlantState begin = base_->state();
  Run(20);
  const core::BaseReading first = readings_.back();
  Drive(kArc, 5000);
  EXPECT_NEAR(base_->state().left_wheel_mps, 0.5 - 0.27 * 0.6,
              1 / segway::kSegwayCountsPerMps + 0.27 * 0.0023);
  EXPECT_NEAR(TurnRate(), 0.6, 1 / (segway::kSegwayCountsPerDegree * 57.2));
  Run(2000);
  const BasePlantState end = base_->state();
  EXPECT_GT(end.right_wheel_m - begin.right_wheel_m, 2.5);
  const core::BaseReading last = readings_.back();
  EXPECT_NEAR(last.left_wheel_m - first.left_wheel_m,
              end.left_wheel_m - begin.left_wheel_m, kCount_m);
  EXPECT_NEAR(last.right_wheel_m - first.right_wheel_m,
              end.right_wheel_m - begin.right_wheel_m, kCount_m);
  EXPECT_EQ(last.forward_mps, 0);
  // The turn: rates are measured to 1 / 7.8 deg/s, 100 times a second.
  double turned_rad = 0;
  for (const core::BaseReading& reading : readings_) {
    turned_rad += reading.yaw_rate_radps * 0.01;
  }
  const double true_rad = (end.right_wheel_m - end.left_wheel_m -
                           begin.right_wheel_m + begin.left_wheel_m) /
                          0.54;
  const double count_radps =
      std::numbers::pi / 180 / segway::kSegwayCountsPerDegree;
  EXPECT_NEAR(turned_rad, true_rad, 0.5 * count_radps * 7);
}

TEST_F(SegwayEmulatorTest, NothingIsLostOnACleanLine) {
  MakeReady();
  Drive(kArc, 10000);
  EXPECT_EQ(driver_->Health().corrupt, 0);
  EXPECT_EQ(driver_->Health().dropped, 0);
  EXPECT_EQ(readings_.size(), 1000u);
  EXPECT_EQ(driver_->Statistics().discarded_bytes, 0);
  EXPECT_EQ(base_->counts().too_soon, 0);
  EXPECT_EQ(base_->counts().too_late, 0);
  EXPECT_EQ(base_->counts().broken_commands, 0);
  for (size_t i = 1; i < readings_.size(); ++i) {
    EXPECT_EQ(readings_[i].stamp - readings_[i - 1].stamp, milliseconds(10));
  }
}

TEST_F(SegwayEmulatorTest, EveryVariantOfTheWireDrivesTheSameArc) {
  for (const auto scale : {segway::SegwayWire::TurnScale::kPerDegree,
                           segway::SegwayWire::TurnScale::kPerHalfTurn}) {
    for (const int turn : {1, -1}) {
      for (const int rate : {1, -1}) {
        for (const uint8_t channel :
             {segway::kSegwayChannelA, segway::kSegwayChannelB}) {
          const segway::SegwayWire wire = {.turn_scale = scale,
                                           .turn_sign = turn,
                                           .yaw_rate_sign = rate,
                                           .pitch_sign = -1,
                                           .transmit_channel = channel};
          Restart({.wire = wire, .receive_channel = channel},
                  {.wire = wire, .channel = channel});
          MakeReady();
          Drive(kArc, 2000);
          // To the left, within a count of the coarser scale.
          EXPECT_NEAR(TurnRate(), 0.6, 1 / 325.0);
          EXPECT_NEAR(readings_.back().yaw_rate_radps, 0.6, 2 / 325.0);
          EXPECT_GT(readings_.back().right_wheel_m,
                    readings_.back().left_wheel_m);
        }
      }
    }
  }
}

// What someone sees whose driver has another idea of the wire than the base.
TEST_F(SegwayEmulatorTest, AWrongTurnSignTurnsTheOtherWayAndIsNoticed) {
  Restart({.wire = {.turn_sign = -1}}, {.wire = {.turn_sign = 1}});
  MakeReady();
  Drive(kArc, 500);
  EXPECT_NEAR(TurnRate(), -0.6, 1 / 325.0);
  // Noticed half a second after 0.1 rad/s were asked for, and 0.1 rad later.
  ASSERT_TRUE(driver_->SetVelocity(kArc, now_).ok());
  Run(290);
  EXPECT_EQ(driver_->SetVelocity(kArc, now_).code(),
            absl::StatusCode::kFailedPrecondition);
  Run(1000);
  EXPECT_EQ(TurnRate(), 0);
}

TEST_F(SegwayEmulatorTest, AWrongChannelIsReported) {
  Restart({.receive_channel = segway::kSegwayChannelA},
          {.channel = segway::kSegwayChannelB});
  Run(1000);
  EXPECT_EQ(driver_->Health().state, core::DeviceState::kStarting);
  EXPECT_NE(std::string(driver_->Health().cause.message()).find("channel"),
            std::string::npos);
}

TEST_F(SegwayEmulatorTest, StopsWhenNobodyCommands) {
  MakeReady();
  Drive(kArc, 2000);
  // 300 ms of it are over when the last command is 50 ms old... and the base
  // needs (0.5 m/s) / (1.5 m/s2) to brake.
  Run(250 + 20 + 340 + 10);
  EXPECT_EQ(base_->state().left_wheel_mps, 0);
  EXPECT_EQ(base_->state().right_wheel_mps, 0);
  EXPECT_EQ(base_->counts().too_late, 0);
}

TEST_F(SegwayEmulatorTest, CoastsToAStopWhenTheLineIsCut) {
  MakeReady();
  Drive(kArc, 2000);
  base_->SetFaults({.unplugged = true});
  Run(350);
  EXPECT_GT(base_->state().left_wheel_mps, 0.3);
  Run(400 - 350 + 340 + 10);
  EXPECT_EQ(base_->state().left_wheel_mps, 0);
  EXPECT_EQ(driver_->Health().state, core::DeviceState::kLost);
  // Plugged in again: configured again, and what it coasted is in the readings.
  base_->SetFaults({});
  Run(1000);
  EXPECT_EQ(driver_->Health().state, core::DeviceState::kRunning);
  EXPECT_EQ(base_->state().left_wheel_mps, 0);
  EXPECT_NEAR(readings_.back().left_wheel_m, base_->state().left_wheel_m,
              kCount_m);
}

TEST_F(SegwayEmulatorTest, SplitAndMergedDeliveriesChangeNothing) {
  for (const SegwayFaults& faults :
       {SegwayFaults{.split = 1}, SegwayFaults{.merge_s = 0.08},
        SegwayFaults{.split = 0.7, .merge_s = 0.033}}) {
    Restart({}, {});
    MakeReady();
    base_->SetFaults(faults);
    Drive(kArc, 3000);
    base_->SetFaults({});
    Run(500);
    EXPECT_EQ(readings_.size(), 350u);
    EXPECT_EQ(driver_->Health().corrupt, 0);
    EXPECT_NEAR(readings_.back().left_wheel_m, base_->state().left_wheel_m,
                kCount_m);
    for (size_t i = 1; i < readings_.size(); ++i) {
      // Whatever they waited; the quickest of a second's hundred arrivals is
      // less than 5 ms late.
      EXPECT_NEAR(
          base::MillisecondsBetween(readings_[i - 1].stamp, readings_[i].stamp),
          10, 5);
    }
  }
}

// A disturbed line: it drives on, loses only the cycles that were hit, and its
// wheels stay right.
TEST_F(SegwayEmulatorTest, DrivesOverADisturbedLine) {
  for (uint64_t seed = 0; seed < 5; ++seed) {
    Restart({}, {.seed = seed});
    MakeReady();
    base_->SetFaults({.corrupt = 0.01,
                      .drop_byte = 0.01,
                      .drop_frame = 0.01,
                      .corrupt_command = 0.1,
                      .split = 0.3});
    Drive(kArc, 5000);
    EXPECT_EQ(driver_->Health().state, core::DeviceState::kRunning);
    // 8 frames, 3 % each: 22 % of the cycles, of 500; sigma is 9.
    EXPECT_NEAR(static_cast<double>(driver_->Health().corrupt), 108, 45);
    EXPECT_NEAR(static_cast<double>(readings_.size()), 392, 45);
    EXPECT_NEAR(TurnRate(), 0.6, 1 / 325.0);
    base_->SetFaults({});
    Run(100);
    EXPECT_NEAR(readings_.back().left_wheel_m, base_->state().left_wheel_m,
                kCount_m);
    EXPECT_NEAR(readings_.back().right_wheel_m, base_->state().right_wheel_m,
                kCount_m);
  }
}

TEST_F(SegwayEmulatorTest, DisabledMotorsAreReportedAndDoNotDrive) {
  MakeReady();
  Drive(kArc, 1000);
  base_->SetFaults({.motors_disabled = true});
  Run(20);
  EXPECT_EQ(driver_->SetVelocity(kArc, now_).code(),
            absl::StatusCode::kFailedPrecondition);
  EXPECT_FALSE(readings_.back().motors_enabled);
  Run(1000);
  EXPECT_EQ(base_->state().left_wheel_mps, 0);
  base_->SetFaults({});
  Run(200);
  EXPECT_EQ(base_->state().left_wheel_mps, 0);
  Drive(kArc, 1000);
  EXPECT_GT(base_->state().left_wheel_mps, 0.3);
}

TEST_F(SegwayEmulatorTest, AStuckWheelStandsAndItsCounterToo) {
  MakeReady();
  Run(20);
  base_->SetFaults({.stuck_left_wheel = true});
  const double before_m = base_->state().left_wheel_m;
  Drive({.forward_mps = 0.4, .yaw_rate_radps = 0}, 2000);
  EXPECT_NEAR(base_->state().left_wheel_m, before_m, 1e-12);
  EXPECT_NEAR(readings_.back().forward_mps, 0.2,
              1 / segway::kSegwayCountsPerMps);
  EXPECT_NEAR(TurnRate(), 0.4 / 0.54, 0.01);
}

TEST_F(SegwayEmulatorTest, TheBatteryRunsDown) {
  Restart({}, {.battery_v = 72, .battery_drain_v = 360});
  MakeReady();
  Run(10000);
  // 0.1 V a second, sent in quarters.
  EXPECT_NEAR(readings_.back().battery_v, 72 - 1.07, 0.13);
}

TEST_F(SegwayEmulatorTest, CountsWhatDriversDoWrong) {
  const std::vector<uint8_t> frame = driver_->Send(now_);
  base_->Receive(frame, now_);
  base_->Receive(frame, now_ + milliseconds(5));
  base_->Receive(frame, now_ + milliseconds(600));
  const uint8_t noise[] = {1, 2, 3};
  base_->Receive(noise, now_ + milliseconds(610));
  EXPECT_EQ(base_->counts().commands, 3);
  EXPECT_EQ(base_->counts().too_soon, 1);
  EXPECT_EQ(base_->counts().too_late, 1);
  EXPECT_EQ(base_->counts().broken_commands, 1);
}

TEST_F(SegwayEmulatorTest, TheSameSeedGivesTheSameBytes) {
  const auto bytes_of = [](uint64_t seed) {
    FlatFloorPlant plant(0.54);
    const base::MonotonicTime start;
    SegwayEmulator base({.mode = segway::SegwayMode::kTractor, .seed = seed},
                        plant, start);
    base.SetFaults({.corrupt = 0.2, .drop_byte = 0.2, .split = 0.5});
    std::vector<uint8_t> all;
    for (int ms = 0; ms < 2000; ++ms) {
      const auto bytes = base.Advance(start + milliseconds(ms));
      all.insert(all.end(), bytes.begin(), bytes.end());
    }
    return all;
  };
  EXPECT_EQ(bytes_of(3), bytes_of(3));
  EXPECT_NE(bytes_of(3), bytes_of(4));
}

TEST_F(SegwayEmulatorTest, ShutDownEndsTheConversation) {
  MakeReady();
  const segway::SegwayFrame frame =
      segway::EncodeToBase({.id = segway::kSegwayShutDown});
  base_->Receive(frame, now_);
  EXPECT_EQ(base_->mode(), segway::SegwayMode::kOff);
  base_->Advance(now_);
  EXPECT_TRUE(base_->Advance(now_ + std::chrono::seconds(1)).empty());
}

TEST(SegwayEmulatorOptions, OptionsThatAreNoneAreRefused) {
  EXPECT_FALSE(SegwayEmulatorOptions{.channel = 3}.Validate().ok());
  EXPECT_FALSE(SegwayEmulatorOptions{.wheel_track_m = 0}.Validate().ok());
  EXPECT_FALSE(SegwayEmulatorOptions{.battery_drain_v = -1}.Validate().ok());
  EXPECT_FALSE(SegwayFaults{.corrupt = 1.1}.Validate().ok());
  EXPECT_FALSE(SegwayFaults{.split = std::nan("")}.Validate().ok());
  EXPECT_FALSE(SegwayFaults{.merge_s = -1}.Validate().ok());
}

}  // namespace
}  // namespace treeline::emulators
