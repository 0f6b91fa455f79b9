// The driver against the emulated sensor, over real pseudo terminals and TCP.
#include <unistd.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/drivers/hokuyo/hokuyo_laser.h"
#include "nav_agent/drivers/stream/stream_address.h"
#include "simulation/emulators/emulator_server.h"
#include "simulation/emulators/hokuyo_emulator.h"
#include "simulation/emulators/laser_source.h"
#include "simulation/emulators/testing_laser.h"

namespace treeline::emulators {
namespace {

using testing::HasSubstr;

constexpr RoomOptions kRoom = {
    .width_m = 8, .depth_m = 6, .laser_x_m = 1.5, .laser_y_m = -0.7};

DeviceFaultPlan Plan(const std::vector<std::string>& faults) {
  DeviceFaultPlan plan;
  for (const std::string& fault : faults) {
    EXPECT_TRUE(plan.Add(fault).ok()) << fault;
  }
  return plan;
}

// Fast enough for tests; a real sensor needs more patience.
hokuyo::HokuyoOptions Impatient() {
  hokuyo::HokuyoOptions options;
  options.reply_timeout_s = 0.3;
  options.silence_timeout_s = 0.4;
  options.backoff = {.first_s = 0.02, .longest_s = 0.1};
  return options;
}

// Both ends of a wire.
class Loop {
 public:
  explicit Loop(const std::string& listen,
                const hokuyo::HokuyoOptions& options = {},
                const HokuyoEmulatorOptions& sensor = {},
                const std::vector<std::string>& faults = {})
      : sensor_options_(sensor), listen_(listen) {
    StartSensor(faults);
    StartDriver(options);
  }

  void StartSensor(const std::vector<std::string>& faults = {}) {
    emulator_ =
        std::make_unique<HokuyoEmulator>(sensor_options_, room_, clock_.Now());
    auto listen = ParseDeviceAddress(listen_);
    ASSERT_TRUE(listen.ok()) << listen.status();
    auto server = EmulatorServer::Start(
        {.listen = *listen, .faults = Plan(faults), .seed = 3}, *emulator_,
        clock_);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    // The same port again, should it be started anew.
    if (std::holds_alternative<base::ListenAddress>(*listen)) {
      listen_ = "tcp:" + server_->address().substr(14);
    }
  }
  void StopSensor() { server_.reset(); }
  void ReplaceSensor(const HokuyoEmulatorOptions& sensor) {
    StopSensor();
    sensor_options_ = sensor;
    StartSensor();
  }

  void StartDriver(const hokuyo::HokuyoOptions& options) {
    auto opener = stream::ParseStreamAddress(server_->address(), 115200);
    ASSERT_TRUE(opener.ok()) << opener.status();
    auto laser =
        hokuyo::HokuyoLaser::Start(options, *std::move(opener), clock_);
    ASSERT_TRUE(laser.ok()) << laser.status();
    laser_ = *std::move(laser);
  }
  void StopDriver() { laser_.reset(); }

  hokuyo::HokuyoLaser& laser() { return *laser_; }
  EmulatorServer& server() { return *server_; }

  // Waits for `count` scans, and checks each.
  std::vector<core::LaserScan> Scans(size_t count) {
    std::vector<core::LaserScan> scans;
    EXPECT_TRUE(Eventually([&] {
      for (core::LaserScan& scan : laser_->TakeScans()) {
        scans.push_back(std::move(scan));
      }
      return scans.size() >= count;
    })) << "got "
        << scans.size() << "; " << laser_->Health().cause;
    for (const core::LaserScan& scan : scans) ExpectTheRoom(scan);
    return scans;
  }

  bool BecomesLost() {
    return Eventually(
        [&] { return laser_->Health().state == core::DeviceState::kLost; });
  }

 private:
  // Not a single range may be wrong: to half a millimetre, as they are sent.
  void ExpectTheRoom(const core::LaserScan& scan) {
    const core::RangeSensorInfo info = laser_->Info();
    ASSERT_EQ(static_cast<int>(scan.ranges_m.size()), info.beams);
    for (int beam = 0; beam < info.beams; ++beam) {
      ASSERT_NEAR(scan.ranges_m[static_cast<size_t>(beam)],
                  DistanceToWall_m(kRoom, info.AngleOf_rad(beam)), 0.000502)
          << "beam " << beam;
    }
  }

  base::SteadyClock clock_;
  RoomLaserSource room_{kRoom};
  HokuyoEmulatorOptions sensor_options_;
  std::string listen_;
  std::unique_ptr<HokuyoEmulator> emulator_;
  std::unique_ptr<EmulatorServer> server_;
  std::unique_ptr<hokuyo::HokuyoLaser> laser_;
};

// Stamps differ by whole turns, but for what they are rounded to and what is
// learned about delays. On a busy machine scans may be missing, and a better
// idea of the least delay may shift a few stamps by more.
bool AreWholeTurnsApart(const std::vector<core::LaserScan>& scans) {
  size_t others = 0;
  for (size_t i = 1; i < scans.size(); ++i) {
    const double turns =
        base::MillisecondsBetween(scans[i - 1].stamp, scans[i].stamp) / 25;
    if (turns < 0.5 || std::abs(turns - std::round(turns)) > 0.1) ++others;
  }
  return others <= scans.size() / 10;
}

std::string FreshLink() {
  static int count = 0;
  return testing::TempDir() + "/ttyLaser_" + std::to_string(getpid()) + "_" +
         std::to_string(count++);
}

class HokuyoLoopTest : public testing::TestWithParam<const char*> {
 protected:
  static std::string Listen() {
    return std::string(GetParam()) == "pty" ? "pty:" + FreshLink() : "tcp:0";
  }
};

INSTANTIATE_TEST_SUITE_P(Wires, HokuyoLoopTest, testing::Values("pty", "tcp"),
                         [](const auto& wire) {
                           return std::string(wire.param);
                         });

TEST_P(HokuyoLoopTest, ScansArriveWholeAndInTime) {
  Loop loop(Listen());
  const auto scans = loop.Scans(20);
  const core::RangeSensorInfo info = loop.laser().Info();
  EXPECT_EQ(info.beams, 1081);
  EXPECT_NEAR(info.angle_min_rad, -2.356194, 1e-6);
  EXPECT_NEAR(info.angle_increment_rad, 0.00436332, 1e-8);
  EXPECT_NEAR(info.scan_interval_s, 0.025, 1e-9);
  EXPECT_EQ(info.range_max_m, 30);
  EXPECT_TRUE(AreWholeTurnsApart(scans));
  const core::DeviceHealth health = loop.laser().Health();
  EXPECT_EQ(health.state, core::DeviceState::kRunning);
  EXPECT_TRUE(health.cause.ok());
  EXPECT_EQ(health.corrupt, 0);
  EXPECT_EQ(health.losses, 0);
  EXPECT_EQ(loop.laser().Version()->serial, "H0000001");
}

TEST_P(HokuyoLoopTest, IntensitiesComeWithTheRanges) {
  hokuyo::HokuyoOptions options;
  options.intensities = true;
  Loop loop(Listen(), options);
  for (const core::LaserScan& scan : loop.Scans(3)) {
    ASSERT_EQ(scan.intensities.size(), scan.ranges_m.size());
    // 4000 over the distance; ahead of the laser it is 2.5 m.
    EXPECT_NEAR(scan.intensities[540], 1600, 1);
  }
}

TEST_P(HokuyoLoopTest, SingleShotsComeOnceATurn) {
  hokuyo::HokuyoOptions options;
  options.single_shot = true;
  options.angle_min_rad = -1;
  options.angle_max_rad = 1;
  options.cluster = 1;
  Loop loop(Listen(), options);
  const auto scans = loop.Scans(10);
  EXPECT_EQ(loop.laser().Info().beams, 2 * 229 + 1);
  for (size_t i = 1; i < scans.size(); ++i) {
    EXPECT_GT(base::MillisecondsBetween(scans[i - 1].stamp, scans[i].stamp),
              20);
  }
}

TEST_P(HokuyoLoopTest, SplitAndMergedWritesMakeNoDifference) {
  Loop loop(Listen(), {}, {}, {"split:7", "merge:0.06"});
  loop.Scans(8);
  EXPECT_EQ(loop.laser().Health().corrupt, 0);
}

TEST_P(HokuyoLoopTest, NoBrokenScanGetsThrough) {
  // Every third scan is hit, about.
  Loop loop(Listen(), {}, {}, {"corrupt:0.0001@0.5"});
  loop.Scans(30);
  EXPECT_TRUE(Eventually([&] { return loop.laser().Health().corrupt > 5; }));
  loop.Scans(10);
}

TEST_P(HokuyoLoopTest, LostBytesCostTheirScanAlone) {
  Loop loop(Listen(), {}, {}, {"drop:0.0002@0.5"});
  loop.Scans(30);
  EXPECT_TRUE(Eventually([&] { return loop.laser().Health().corrupt > 5; }));
  loop.Scans(10);
}

TEST_P(HokuyoLoopTest, ComesBackAfterItWasUnplugged) {
  Loop loop(Listen(), Impatient());
  loop.Scans(3);
  loop.server().SetFaults(Plan({"unplug"}));
  ASSERT_TRUE(loop.BecomesLost());
  EXPECT_FALSE(loop.laser().Health().cause.ok());
  EXPECT_THAT(std::string(loop.laser().Health().cause.message()),
              HasSubstr("laser "));
  loop.laser().TakeScans();
  loop.server().SetFaults({});
  loop.Scans(3);
  EXPECT_GE(loop.laser().Health().losses, 1);
}

TEST_P(HokuyoLoopTest, ComesBackAfterItsProgramWasKilled) {
  Loop loop(Listen(), Impatient());
  loop.Scans(3);
  loop.StopSensor();
  ASSERT_TRUE(loop.BecomesLost());
  loop.laser().TakeScans();
  loop.StartSensor();
  loop.Scans(3);
}

TEST_P(HokuyoLoopTest, NoticesSilenceAndRecovers) {
  Loop loop(Listen(), Impatient());
  loop.Scans(3);
  loop.server().SetFaults(Plan({"stuck"}));
  ASSERT_TRUE(loop.BecomesLost());
  loop.server().SetFaults({});
  loop.laser().TakeScans();
  loop.Scans(3);
  EXPECT_GE(loop.laser().Health().losses, 1);
}

TEST_P(HokuyoLoopTest, SurvivesASensorThatSendsNothingButNoise) {
  Loop loop(Listen(), Impatient());
  loop.Scans(3);
  loop.server().SetFaults(Plan({"garbage"}));
  ASSERT_TRUE(loop.BecomesLost());
  loop.laser().TakeScans();
  loop.server().SetFaults({});
  loop.Scans(3);
}

TEST_P(HokuyoLoopTest, TellsThatTheHardwareIsBroken) {
  Loop loop(Listen(), Impatient());
  loop.Scans(3);
  loop.server().SetFaults(Plan({"error:52"}));
  // First that it is so, then why.
  ASSERT_TRUE(Eventually([&] {
    const absl::Status cause = loop.laser().Health().cause;
    return absl::IsFailedPrecondition(cause) &&
           absl::StrContains(cause.message(), "Trouble!! Error No. =[52]");
  })) << loop.laser().Health().cause;
  loop.laser().TakeScans();
  loop.server().SetFaults({});
  loop.Scans(3);
}

TEST_P(HokuyoLoopTest, WaitsWhileTheSensorChecksItself) {
  hokuyo::HokuyoOptions options;
  options.silence_timeout_s = 5;
  options.reply_timeout_s = 5;
  Loop loop(Listen(), options);
  loop.Scans(3);
  loop.server().SetFaults(Plan({"error:21"}));
  ASSERT_TRUE(loop.BecomesLost());
  EXPECT_THAT(std::string(loop.laser().Health().cause.message()),
              HasSubstr("check itself"));
  loop.laser().TakeScans();
  loop.server().SetFaults({});
  loop.Scans(3);
  // It was one session all along.
  EXPECT_EQ(loop.laser().Health().losses, 1);
}

TEST_P(HokuyoLoopTest, ItsStampsFollowASensorClockThatRunsFast) {
  HokuyoEmulatorOptions sensor;
  // Wraps after two seconds.
  sensor.first_time_ms = hokuyo::kScipTimeSpan_ms - 2000;
  Loop loop(Listen(), {}, sensor, {"skew:500"});
  const base::MonotonicTime begin = base::SteadyClock().Now();
  std::vector<core::LaserScan> scans;
  while (base::MillisecondsBetween(begin, base::SteadyClock().Now()) < 3500) {
    for (core::LaserScan& scan : loop.Scans(1)) {
      // Arrived after its end, and not long ago unless this machine is busy.
      const double age_ms =
          base::MillisecondsBetween(scan.stamp, base::SteadyClock().Now());
      EXPECT_GT(age_ms, 18.75 - 3);
      scans.push_back(std::move(scan));
    }
  }
  EXPECT_EQ(loop.laser().Health().losses, 0);
  EXPECT_TRUE(AreWholeTurnsApart(scans));
}

TEST(HokuyoStartTest, StartsWhileTheSensorStillSendsForSomeoneElse) {
  Loop loop("pty:" + FreshLink());
  loop.Scans(2);
  // A driver that died without a word: its stream is gone, the scans go on.
  loop.StopDriver();
  // Counted from here: what nobody reads fits into the terminal's buffer for
  // half a second only, which a busy machine may spend before the next line.
  const int64_t sent = loop.server().sent();
  {
    auto opener = stream::ParseStreamAddress(loop.server().address(), 115200);
    auto stream = (*opener)->Open({});
    ASSERT_TRUE(stream.ok());
    ASSERT_TRUE((*stream)
                    ->Write(stream::AsBytes("MD0000108000000\nVV"),
                            std::chrono::seconds(1))
                    .ok());
  }
  ASSERT_TRUE(Eventually([&] { return loop.server().sent() > sent + 8000; }));
  loop.StartDriver(Impatient());
  loop.Scans(3);
}

TEST(HokuyoStartTest, StartsWithASensorThatWasLeftInTimeMode) {
  Loop loop("pty:" + FreshLink());
  loop.Scans(1);
  loop.StopDriver();
  {
    auto opener = stream::ParseStreamAddress(loop.server().address(), 115200);
    auto stream = (*opener)->Open({});
    ASSERT_TRUE(stream.ok());
    ASSERT_TRUE(
        (*stream)
            ->Write(stream::AsBytes("QT\nTM0\n"), std::chrono::seconds(1))
            .ok());
    std::vector<uint8_t> reply(64);
    ASSERT_TRUE((*stream)->Read(reply, std::chrono::seconds(10), {}).ok());
  }
  loop.StartDriver(Impatient());
  loop.Scans(3);
}

TEST(HokuyoStartTest, SwitchesTheLaserOffAtTheEnd) {
  Loop loop("tcp:0");
  loop.Scans(2);
  loop.StopDriver();
  int64_t sent = -1;
  // Nothing more comes: three turns without a byte.
  EXPECT_TRUE(Eventually([&] {
    const int64_t before = std::exchange(sent, loop.server().sent());
    std::this_thread::sleep_for(std::chrono::milliseconds(75));
    return before == sent;
  }));
}

TEST(HokuyoStartTest, IsLostUntilThereIsASensor) {
  const base::SteadyClock clock;
  auto opener = stream::ParseStreamAddress("/dev/ttyNoSuchLaser", 115200);
  ASSERT_TRUE(opener.ok());
  auto laser =
      hokuyo::HokuyoLaser::Start(Impatient(), *std::move(opener), clock);
  ASSERT_TRUE(laser.ok());
  ASSERT_TRUE(Eventually(
      [&] { return (*laser)->Health().state == core::DeviceState::kLost; }));
  EXPECT_TRUE(absl::IsNotFound((*laser)->Health().cause));
  EXPECT_EQ((*laser)->Health().losses, 0);
  EXPECT_TRUE((*laser)->TakeScans().empty());
}

TEST(HokuyoStartTest, RefusesASensorWhoseScansMeanSomethingElse) {
  Loop loop("pty:" + FreshLink(), Impatient());
  loop.Scans(1);
  HokuyoEmulatorOptions other;
  other.parameters.front_step = 500;
  loop.ReplaceSensor(other);
  ASSERT_TRUE(Eventually(
      [&] { return absl::IsFailedPrecondition(loop.laser().Health().cause); }));
  EXPECT_THAT(std::string(loop.laser().Health().cause.message()),
              HasSubstr("another sensor"));
  loop.laser().TakeScans();
  loop.ReplaceSensor({});
  loop.Scans(3);
}

TEST(HokuyoStartTest, RefusesBadOptions) {
  const base::SteadyClock clock;
  hokuyo::HokuyoOptions options;
  options.cluster = 0;
  EXPECT_TRUE(absl::IsInvalidArgument(
      hokuyo::HokuyoLaser::Start(options, nullptr, clock).status()));
}

TEST(HokuyoStartTest, KeepsNoMoreThanTheNewestScans) {
  Loop loop("tcp:0");
  ASSERT_TRUE(Eventually([&] { return loop.laser().Health().dropped > 2; }));
  EXPECT_EQ(loop.laser().TakeScans().size(),
            static_cast<size_t>(core::kMaxWaiting));
}

}  // namespace
}  // namespace treeline::emulators
