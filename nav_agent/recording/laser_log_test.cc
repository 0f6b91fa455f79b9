#include "nav_agent/recording/laser_log.h"

#include <zlib.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/recording/gunzip.h"
#include "nav_agent/recording/relations.h"

namespace treeline::recording {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr char kJson[] = R"({
    "map": {
        "20.5": {"range": [2.0, 3.5, 81.83], "theta": 0.5, "x": 1.0, "y": -2},
        "3.25": {
            "range": [1, 0.0, 90],
            "theta": 0, "x": 0, "y": 0
        }
    }
})";

std::string ErrorOf(absl::string_view text) {
  const auto log = ParseLaserLog(text, "a.log");
  EXPECT_FALSE(log.ok());
  EXPECT_EQ(log.status().code(), absl::StatusCode::kInvalidArgument);
  return std::string(log.status().message());
}

std::string Gzipped(const std::string& text) {
  z_stream stream{};
  EXPECT_EQ(
      deflateInit2(&stream, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY),
      Z_OK);
  std::string in = text;
  std::string out(deflateBound(&stream, text.size()) + 64, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(in.data());
  stream.avail_in = static_cast<uInt>(in.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

TEST(LaserLog, ReadsJsonInTheOrderOfTime) {
  const auto log = ParseLaserLog(kJson, "raw.json");
  ASSERT_TRUE(log.ok()) << log.status();
  ASSERT_THAT(log->scans, SizeIs(2));
  EXPECT_EQ(log->scans[0].stamp,
            RecordingTime(std::chrono::milliseconds(3250)));
  EXPECT_EQ(log->scans[1].odom_from_base, (geometry::Rigid2{{1, -2}, 0.5}));
  EXPECT_FLOAT_EQ(log->scans[1].ranges_m[1], 3.5F);
  EXPECT_EQ(log->scans[1].ranges_m[2], core::kNoReturn);
  EXPECT_TRUE(std::isnan(log->scans[0].ranges_m[1]));
  EXPECT_EQ(log->laser.beams, 3);
  EXPECT_NEAR(log->laser.AngleOf_rad(2), std::numbers::pi / 2, 1e-12);
  EXPECT_EQ(log->base_from_laser, geometry::Rigid2{});
}

TEST(LaserLog, SaysWhereJsonIsWrong) {
  EXPECT_THAT(ErrorOf("{\"map\": {\n\"1\": {\n\"range\": [1, NaN]}}}"),
              HasSubstr("a.log:3:"));
  EXPECT_THAT(ErrorOf("{\"map\": {\n\"1\": {\"range\": [1], \"x\": 1, "
                      "\"y\": 2}}}"),
              HasSubstr("a.log:2: a scan needs"));
  EXPECT_THAT(ErrorOf("{\"map\":{\"1\":{\"range\":[1,2],\"x\":1,\"y\":2,"
                      "\"theta\":0},\n\"2\":{\"range\":[1],\"x\":1,\"y\":2,"
                      "\"theta\":0}}}"),
              HasSubstr("a.log:2: a scan of 1 beams, after scans of 2"));
  EXPECT_THAT(ErrorOf("{\"map\":{\"noon\":{\"range\":[1,2],\"x\":1,\"y\":2,"
                      "\"theta\":0}}}"),
              HasSubstr("'noon' is not a time stamp"));
  EXPECT_THAT(ErrorOf("{\"maps\":{}}"), HasSubstr("expected \"map\""));
  EXPECT_THAT(ErrorOf("{\"map\":{}}"), HasSubstr("no laser scans"));
  EXPECT_THAT(ErrorOf("{\"map\":{\"1\":{\"range\":[1e999]}}}"),
              HasSubstr("a.log:1:"));
  EXPECT_THAT(ErrorOf("{\"map\":{\"1\":{\"range\":[[1]]}}}"),
              HasSubstr("a list where none belongs"));
  EXPECT_THAT(ErrorOf("{\"map\":"), HasSubstr("not JSON"));
}

TEST(LaserLog, ReadsCarmensOldScans) {
  const auto log = ParseLaserLog(
      "# a comment\n"
      "PARAM robot_length 0.5 0 host 0\n"
      "ODOM 0.5 0 0 0.1 0 0 10.5 host 0.5\n"
      "FLASER 3 1.5 81.90 2.25 1.25 2.0 0.0 1.0 2.0 0.0 11.000001 host 1\n",
      "a.log");
  ASSERT_TRUE(log.ok()) << log.status();
  ASSERT_THAT(log->scans, SizeIs(1));
  ASSERT_THAT(log->odometry, SizeIs(1));
  EXPECT_NEAR(log->base_from_laser.translation.x, 0.25, 1e-9);
  EXPECT_EQ(log->scans[0].stamp,
            RecordingTime(std::chrono::microseconds(11000001)));
  EXPECT_EQ(log->scans[0].odom_from_base, (geometry::Rigid2{{1, 2}, 0}));
  EXPECT_EQ(log->scans[0].ranges_m[1], core::kNoReturn);
  EXPECT_EQ(log->odometry[0].odom_from_base.translation.x, 0.5);
}

TEST(LaserLog, TakesCorrectedPosesForNoMount) {
  const auto log = ParseLaserLog(
      "FLASER 1 1.5 1.2 2 0 1 2 0 11 host 1\n"
      "FLASER 1 1.5 2.9 2 0 2 2 0 12 host 1\n",
      "a.log");
  ASSERT_TRUE(log.ok()) << log.status();
  EXPECT_EQ(log->base_from_laser, geometry::Rigid2{});
}

TEST(LaserLog, ReadsWeanHallsScans) {
  const auto log = ParseLaserLog(
      "O 100 -50 0 0.025863\n"
      "L 100 -50 0 125 -50 0 66 70 530 0.5\n",
      "a.log");
  ASSERT_TRUE(log.ok()) << log.status();
  ASSERT_THAT(log->scans, SizeIs(1));
  ASSERT_THAT(log->odometry, SizeIs(1));
  EXPECT_NEAR(log->base_from_laser.translation.x, 0.25, 1e-9);
  EXPECT_NEAR(log->scans[0].odom_from_base.translation.y, -0.5, 1e-9);
  EXPECT_FLOAT_EQ(log->scans[0].ranges_m[2], 5.3F);
}

TEST(LaserLog, GoesOnAfterAClockThatJumpsBack) {
  const auto log = ParseLaserLog(
      "L 1 2 0 1 2 0 66 70 9.5\nO 1 2 0 9.6\n"
      "L 3 2 0 3 2 0 66 71 2.0\nO 4 2 0 2.2\nL 5 2 0 5 2 0 66 72 2.5\n",
      "a.log");
  ASSERT_TRUE(log.ok()) << log.status();
  ASSERT_THAT(log->scans, SizeIs(3));
  EXPECT_FLOAT_EQ(log->scans[1].ranges_m[1], 0.71F);
  // 0.1 s after the last scan, and then as the clock goes.
  const auto at_s = [&log](size_t i) {
    return SecondsBetween(RecordingTime(), log->scans[i].stamp);
  };
  EXPECT_NEAR(at_s(1), 9.6, 1e-6);
  EXPECT_NEAR(at_s(2), 10.1, 1e-6);
  EXPECT_NEAR(SecondsBetween(RecordingTime(), log->odometry[1].stamp), 9.8,
              1e-6);
  ASSERT_THAT(log->warnings, SizeIs(1));
  EXPECT_THAT(log->warnings[0],
              HasSubstr("a.log:3: the clock jumps back by 7.500 s"));
}

TEST(LaserLog, RefusesLinesThatAreInNoOrderOfTime) {
  std::string text;
  for (int i = 0; i < 60; ++i) {
    text += i % 2 == 0 ? "L 1 2 0 1 2 0 66 70 1.0\n"
                       : "L 1 2 0 1 2 0 66 70 900.0\n";
  }
  EXPECT_THAT(ErrorOf(text), HasSubstr("not in the order of time"));
  EXPECT_THAT(ErrorOf("L 1 2 0 1 2 0 66 70 8999999999\n"
                      "L 1 2 0 1 2 0 66 70 1\n"
                      "L 1 2 0 1 2 0 66 70 8999999999\n"),
              HasSubstr("jumped too far"));
}

TEST(LaserLog, SaysWhichLineIsWrong) {
  EXPECT_THAT(ErrorOf("O 1 2 0 0.1\nL 1 2 0 1 2 0 66 nan 0.5\n"),
              HasSubstr("a.log:2: 'nan' is not a finite number"));
  EXPECT_THAT(ErrorOf("L 1 2 0 1 2 0 66 70 0.5\nL 1 2 0 1 2 0 66 0.6\n"),
              HasSubstr("a.log:2: a scan of 1 beams, after scans of 2"));
  EXPECT_THAT(ErrorOf("FLASER 180 1 2 3\n"), HasSubstr("ends too early"));
  EXPECT_THAT(ErrorOf("FLASER 99999999 1 2 3\n"),
              HasSubstr("a number of beams"));
  EXPECT_THAT(ErrorOf("ROBOTLASER1 0 -1.57 3.14 -1 80 0.1 0 1 2.5 0 0 0 0 0 0 "
                      "0 0 0 0 0 0 1.5 h 1\n"),
              HasSubstr("not one of a scanner"));
  EXPECT_THAT(ErrorOf("FLASER 1 1.5 1 2 0 1 2 0 noon host 1\n"),
              HasSubstr("no time stamp"));
  EXPECT_THAT(ErrorOf("hello\n"), HasSubstr("no laser scans"));
  EXPECT_THAT(ErrorOf(""), HasSubstr("a.log: empty"));
  EXPECT_THAT(ErrorOf(" \n\n"), HasSubstr("a.log: empty"));
}

TEST(LaserLog, PutsLinesInOrderThatAreALittleLate) {
  const auto log = ParseLaserLog(
      "L 1 2 0 1 2 0 66 70 9.5\nL 1 2 0 1 2 0 66 70 9.0\n", "a.log");
  ASSERT_TRUE(log.ok()) << log.status();
  EXPECT_LT(log->scans[0].stamp, log->scans[1].stamp);
}

TEST(LaserLog, SurvivesARoundTripThroughCarmensFormat) {
  LaserLog log = {
      .laser = {.angle_min_rad = -2.0,
                .angle_increment_rad = 0.01,
                .beams = 4,
                .range_min_m = 0.02,
                .range_max_m = 30,
                .scan_interval_s = 0.5},
      .base_from_laser = {{0.22, 0.01}, 0.1},
      .scans = {},
      .odometry = {{.stamp = RecordingTime(std::chrono::milliseconds(1200)),
                    .odom_from_base = {{1, 2}, -3}}}};
  for (int i = 0; i < 3; ++i) {
    log.scans.push_back(
        {.stamp = RecordingTime(std::chrono::milliseconds(1000 + 500 * i)),
         .odom_from_base = {{0.5 * i, -1.25}, 0.3 * i},
         .ranges_m = {1.5F, core::kNoReturn, 2.25F, 29.5F}});
  }
  const auto back =
      ParseLaserLog(FormatCarmenLog(log), "a.log", {.range_max_m = 30});
  ASSERT_TRUE(back.ok()) << back.status();
  ASSERT_THAT(back->scans, SizeIs(3));
  ASSERT_THAT(back->odometry, SizeIs(1));
  EXPECT_EQ(back->laser, log.laser);
  EXPECT_NEAR(back->base_from_laser.translation.x, 0.22, 1e-7);
  EXPECT_NEAR(back->base_from_laser.yaw_rad, 0.1, 1e-7);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(back->scans[i].stamp, log.scans[i].stamp);
    EXPECT_EQ(back->scans[i].ranges_m, log.scans[i].ranges_m);
    EXPECT_NEAR(back->scans[i].odom_from_base.yaw_rad,
                log.scans[i].odom_from_base.yaw_rad, 1e-8);
  }
}

TEST(LaserLog, IsUnpackedFirst) {
  const std::string packed = Gzipped(kJson);
  ASSERT_TRUE(IsGzip(packed));
  const auto log = ParseLaserLog(packed, "raw.json.gz");
  ASSERT_TRUE(log.ok()) << log.status();
  EXPECT_THAT(log->scans, SizeIs(2));
  const auto half =
      ParseLaserLog(packed.substr(0, packed.size() / 2), "raw.json.gz");
  EXPECT_EQ(half.status().code(), absl::StatusCode::kDataLoss);
  std::string broken = packed;
  broken[packed.size() / 2] = static_cast<char>(broken[packed.size() / 2] ^ 64);
  EXPECT_FALSE(ParseLaserLog(broken, "raw.json.gz").ok());
  EXPECT_EQ(Gunzip(packed, 10).status().code(),
            absl::StatusCode::kResourceExhausted);
}

TEST(LaserLog, ChecksItsOptions) {
  EXPECT_FALSE(ParseLaserLog(kJson, "a", {.range_max_m = 0}).ok());
  EXPECT_FALSE(ParseLaserLog(kJson, "a", {.reorder_s = -1}).ok());
}

TEST(RecordingTime, IsExact) {
  EXPECT_EQ(ParseRecordingTime("976052890.244111"),
            RecordingTime(std::chrono::nanoseconds(976052890244111000)));
  EXPECT_EQ(FormatRecordingTime(*ParseRecordingTime("976052890.244111")),
            "976052890.244111");
  EXPECT_EQ(ParseRecordingTime("0.1234567899"),
            RecordingTime(std::chrono::nanoseconds(123456789)));
  for (const char* bad :
       {"", ".", "1.2.3", "-1", "1e5", "99999999999", "nan"}) {
    EXPECT_FALSE(ParseRecordingTime(bad).has_value()) << bad;
  }
}

TEST(Relations, AreRead) {
  const auto relations = ParseRelations(
      "# t1 t2 x y z roll pitch yaw\n"
      "976052905.167303 976052911.885496 -0.05 -0.12 0 0 0 -1.68\n",
      "intel.relations");
  ASSERT_TRUE(relations.ok()) << relations.status();
  ASSERT_THAT(*relations, SizeIs(1));
  EXPECT_EQ((*relations)[0].from_base_from_to_base,
            (geometry::Rigid2{{-0.05, -0.12}, -1.68}));
  const auto message = [](absl::string_view text) {
    return std::string(ParseRelations(text, "r").status().message());
  };
  EXPECT_THAT(message("1 2 3\n"), HasSubstr("r:1: 8 numbers"));
  EXPECT_THAT(message("\n1 x 0 0 0 0 0 0\n"), HasSubstr("r:2: no time"));
  EXPECT_THAT(message("1 2 0 0 0 0 0 inf\n"), HasSubstr("'inf'"));
  EXPECT_THAT(message(""), HasSubstr("no relations"));
}

}  // namespace
}  // namespace treeline::recording
