// The whole driver against the emulated base over a real pseudo terminal, in
// real time: that threads, ports and reconnection hold together. What needs
// exact times is tested without any in segway_protocol_test.cc and
// segway_emulator_test.cc.
#include <unistd.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "gtest/gtest.h"
#include "nav_agent/drivers/segway/segway_base.h"
#include "nav_agent/drivers/stream/serial_port.h"
#include "simulation/emulators/emulator_server.h"
#include "simulation/emulators/fault_plan.h"
#include "simulation/emulators/segway_device.h"

namespace treeline::emulators {
namespace {

// An emulated base that EmulatorServer plugs in and pulls out.
class PluggableBase {
 public:
  PluggableBase(const std::string& link, const base::Clock& clock)
      : device_({}, plant_, clock.Now()) {
    EmulatorServerOptions options;
    options.listen = PtyAddress{.symlink = link};
    auto server = EmulatorServer::Start(options, device_, clock);
    EXPECT_TRUE(server.ok()) << server.status();
    if (server.ok()) server_ = *std::move(server);
  }

  void Unplug() {
    DeviceFaultPlan plan;
    ASSERT_TRUE(plan.Add("unplug").ok());
    server_->SetFaults(plan);
  }
  void Plug() { server_->SetFaults({}); }
  // Ends it.
  const SegwayEmulator& End() {
    server_.reset();
    return device_.emulator();
  }

 private:
  FlatFloorPlant plant_{0.54};
  SegwayDevice device_;
  std::unique_ptr<EmulatorServer> server_;
};

class SegwayPtyTest : public ::testing::Test {
 protected:
  SegwayPtyTest()
      : link_(::testing::TempDir() + "/ttySegway." + std::to_string(getpid())) {
  }

  // Drives while it waits, as an agent would. Far longer than it takes.
  template <typename Condition>
  bool DriveUntil(segway::SegwayBase& base, const Condition& condition) {
    const absl::Time deadline = absl::Now() + absl::Seconds(20);
    while (!condition()) {
      if (absl::Now() > deadline) return false;
      base.SetVelocity({.forward_mps = 0.4, .yaw_rate_radps = 0.3})
          .IgnoreError();
      for (const core::BaseReading& reading : base.TakeReadings())
        last_ = reading;
      absl::SleepFor(absl::Milliseconds(5));
    }
    return true;
  }

  base::SteadyClock clock_;
  std::string link_;
  core::BaseReading last_;
};

TEST_F(SegwayPtyTest, DrivesLosesItsCableAndDrivesAgain) {
  PluggableBase device(link_, clock_);
  auto base = segway::SegwayBase::Create(
      {},
      std::make_unique<stream::SerialPortOpener>(stream::SerialPortOptions{
          .path = link_, .baud = segway::kSegwayBaud}),
      clock_);
  ASSERT_TRUE(base.ok()) << base.status();
  segway::SegwayBase& driver = **base;

  ASSERT_TRUE(DriveUntil(driver, [&] { return last_.right_wheel_m > 0.1; }))
      << driver.Health().cause;
  EXPECT_EQ(driver.Health().losses, 0);
  EXPECT_EQ(driver.Health().corrupt, 0);

  device.Unplug();
  ASSERT_TRUE(DriveUntil(driver, [&] {
    return driver.Health().state == core::DeviceState::kLost;
  }));
  EXPECT_EQ(driver.SetVelocity({}).code(), absl::StatusCode::kUnavailable);
  const double at_unplugging_m = last_.right_wheel_m;

  device.Plug();
  ASSERT_TRUE(DriveUntil(driver, [&] {
    return last_.right_wheel_m > at_unplugging_m + 0.1 &&
           driver.Health().state == core::DeviceState::kRunning;
  })) << driver.Health().cause;
  // A machine that stands still for a moment may lose it once more.
  EXPECT_GE(driver.Health().losses, 1);

  base->reset();
  const SegwayEmulator& emulator = device.End();
  EXPECT_EQ(emulator.counts().broken_commands, 0);
  // The readings' wheels went on over the gap, which the base counted.
  EXPECT_LE(last_.right_wheel_m, emulator.state().right_wheel_m + 1e-4);
}

TEST_F(SegwayPtyTest, WaitsForAPortThatIsNotThere) {
  auto base = segway::SegwayBase::Create(
      {},
      std::make_unique<stream::SerialPortOpener>(stream::SerialPortOptions{
          .path = link_, .baud = segway::kSegwayBaud}),
      clock_);
  ASSERT_TRUE(base.ok());
  ASSERT_TRUE(DriveUntil(**base, [&] {
    return (*base)->Health().cause.code() == absl::StatusCode::kNotFound;
  }));
  EXPECT_EQ((*base)->Health().state, core::DeviceState::kStarting);
  PluggableBase device(link_, clock_);
  EXPECT_TRUE(DriveUntil(**base, [&] {
    return (*base)->Health().state == core::DeviceState::kRunning;
  }));
}

TEST_F(SegwayPtyTest, ABaseWithoutAPortOrWithBadOptionsIsRefused) {
  EXPECT_EQ(segway::SegwayBase::Create({}, nullptr, clock_).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(
      segway::SegwayBase::Create({.protocol = {.command_interval_s = 1}},
                                 std::make_unique<stream::SerialPortOpener>(
                                     stream::SerialPortOptions{}),
                                 clock_)
          .status()
          .code(),
      absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace treeline::emulators
