#include "nav_agent/drivers/hokuyo/scip_replies.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_split.h"
#include "gtest/gtest.h"
#include "nav_agent/drivers/hokuyo/scip_parser.h"
#include "nav_agent/drivers/hokuyo/testing_scip.h"
#include "nav_agent/drivers/stream/byte_stream.h"

namespace treeline::hokuyo {
namespace {

// What `decode` makes of the one reply in `text`.
template <typename Decode>
auto Decoded(absl::string_view text, const Decode& decode) {
  ScipParser parser;
  decltype(decode(ScipReply())) result = absl::NotFoundError("no reply");
  parser.Parse(stream::AsBytes(text),
               [&](const ScipReply& reply) { result = decode(reply); });
  return result;
}

TEST(ScipParametersTest, ReadsThoseOfAUtm30LxEw) {
  // As specified; the sums are those of the rule.
  const std::string text =
      "PP\n00P\nMODL:UTM-30LX-EW;I\nDMIN:23;7\nDMAX:60000;J\nARES:1440;^\n"
      "AMIN:0;?\nAMAX:1080;Z\nAFRT:540;0\nSCAN:2400;U\n\n";
  const auto parameters = Decoded(text, DecodeParameters);
  ASSERT_TRUE(parameters.ok()) << parameters.status();
  EXPECT_EQ(*parameters, ScipParameters());
  EXPECT_EQ(parameters->min_mm, 23);
  EXPECT_EQ(parameters->max_mm, 60000);
  EXPECT_EQ(ReplyText("PP", "00", EncodeParameters(*parameters)), text);
}

TEST(ScipParametersTest, MeanABeamEveryQuarterDegreeAndFortyScansASecond) {
  const core::RangeSensorInfo info = InfoOf({}, FullScan());
  EXPECT_EQ(info.beams, 1081);
  EXPECT_NEAR(info.angle_min_rad, -135 * M_PI / 180, 1e-12);
  EXPECT_NEAR(info.angle_increment_rad, 0.25 * M_PI / 180, 1e-12);
  EXPECT_NEAR(info.AngleOf_rad(540), 0, 1e-12);
  EXPECT_NEAR(info.AngleOf_rad(1080), 135 * M_PI / 180, 1e-12);
  EXPECT_NEAR(info.scan_interval_s, 0.025, 1e-12);
  EXPECT_NEAR(info.beam_interval_s, 0.025 / 1440, 1e-12);
  EXPECT_NEAR(info.range_min_m, 0.023, 1e-12);
  EXPECT_NEAR(info.range_max_m, 60, 1e-12);
}

TEST(ScipParametersTest, MergedBeamsLookToTheMiddleOfTheirNeighbours) {
  ScanCommand command = FullScan();
  command.first_step = 539;
  command.last_step = 541;
  command.cluster = 3;
  const core::RangeSensorInfo info = InfoOf({}, command);
  EXPECT_EQ(info.beams, 1);
  EXPECT_NEAR(info.angle_min_rad, 0, 1e-12);
  EXPECT_NEAR(info.angle_increment_rad, 0.75 * M_PI / 180, 1e-12);
}

TEST(ScipParametersTest, RefusesWhatIsMissingBrokenOrAbsurd) {
  const std::string good = ReplyText("PP", "00", EncodeParameters({}));
  std::string missing = good;
  missing.erase(missing.find("AFRT"), sizeof("AFRT:540;0"));
  EXPECT_TRUE(
      absl::IsInvalidArgument(Decoded(missing, DecodeParameters).status()));
  std::string broken = good;
  broken[broken.find("540")] = '4';
  EXPECT_TRUE(absl::IsDataLoss(Decoded(broken, DecodeParameters).status()));
  for (const ScipParameters& absurd :
       {ScipParameters{.max_mm = 10}, ScipParameters{.max_mm = 1 << 18},
        ScipParameters{.steps_per_turn = 0}, ScipParameters{.first_step = -1},
        ScipParameters{.last_step = 20000}, ScipParameters{.last_step = 0},
        ScipParameters{.last_step = 1440}, ScipParameters{.front_step = -5},
        ScipParameters{.turns_per_minute = 0}}) {
    const std::string text = ReplyText("PP", "00", EncodeParameters(absurd));
    EXPECT_TRUE(
        absl::IsInvalidArgument(Decoded(text, DecodeParameters).status()))
        << text;
  }
}

TEST(ScipVersionTest, SaysWhichSensorItIs) {
  const auto version = Decoded(
      "VV\n00P\nVEND:Hokuyo Automatic Co.,Ltd.;[\n"
      "PROD:SOKUIKI Sensor URG-04LX;[\nFIRM:3.1.00(18/Jan./2007);`\n"
      "PROT:SCIP 2.0;N\nSERI:H0614967;V\n\n",
      DecodeVersion);
  ASSERT_TRUE(version.ok()) << version.status();
  EXPECT_EQ(version->product, "SOKUIKI Sensor URG-04LX");
  EXPECT_EQ(version->firmware, "3.1.00(18/Jan./2007)");
  EXPECT_EQ(version->serial, "H0614967");
}

TEST(ScipConditionTest, SaysHowTheSensorFeels) {
  EXPECT_EQ(*Decoded("II\n00P\nLASR:OFF;7\nSTAT:Sensor works well.;8\n\n",
                     DecodeCondition),
            "Sensor works well.");
  EXPECT_EQ(*Decoded("II\n00P\nLASR:OFF;7\n\n", DecodeCondition), "");
}

TEST(ScipTimeTest, HasTwentyFourBits) {
  EXPECT_EQ(*Decoded("TM1\n00P\n00000\n\n", DecodeTime), 0);
  EXPECT_EQ(
      *Decoded("TM1\n00P\noooo" + std::string(1, ScipChecksum("oooo")) + "\n\n",
               DecodeTime),
      kScipTimeSpan_ms - 1);
  for (const char* text : {"TM1\n00P\n\n", "TM1\n00P\n00001\n\n",
                           "TM1\n00P\n000p0\n\n", "TM1\n00P\n000000\n\n"}) {
    EXPECT_TRUE(absl::IsDataLoss(Decoded(text, DecodeTime).status())) << text;
  }
}

TEST(ScipScanTest, AFullScanHas3372BytesIn51DataLines) {
  const std::string text =
      ScanText(FullScan(), ExampleScan(ScanContent::kDistance));
  EXPECT_EQ(text.size(), 3372u);
  std::vector<std::string> lines = absl::StrSplit(text, '\n');
  // Echo, status and time before them; the reply's end after them.
  ASSERT_EQ(lines.size(), 3u + 51u + 2u);
  EXPECT_EQ(lines[0], "MD0000108001000");
  EXPECT_EQ(lines[1], "99b");
  EXPECT_EQ(lines[2].size(), 5u);
  for (size_t i = 3; i < 53; ++i) EXPECT_EQ(lines[i].size(), 65u);
  // 1081 steps of 3 characters: 50 lines of 64, and 43.
  EXPECT_EQ(lines[53].size(), 44u);
}

TEST(ScipScanTest, EveryContentComesBack) {
  for (const ScanContent content :
       {ScanContent::kDistance, ScanContent::kShortDistance,
        ScanContent::kDistanceAndIntensity}) {
    ScipScan sent = ExampleScan(content);
    if (content == ScanContent::kShortDistance) {
      for (uint32_t& code : sent.codes) code &= 0xfff;
    }
    const ScanCommand command = FullScan(content);
    ScipScan scan;
    const absl::Status status =
        Decoded(ScanText(command, sent), [&](const ScipReply& reply) {
          return DecodeScan(reply, command, scan);
        });
    ASSERT_TRUE(status.ok()) << status;
    EXPECT_EQ(scan.time_ms, sent.time_ms);
    EXPECT_EQ(scan.codes, sent.codes);
    EXPECT_EQ(scan.intensities, sent.intensities);
  }
}

TEST(ScipScanTest, RefusesAnotherNumberOfSteps) {
  for (const size_t size : {0u, 1u, 1060u, 1080u, 1082u, 1100u}) {
    ScipScan sent = ExampleScan(ScanContent::kDistance);
    sent.codes.resize(size);
    ScipScan scan;
    EXPECT_TRUE(absl::IsDataLoss(Decoded(ScanText(FullScan(), sent),
                                         [&](const ScipReply& reply) {
                                           return DecodeScan(reply, FullScan(),
                                                             scan);
                                         })))
        << size;
  }
}

TEST(RangeCodeTest, SaysWhyThereIsNoRange) {
  const ScipParameters sensor;
  EXPECT_EQ(RangeOfCode(1, sensor), core::kNoReturn);
  EXPECT_EQ(RangeOfCode(2, sensor), core::kTooNear);
  EXPECT_TRUE(std::isnan(RangeOfCode(3, sensor)));
  EXPECT_EQ(RangeOfCode(4, sensor), core::kTooNear);
  EXPECT_TRUE(std::isnan(RangeOfCode(5, sensor)));
  EXPECT_TRUE(std::isnan(RangeOfCode(0, sensor)));
  EXPECT_EQ(RangeOfCode(22, sensor), core::kTooNear);
  EXPECT_FLOAT_EQ(RangeOfCode(23, sensor), 0.023f);
  EXPECT_FLOAT_EQ(RangeOfCode(12345, sensor), 12.345f);
  EXPECT_FLOAT_EQ(RangeOfCode(59999, sensor), 59.999f);
  EXPECT_EQ(RangeOfCode(60000, sensor), core::kNoReturn);
  EXPECT_EQ(RangeOfCode(65533, sensor), core::kNoReturn);
}

TEST(RangeCodeTest, EveryRangeComesBack) {
  const ScipParameters sensor;
  for (uint32_t code = 23; code < 60000; ++code) {
    ASSERT_EQ(CodeOfRange(RangeOfCode(code, sensor), sensor), code);
  }
  EXPECT_EQ(RangeOfCode(CodeOfRange(core::kNoReturn, sensor), sensor),
            core::kNoReturn);
  EXPECT_EQ(RangeOfCode(CodeOfRange(core::kTooNear, sensor), sensor),
            core::kTooNear);
  EXPECT_TRUE(std::isnan(
      RangeOfCode(CodeOfRange(core::kInvalidRange, sensor), sensor)));
}

}  // namespace
}  // namespace treeline::hokuyo
