#include "nav_agent/recording/agent_log.h"

#include <unistd.h>

#include <cmath>
#include <string>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "gtest/gtest.h"

namespace treeline::recording {
namespace {

using std::chrono::milliseconds;

class FakeClock final : public base::Clock {
 public:
  base::MonotonicTime Now() const override { return now; }
  base::MonotonicTime now{};
};

base::MonotonicTime StampAt(int milliseconds_since) {
  return base::MonotonicTime(milliseconds(milliseconds_since));
}

// One of each kind.
std::vector<LogEntry> AllKinds() {
  camera::RgbdCalibration calibration;
  calibration.color =
      *camera::Camera::Parse("OPENCV,525,526,320,240,0.1,0,0,0.01", 640, 480);
  calibration.color_from_depth.translation = {0.025, 0, 0};
  calibration.pose_sensor = camera::RgbdSensor::kDepth;
  core::RobotModel robot;
  robot.height_m = 0.75;
  return {LogInformation{"a test"},
          core::RangeSensorInfo{.angle_min_rad = -2,
                                .angle_increment_rad = 0.004,
                                .beams = 3,
                                .range_min_m = 0.1,
                                .range_max_m = 30,
                                .beam_interval_s = 1e-5,
                                .scan_interval_s = 0.025},
          calibration,
          robot,
          core::LaserScan{.stamp = StampAt(25),
                          .ranges_m = {1.5f, core::kNoReturn, core::kTooNear},
                          .intensities = {100, 0, 7}},
          core::BaseReading{.stamp = StampAt(30),
                            .left_wheel_m = 1.25,
                            .right_wheel_m = -2,
                            .pitch_rad = 0.05,
                            .motors_enabled = false},
          LogFrame{.stamp = StampAt(33),
                   .sequence = 4,
                   .depth_unit_m = 0.0002,
                   .color = "jpeg",
                   .depth = "png"},
          LogTruePose{StampAt(40), {.rotation = {}, .translation = {1, 2, 3}}},
          LogEvent{StampAt(41), "collision: wall"},
          LogCommand{StampAt(42), {0.5, -0.25}}};
}

std::string FileOf(const std::vector<LogEntry>& entries) {
  std::string bytes = AgentLogHeader();
  for (const LogEntry& entry : entries) bytes += EncodeLogRecord(entry);
  return bytes;
}

std::string TemporaryPath(const char* name) {
  const std::string path =
      absl::StrCat(testing::TempDir(), "/agent_log_", getpid(), name);
  unlink(path.c_str());
  return path;
}

TEST(AgentLog, GivesBackEveryKind) {
  const std::string bytes = FileOf(AllKinds());
  auto reader = AgentLogReader::Parse(bytes);
  ASSERT_TRUE(reader.ok());
  size_t count = 0;
  for (const LogEntry& written : AllKinds()) {
    const auto read = reader->Next();
    ASSERT_TRUE(read.has_value()) << count;
    EXPECT_EQ(read->index(), written.index());
    // The encoding is one to one.
    EXPECT_EQ(EncodeLogRecord(*read), EncodeLogRecord(written)) << count;
    ++count;
  }
  EXPECT_FALSE(reader->Next().has_value());
  EXPECT_EQ(reader->damaged_bytes(), 0);
}

TEST(AgentLog, KeepsValuesAndRanges) {
  const std::string bytes = FileOf(AllKinds());
  auto reader = AgentLogReader::Parse(bytes);
  std::vector<LogEntry> entries;
  while (auto entry = reader->Next()) entries.push_back(*std::move(entry));
  const auto& calibration = std::get<camera::RgbdCalibration>(entries[2]);
  EXPECT_EQ(calibration, std::get<camera::RgbdCalibration>(AllKinds()[2]));
  EXPECT_EQ(std::get<core::RobotModel>(entries[3]).height_m, 0.75);
  const auto& scan = std::get<core::LaserScan>(entries[4]);
  EXPECT_EQ(scan.stamp, StampAt(25));
  EXPECT_EQ(scan.ranges_m,
            (std::vector<float>{1.5f, core::kNoReturn, core::kTooNear}));
  EXPECT_EQ(scan.intensities, (std::vector<uint16_t>{100, 0, 7}));
  const auto& reading = std::get<core::BaseReading>(entries[5]);
  EXPECT_EQ(reading.right_wheel_m, -2);
  EXPECT_FALSE(reading.motors_enabled);
  EXPECT_EQ(std::get<LogFrame>(entries[6]).color, "jpeg");
  EXPECT_EQ(std::get<LogCommand>(entries[9]).command.yaw_rate_radps, -0.25);
}

TEST(AgentLog, SkipsWhatIsDamagedAndFindsTheRest) {
  const std::vector<LogEntry> entries = AllKinds();
  const std::string clean = FileOf(entries);
  const size_t first_bytes = EncodeLogRecord(entries[0]).size();
  for (size_t at = 16; at < 16 + first_bytes; ++at) {
    std::string bytes = clean;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x10);
    auto reader = AgentLogReader::Parse(bytes);
    ASSERT_TRUE(reader.ok());
    size_t read = 0;
    while (reader->Next().has_value()) ++read;
    EXPECT_EQ(read, entries.size() - 1) << at;
    EXPECT_EQ(reader->damaged_bytes(), static_cast<int64_t>(first_bytes));
  }
}

TEST(AgentLog, EveryCutLosesOnlyTheLastEntry) {
  const std::vector<LogEntry> entries = AllKinds();
  const std::string clean = FileOf(entries);
  std::vector<size_t> ends = {16};
  for (const LogEntry& entry : entries) {
    ends.push_back(ends.back() + EncodeLogRecord(entry).size());
  }
  for (size_t size = 16; size <= clean.size(); ++size) {
    const std::string bytes = clean.substr(0, size);
    auto reader = AgentLogReader::Parse(bytes);
    size_t read = 0;
    while (reader->Next().has_value()) ++read;
    size_t whole = 0;
    while (whole + 1 < ends.size() && ends[whole + 1] <= size) ++whole;
    EXPECT_EQ(read, whole) << size;
    EXPECT_EQ(reader->end_of_last_entry(), ends[whole]);
  }
}

TEST(AgentLog, RefusesOtherFilesAndOtherVersions) {
  EXPECT_EQ(AgentLogReader::Parse("TREELINE and more that is not a log")
                .status()
                .code(),
            absl::StatusCode::kDataLoss);
  EXPECT_FALSE(AgentLogReader::Parse("").ok());
  std::string bytes = AgentLogHeader();
  bytes[8] = 2;
  EXPECT_EQ(AgentLogReader::Parse(bytes).status().code(),
            absl::StatusCode::kFailedPrecondition);
}

TEST(AgentLog, WhatWasWrittenIsInTheFileAfterASecond) {
  FakeClock clock;
  const std::string path = TemporaryPath("flush");
  auto writer = AgentLogWriter::Open(path, false, clock);
  ASSERT_TRUE(writer.ok()) << writer.status();
  const LogEntry entry = LogEvent{StampAt(1), "first"};
  ASSERT_TRUE((*writer)->Write(entry).ok());
  clock.now += milliseconds(1000);
  ASSERT_TRUE((*writer)->Write(entry).ok());
  // As a killed program would leave it: the writer is not closed yet.
  auto reader = AgentLogReader::Open(path);
  ASSERT_TRUE(reader.ok());
  EXPECT_TRUE(reader->Next().has_value());
  EXPECT_TRUE(reader->Next().has_value());
  unlink(path.c_str());
}

TEST(AgentLog, GoesOnBehindTheLastWholeEntry) {
  FakeClock clock;
  const std::string path = TemporaryPath("append");
  const std::string bytes = FileOf(AllKinds());
  ASSERT_TRUE(
      base::WriteFileAtomically(path, bytes.substr(0, bytes.size() - 3)).ok());
  EXPECT_EQ(AgentLogWriter::Open(path, false, clock).status().code(),
            absl::StatusCode::kAlreadyExists);
  {
    auto writer = AgentLogWriter::Open(path, true, clock);
    ASSERT_TRUE(writer.ok()) << writer.status();
    ASSERT_TRUE((*writer)->Write(LogEvent{StampAt(99), "again"}).ok());
  }
  auto reader = AgentLogReader::Open(path);
  ASSERT_TRUE(reader.ok());
  std::vector<LogEntry> entries;
  while (auto entry = reader->Next()) entries.push_back(*std::move(entry));
  ASSERT_EQ(entries.size(), AllKinds().size());
  EXPECT_EQ(std::get<LogEvent>(entries.back()).text, "again");
  EXPECT_EQ(reader->damaged_bytes(), 0);
  unlink(path.c_str());
}

TEST(AgentLog, FramesComeBackAsTheyWere) {
  core::RgbdFrame frame;
  frame.stamp = StampAt(5);
  frame.sequence = 3;
  frame.frame.color = {4, 2, std::vector<uint8_t>(24, 77)};
  frame.frame.depth =
      image::DepthImage{4, 2, std::vector<uint16_t>(8, 1234), 0.001};
  const auto encoded = EncodeLogFrame(frame, 0);
  ASSERT_TRUE(encoded.ok());
  const auto decoded = DecodeLogFrame(*encoded);
  ASSERT_TRUE(decoded.ok());
  EXPECT_EQ(decoded->sequence, 3);
  EXPECT_EQ(decoded->frame.color.rgb, frame.frame.color.rgb);
  EXPECT_EQ(decoded->frame.depth->values, frame.frame.depth->values);
}

}  // namespace
}  // namespace treeline::recording
