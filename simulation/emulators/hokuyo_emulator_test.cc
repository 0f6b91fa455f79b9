#include "simulation/emulators/hokuyo_emulator.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/drivers/hokuyo/hokuyo_protocol.h"
#include "nav_agent/drivers/stream/byte_stream.h"
#include "simulation/emulators/testing_laser.h"

namespace treeline::emulators {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

// A sensor on the desk, and a clock that is set by hand.
class HokuyoEmulatorTest : public testing::Test {
 protected:
  std::string Say(absl::string_view text) {
    sensor_.Receive(stream::AsBytes(text), clock_.Now());
    return sensor_.TakeOutput(clock_.Now());
  }
  std::string Wait(double seconds) {
    clock_.Advance(seconds);
    return sensor_.TakeOutput(clock_.Now());
  }
  static std::string ReplyOf(absl::string_view echo, absl::string_view status) {
    return absl::StrCat(echo, "\n", hokuyo::ScipLine(status), "\n");
  }
  static int CountOf(absl::string_view part, absl::string_view text) {
    return static_cast<int>(
               std::vector<std::string>(absl::StrSplit(text, part)).size()) -
           1;
  }

  ManualClock clock_{};
  RoomLaserSource room_{RoomOptions()};
  HokuyoEmulator sensor_{HokuyoEmulatorOptions(), room_, clock_.Now()};
};

TEST_F(HokuyoEmulatorTest, AnswersAsTheSpecificationSays) {
  EXPECT_EQ(Say("PP\n"),
            "PP\n00P\nMODL:UTM-30LX-EW;I\nDMIN:23;7\nDMAX:60000;J\n"
            "ARES:1440;^\nAMIN:0;?\nAMAX:1080;Z\nAFRT:540;0\nSCAN:2400;U\n\n");
  EXPECT_THAT(Say("VV\r\n"),
              StartsWith("VV\n00P\nVEND:Hokuyo Automatic Co.,Ltd.;[\n"));
  EXPECT_THAT(Say("II\n"), HasSubstr("STAT:Sensor works well.;8\n"));
  EXPECT_EQ(Say("GD0000108001\n"), "GD0000108001\n10Q\n\n");
  EXPECT_EQ(Say("BM\n"), "BM\n00P\n\n");
  EXPECT_EQ(Say("BM\n"), "BM\n02R\n\n");
  EXPECT_EQ(Say("QT\n"), "QT\n00P\n\n");
  EXPECT_EQ(Say("TM1\n"), "TM1\n04T\n\n");
  EXPECT_EQ(Say("TM2\n"), "TM2\n03S\n\n");
  EXPECT_EQ(Say("SS115200\n"), ReplyOf("SS115200", "0F"));
  EXPECT_EQ(Say("XX\n"), ReplyOf("XX", "0E"));
}

TEST_F(HokuyoEmulatorTest, NamesWhatIsWrongWithAQuestion) {
  for (const auto& [question, status] :
       std::vector<std::pair<std::string, std::string>>{
           {"MD0x00108001000", "01"},
           {"MD00001x8001000", "02"},
           {"MD00001080x1000", "03"},
           {"MD0000108101000", "04"},
           {"MD0010000901000", "05"},
           {"MD0000108001x00", "06"},
           {"MD00001080010x0", "07"},
           {"MD00001080", "0C"},
           {"VV;12345678901234567", "0G"},
           {"VV;a*b", "0H"}}) {
    EXPECT_EQ(Say(question + "\n"), ReplyOf(question, status));
  }
}

TEST_F(HokuyoEmulatorTest, TellsItsTimeInTimeModeOnly) {
  Wait(2.5);
  EXPECT_EQ(Say("TM0\n"), "TM0\n00P\n\n");
  EXPECT_EQ(Say("TM0\n"), "TM0\n02R\n\n");
  EXPECT_EQ(Say("TM1\n"),
            "TM1\n00P\n" + hokuyo::ScipLine(hokuyo::EncodeScipNumber(2500, 4)) +
                "\n");
  EXPECT_EQ(Say("QT\nVV\n"), ReplyOf("QT", "0E") + ReplyOf("VV", "0E"));
  EXPECT_EQ(Say("TM2\n"), "TM2\n00P\n\n");
}

TEST_F(HokuyoEmulatorTest, SendsAScanEveryTurnWhenItsLastBeamWasMeasured) {
  EXPECT_EQ(Say("MD0000108001000\n"), "MD0000108001000\n00P\n\n");
  // Of the next turn that begins, step 1080 of 1440.
  EXPECT_EQ(Wait(0.0437), "");
  const std::string scan = Wait(0.0001);
  EXPECT_EQ(scan.size(), 3372u);
  EXPECT_THAT(scan,
              StartsWith("MD0000108001000\n99b\n" +
                         hokuyo::ScipLine(hokuyo::EncodeScipNumber(25, 4))));
  int scans = 0;
  for (int i = 0; i < 1000; ++i) scans += CountOf("99b\n", Wait(0.001));
  EXPECT_EQ(scans, 40);
  Say("QT\n");
  EXPECT_EQ(Wait(1), "");
}

TEST_F(HokuyoEmulatorTest, CountsTheScansThatAreLeft) {
  EXPECT_EQ(Say("MD0540054401102;abc\n"), "MD0540054401102;abc\n00P\n\n");
  std::string all;
  for (int i = 0; i < 300; ++i) all += Wait(0.001);
  EXPECT_EQ(CountOf("99b\n", all), 2);
  EXPECT_THAT(all, StartsWith("MD0540054401101;abc\n99b\n"));
  EXPECT_THAT(all, HasSubstr("\n\nMD0540054401100;abc\n99b\n"));
  EXPECT_FALSE(sensor_.laser_on());
}

TEST_F(HokuyoEmulatorTest, MergesNeighboursIntoTheNearest) {
  Wait(1);
  Say("BM\n");
  // Ahead the wall is 4 m away; at 540 +- 4 steps a little more.
  EXPECT_THAT(Say("GD0536054409\n"),
              HasSubstr(hokuyo::ScipLine(hokuyo::EncodeScipNumber(4000, 3))));
}

TEST_F(HokuyoEmulatorTest, ASlowReaderLosesOldScans) {
  Say("MD0540054401000\n");
  EXPECT_LE(CountOf("99b\n", Wait(10)), 5);
}

TEST_F(HokuyoEmulatorTest, RebootsOnlyWhenAskedTwice) {
  EXPECT_EQ(Say("RB\n"), ReplyOf("RB", "01"));
  Wait(1.5);
  EXPECT_EQ(Say("RB\n"), ReplyOf("RB", "01"));
  Wait(0.5);
  EXPECT_EQ(Say("RB\n"), ReplyOf("RB", "00"));
  EXPECT_EQ(Say("VV\n"), "");
  Wait(1.01);
  EXPECT_NE(Say("VV\n"), "");
  EXPECT_EQ(sensor_.Time_ms(clock_.Now()), 1010);
}

TEST_F(HokuyoEmulatorTest, ItsClockWrapsAndDrifts) {
  HokuyoEmulator sensor({.parameters = {},
                         .version = {},
                         .first_time_ms = hokuyo::kScipTimeSpan_ms - 100},
                        room_, clock_.Now());
  sensor.SetFaults({.skew_ppm = 1000}, clock_.Now());
  clock_.Advance(10);
  EXPECT_EQ(sensor.Time_ms(clock_.Now()), 9910);
  sensor.SetFaults({}, clock_.Now());
  clock_.Advance(10);
  EXPECT_EQ(sensor.Time_ms(clock_.Now()), 19910);
}

// The protocol of the driver with this sensor, and no thread or wire.
TEST_F(HokuyoEmulatorTest, TheDriversProtocolUnderstandsItWithoutWaiting) {
  hokuyo::HokuyoProtocol protocol({}, clock_.Now());
  int scans = 0;
  double worst_ms = 0;
  // A minute in steps of a millisecond.
  for (int i = 0; i < 60'000; ++i) {
    const std::string output = protocol.TakeOutput();
    sensor_.Receive(stream::AsBytes(output), clock_.Now());
    protocol.Receive(stream::AsBytes(sensor_.TakeOutput(clock_.Now())),
                     clock_.Now());
    for (const core::LaserScan& scan : protocol.TakeScans()) {
      // Turns begin every 25 ms after the sensor was switched on, at a full
      // hour of this clock.
      const double ms = base::MillisecondsBetween(
          base::MonotonicTime() + std::chrono::hours(1), scan.stamp);
      worst_ms = std::max(worst_ms, std::abs(std::remainder(ms, 25)));
      ++scans;
    }
    ASSERT_FALSE(protocol.failed()) << protocol.trouble();
    clock_.Advance(0.001);
  }
  EXPECT_GE(scans, 2395);
  // Half a millisecond of rounding, and half of what TM leaves open.
  EXPECT_LE(worst_ms, 1.6);
}

TEST(RoomTest, IsMeasuredAsGeometrySays) {
  const RoomOptions room = {.width_m = 8, .depth_m = 6, .laser_x_m = 1};
  EXPECT_NEAR(DistanceToWall_m(room, 0), 3, 1e-12);
  EXPECT_NEAR(DistanceToWall_m(room, M_PI), 5, 1e-12);
  EXPECT_NEAR(DistanceToWall_m(room, M_PI / 2), 3, 1e-12);
  EXPECT_NEAR(DistanceToWall_m(room, M_PI / 4), 3 * std::sqrt(2.0), 1e-12);
  EXPECT_TRUE(ParseRoom("8x6").ok());
  for (const char* text :
       {"", "8", "x", "8x", "0x6", "8x6x7", "axb", "1e9x1"}) {
    EXPECT_FALSE(ParseRoom(text).ok()) << text;
  }
}

TEST(RoomTest, NoiseAndDropOutAreAsAskedFor) {
  RoomLaserSource source({.noise_m = 0.02, .dropout = 0.1, .seed = 5});
  const core::RangeSensorInfo info = hokuyo::InfoOf({}, {.last_step = 1080});
  double squares = 0;
  int lost = 0;
  int seen = 0;
  for (int k = 0; k < 20; ++k) {
    const core::LaserScan scan = source.ScanAt(
        base::MonotonicTime() + std::chrono::milliseconds(25 * k), info);
    for (int beam = 0; beam < info.beams; ++beam) {
      const float range_m = scan.ranges_m[static_cast<size_t>(beam)];
      if (range_m == core::kNoReturn) {
        ++lost;
        continue;
      }
      const double error_m =
          range_m - DistanceToWall_m({}, info.AngleOf_rad(beam));
      squares += error_m * error_m;
      ++seen;
    }
  }
  // 21620 beams: standard errors of 0.0001 m and 0.002.
  EXPECT_NEAR(std::sqrt(squares / seen), 0.02, 0.0005);
  EXPECT_NEAR(lost / 21620.0, 0.1, 0.01);
}

}  // namespace
}  // namespace treeline::emulators
