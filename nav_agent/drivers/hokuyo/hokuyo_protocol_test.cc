#include "nav_agent/drivers/hokuyo/hokuyo_protocol.h"

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/drivers/hokuyo/testing_scip.h"
#include "nav_agent/drivers/stream/byte_stream.h"

namespace treeline::hokuyo {
namespace {

using testing::HasSubstr;

// A conversation in which the test plays the sensor, and time stands still
// unless it says otherwise.
class Talk {
 public:
  explicit Talk(const HokuyoOptions& options = {}) : protocol_(options, now_) {}

  HokuyoProtocol& protocol() { return protocol_; }
  std::string Sent() { return protocol_.TakeOutput(); }
  void Say(absl::string_view text) {
    protocol_.Receive(stream::AsBytes(text), now_);
  }
  void Wait(double seconds) {
    now_ += std::chrono::duration_cast<base::MonotonicTime::duration>(
        std::chrono::duration<double>(seconds));
    protocol_.Tick(now_);
  }
  std::string Trouble() const {
    return std::string(protocol_.trouble().message());
  }

  // Answers `question` with `status` and `rest`, if it was asked.
  void Expect(const std::string& question, absl::string_view status,
              absl::string_view rest = "\n") {
    EXPECT_EQ(Sent(), question + "\n");
    Say(ReplyText(question, status, rest));
  }
  // As a healthy sensor does, up to the question after TM2.
  void Greet() {
    Expect("QT", "00");
    Expect("VV", "00", EncodeVersion({.product = "UTM"}));
    Expect("PP", "00", EncodeParameters({}));
    Expect("II", "00", "STAT:Sensor works well.;8\n\n");
    Expect("TM0", "00");
    for (int i = 0; i < HokuyoProtocol::kTimeSamples; ++i) {
      EXPECT_EQ(Sent(), "TM1\n");
      Wait(0.001);
      Say(ReplyText("TM1", "00", TimeLine(1000 + i)));
    }
    Expect("TM2", "00");
  }
  void StartScans() {
    Greet();
    Expect("BM", "00");
    Expect("MD0000108001000", "00");
  }
  void SayScan(int64_t time_ms) {
    Say(ScanText(protocol_.Command(),
                 ExampleScan(protocol_.Command().content, time_ms)));
  }
  static std::string TimeLine(int64_t ms) {
    return ScipLine(EncodeScipNumber(static_cast<uint32_t>(ms), 4)) + "\n";
  }

 private:
  base::MonotonicTime now_ = base::MonotonicTime() + std::chrono::hours(1);
  HokuyoProtocol protocol_;
};

TEST(HokuyoProtocolTest, BeginsWithEverythingASensorIsAsked) {
  Talk talk;
  talk.StartScans();
  EXPECT_TRUE(talk.protocol().knows_sensor());
  EXPECT_EQ(talk.protocol().Version().product, "UTM");
  EXPECT_EQ(talk.protocol().Info().beams, 1081);
  EXPECT_NEAR(
      static_cast<double>(talk.protocol().clock().SyncUncertainty()->count()),
      1e6, 1.1e6);
  talk.SayScan(2000);
  const auto scans = talk.protocol().TakeScans();
  ASSERT_EQ(scans.size(), 1u);
  EXPECT_FLOAT_EQ(scans[0].ranges_m[0], 1.0f);
  EXPECT_FLOAT_EQ(scans[0].ranges_m[1], 8.919f);
  EXPECT_TRUE(talk.protocol().trouble().ok());
}

TEST(HokuyoProtocolTest, ForgetsTheScansOfAnEarlierSession) {
  Talk talk;
  talk.Say(ScanText(FullScan(), ExampleScan(ScanContent::kDistance)));
  talk.Say("half a li\n\n");
  talk.StartScans();
  EXPECT_TRUE(talk.protocol().TakeScans().empty());
  EXPECT_FALSE(talk.protocol().failed());
}

TEST(HokuyoProtocolTest, AsksAgainAndLeavesTimeMode) {
  Talk talk;
  EXPECT_EQ(talk.Sent(), "QT\n");
  talk.Wait(0.4);
  EXPECT_EQ(talk.Sent(), "");
  talk.Wait(0.11);
  EXPECT_EQ(talk.Sent(), "TM2\nQT\n");
  talk.Say("TM2\n00P\n\nQT\n00P\n\n");
  EXPECT_EQ(talk.Sent(), "VV\n");
}

TEST(HokuyoProtocolTest, ASensorInTimeModeRefusesQtAndIsFreedAtOnce) {
  Talk talk;
  talk.Expect("QT", "0E");
  EXPECT_EQ(talk.Sent(), "TM2\nQT\n");
  talk.Say("TM2\n00P\n\nQT\n00P\n\n");
  EXPECT_EQ(talk.Sent(), "VV\n");
}

TEST(HokuyoProtocolTest, GivesUpWithoutAnAnswer) {
  Talk talk;
  for (int i = 0; i < 4; ++i) talk.Wait(0.51);
  ASSERT_TRUE(talk.protocol().failed());
  EXPECT_TRUE(absl::IsUnavailable(talk.protocol().trouble()));
  EXPECT_EQ(talk.Trouble(), "no answer to QT");
  EXPECT_EQ(talk.protocol().NextDeadline(), base::MonotonicTime::max());
}

TEST(HokuyoProtocolTest, SaysIfThereWasNothingButNoise) {
  Talk talk;
  for (int i = 0; i < 4; ++i) {
    talk.Say("@#$%\n\n");
    talk.Wait(0.51);
  }
  ASSERT_TRUE(talk.protocol().failed());
  EXPECT_TRUE(absl::IsDataLoss(talk.protocol().trouble()));
  EXPECT_THAT(talk.Trouble(), HasSubstr("4 broken replies"));
}

TEST(HokuyoProtocolTest, AsksAgainWhenAnAnswerWasBroken) {
  Talk talk;
  talk.Expect("QT", "00");
  talk.Expect("VV", "00", EncodeVersion({}));
  std::string broken = EncodeParameters({});
  broken[10] ^= 1;
  talk.Expect("PP", "00", broken);
  EXPECT_EQ(talk.Sent(), "");
  talk.Wait(0.51);
  talk.Expect("PP", "00", EncodeParameters({}));
  EXPECT_EQ(talk.Sent(), "II\n");
  EXPECT_EQ(talk.protocol().corrupt(), 1);
}

TEST(HokuyoProtocolTest, ManagesWithoutTheSensorsTime) {
  Talk talk;
  talk.Expect("QT", "00");
  talk.Expect("VV", "00", EncodeVersion({}));
  talk.Expect("PP", "00", EncodeParameters({}));
  talk.Expect("II", "00");
  talk.Expect("TM0", "0E");
  talk.Expect("TM2", "03");
  EXPECT_EQ(talk.Sent(), "BM\n");
  EXPECT_EQ(talk.protocol().clock().SyncUncertainty(), std::nullopt);
}

TEST(HokuyoProtocolTest, ASensorThatIsOnAlreadyIsFine) {
  Talk talk;
  talk.Greet();
  talk.Expect("BM", "02");
  talk.Expect("MD0000108001000", "0B");
  talk.SayScan(2000);
  EXPECT_EQ(talk.protocol().TakeScans().size(), 1u);
}

TEST(HokuyoProtocolTest, ScansThatComeBeforeTheirConfirmationCount) {
  Talk talk;
  talk.Greet();
  talk.Expect("BM", "00");
  EXPECT_EQ(talk.Sent(), "MD0000108001000\n");
  talk.SayScan(2000);
  talk.SayScan(2025);
  EXPECT_EQ(talk.protocol().TakeScans().size(), 2u);
  EXPECT_FALSE(talk.protocol().failed());
}

TEST(HokuyoProtocolTest, SwitchesTheLaserOnAgainIfSomeoneTurnedItOff) {
  Talk talk;
  talk.StartScans();
  talk.Say(ReplyText("MD0000108001000", "10"));
  talk.Expect("BM", "00");
  EXPECT_EQ(talk.Sent(), "MD0000108001000\n");
}

TEST(HokuyoProtocolTest, CountsBrokenScansAndGoesOn) {
  Talk talk;
  talk.StartScans();
  talk.SayScan(2000);
  std::string broken = ScanText(talk.protocol().Command(),
                                ExampleScan(ScanContent::kDistance, 2025));
  broken[100] ^= 1;
  talk.Say(broken);
  talk.SayScan(2050);
  EXPECT_EQ(talk.protocol().TakeScans().size(), 2u);
  EXPECT_EQ(talk.protocol().corrupt(), 1);
}

TEST(HokuyoProtocolTest, NoticesSilence) {
  Talk talk;
  talk.StartScans();
  talk.SayScan(2000);
  talk.Wait(0.5);
  EXPECT_FALSE(talk.protocol().failed());
  talk.Wait(0.03);
  ASSERT_TRUE(talk.protocol().failed());
  EXPECT_TRUE(absl::IsUnavailable(talk.protocol().trouble()));
}

TEST(HokuyoProtocolTest, AStampThatStandsStillIsSilence) {
  Talk talk;
  talk.StartScans();
  for (int i = 0; i < 30; ++i) {
    talk.SayScan(2000);
    talk.Wait(0.025);
  }
  EXPECT_EQ(talk.protocol().TakeScans().size(), 1u);
  EXPECT_TRUE(talk.protocol().failed());
}

TEST(HokuyoProtocolTest, NoticesARestartOfTheSensor) {
  Talk talk;
  talk.StartScans();
  talk.SayScan(2'000'000);
  talk.Wait(0.025);
  talk.SayScan(3);
  ASSERT_TRUE(talk.protocol().failed());
  EXPECT_THAT(talk.Trouble(), HasSubstr("restarted"));
}

TEST(HokuyoProtocolTest, RefusedCommandsEndTheSession) {
  for (const char* status : {"01", "04", "0A", "0C", "0I"}) {
    Talk talk;
    talk.Greet();
    talk.Expect("BM", "00");
    talk.Expect("MD0000108001000", status);
    ASSERT_TRUE(talk.protocol().failed()) << status;
    EXPECT_TRUE(absl::IsInvalidArgument(talk.protocol().trouble()));
    EXPECT_THAT(talk.Trouble(), HasSubstr(status));
  }
}

TEST(HokuyoProtocolTest, BrokenHardwareIsAskedWhyAndTold) {
  for (const bool at_once : {true, false}) {
    Talk talk;
    if (at_once) {
      talk.Greet();
      talk.Expect("BM", "01");
    } else {
      talk.StartScans();
      talk.SayScan(2000);
      talk.Say(ReplyText("MD0000108001000", "66"));
    }
    talk.Expect("II", "00", ScipInfoLine("STAT:Motor is stuck") + "\n");
    ASSERT_TRUE(talk.protocol().failed());
    EXPECT_TRUE(absl::IsFailedPrecondition(talk.protocol().trouble()));
    EXPECT_THAT(talk.Trouble(), HasSubstr("Motor is stuck"));
  }
}

TEST(HokuyoProtocolTest, RebootsBrokenHardwareIfAskedTo) {
  HokuyoOptions options;
  options.reboot_on_fault = true;
  Talk talk(options);
  talk.Greet();
  talk.Expect("BM", "01");
  talk.Expect("II", "00");
  talk.Expect("RB", "01");
  EXPECT_EQ(talk.Sent(), "RB\n");
  EXPECT_TRUE(talk.protocol().failed());
}

TEST(HokuyoProtocolTest, WaitsForASensorThatChecksItself) {
  Talk talk;
  talk.StartScans();
  talk.SayScan(2000);
  talk.Say(ReplyText("MD0000108001000", "21"));
  EXPECT_TRUE(absl::IsUnavailable(talk.protocol().trouble()));
  talk.Wait(5);
  EXPECT_FALSE(talk.protocol().failed());
  talk.Say(ReplyText("MD0000108001000", "98"));
  talk.Expect("MD0000108001000", "0B");
  talk.SayScan(7000);
  EXPECT_TRUE(talk.protocol().trouble().ok());
}

TEST(HokuyoProtocolTest, AScanMayComeBeforeTheWordThatScansAreComing) {
  Talk talk;
  talk.StartScans();
  talk.Say(ReplyText("MD0000108001000", "21"));
  talk.Say(ReplyText("MD0000108001000", "98"));
  EXPECT_EQ(talk.Sent(), "MD0000108001000\n");
  talk.SayScan(2000);
  talk.Say(ReplyText("MD0000108001000", "0B"));
  EXPECT_FALSE(talk.protocol().failed());
  talk.SayScan(2025);
  EXPECT_EQ(talk.protocol().TakeScans().size(), 2u);
  // The confirmation has not put silence off.
  talk.Say(ReplyText("MD0000108001000", "00"));
  talk.Wait(0.6);
  EXPECT_TRUE(talk.protocol().failed());
}

TEST(HokuyoProtocolTest, SingleShotsAreAskedForOneByOne) {
  HokuyoOptions options;
  options.single_shot = true;
  options.time_sync = false;
  Talk talk(options);
  talk.Expect("QT", "00");
  talk.Expect("VV", "00", EncodeVersion({}));
  talk.Expect("PP", "00", EncodeParameters({}));
  talk.Expect("II", "00");
  talk.Expect("BM", "00");
  const std::string question = "GD0000108001";
  EXPECT_EQ(talk.Sent(), question + "\n");
  talk.SayScan(100);
  EXPECT_EQ(talk.Sent(), "");
  talk.Wait(0.026);
  EXPECT_EQ(talk.Sent(), question + "\n");
  // The same again: it was asked for too early.
  talk.SayScan(100);
  talk.Wait(0.007);
  EXPECT_EQ(talk.Sent(), question + "\n");
  talk.SayScan(125);
  EXPECT_EQ(talk.protocol().TakeScans().size(), 2u);
  // Switched off by someone.
  talk.Wait(0.026);
  talk.Expect(question, "10");
  EXPECT_EQ(talk.Sent(), "BM\n");
}

TEST(HokuyoProtocolTest, SingleShotsThatStayBrokenAreSilence) {
  HokuyoOptions options;
  options.single_shot = true;
  options.time_sync = false;
  options.first_scan_timeout_s = 1;
  Talk talk(options);
  talk.Expect("QT", "00");
  talk.Expect("VV", "00", EncodeVersion({}));
  talk.Expect("PP", "00", EncodeParameters({}));
  talk.Expect("II", "00");
  talk.Expect("BM", "00");
  for (int i = 0; i < 200 && !talk.protocol().failed(); ++i) {
    talk.Say(ReplyText("GD0000108001", "00", "broken\n\n"));
    talk.Wait(0.01);
  }
  ASSERT_TRUE(talk.protocol().failed());
  EXPECT_TRUE(absl::IsDataLoss(talk.protocol().trouble()));
}

TEST(HokuyoProtocolTest, AsksForTheBeamsThatTheOptionsMean) {
  HokuyoOptions options;
  options.angle_min_rad = -std::numbers::pi / 2;
  options.angle_max_rad = std::numbers::pi / 4;
  options.cluster = 2;
  options.skipped_scans = 1;
  options.intensities = true;
  Talk talk(options);
  talk.Greet();
  talk.Expect("BM", "00");
  EXPECT_EQ(talk.Sent(), "ME0180072002100\n");
  const core::RangeSensorInfo info = talk.protocol().Info();
  EXPECT_EQ(info.beams, 271);
  EXPECT_NEAR(info.angle_min_rad, (-90 + 0.125) * std::numbers::pi / 180, 1e-9);
  EXPECT_NEAR(info.scan_interval_s, 0.05, 1e-12);
}

TEST(HokuyoProtocolTest, RefusesBeamsThatTheSensorDoesNotHave) {
  HokuyoOptions options;
  options.angle_min_rad = 3.0;
  options.angle_max_rad = 3.1;
  Talk talk(options);
  talk.Expect("QT", "00");
  talk.Expect("VV", "00", EncodeVersion({}));
  talk.Expect("PP", "00", EncodeParameters({}));
  ASSERT_TRUE(talk.protocol().failed());
  EXPECT_TRUE(absl::IsInvalidArgument(talk.protocol().trouble()));
}

TEST(HokuyoOptionsTest, SaysWhatMakesNoSense) {
  EXPECT_TRUE(HokuyoOptions().Validate().ok());
  const auto is_bad = [](const HokuyoOptions& options) {
    return absl::IsInvalidArgument(options.Validate());
  };
  HokuyoOptions options;
  options.angle_min_rad = 1;
  options.angle_max_rad = -1;
  EXPECT_TRUE(is_bad(options));
  options = {};
  options.silence_timeout_s = std::nan("");
  EXPECT_TRUE(is_bad(options));
  options = {};
  options.skipped_scans = 10;
  EXPECT_TRUE(is_bad(options));
  options = {};
  options.backoff.first_s = -1;
  EXPECT_TRUE(is_bad(options));
}

}  // namespace
}  // namespace treeline::hokuyo
