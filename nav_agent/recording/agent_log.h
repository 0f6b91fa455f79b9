// What a robot measured, in one file: scans, wheel readings, frames, and the
// truth where it is known. docs/reference/agent-log.md specifies the format.
#ifndef NAV_AGENT_RECORDING_AGENT_LOG_H_
#define NAV_AGENT_RECORDING_AGENT_LOG_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/base/clock.h"
#include "common/base/file.h"
#include "common/camera/rgbd_calibration.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/core/sensor_data.h"

namespace treeline::recording {

inline constexpr uint32_t kAgentLogVersion = 1;
// Longer payloads are refused.
inline constexpr size_t kMaxLogPayload_bytes = size_t{64} << 20;

// What the recording is of, as text for people: program, world, seed.
struct LogInformation {
  std::string text;
  bool operator==(const LogInformation&) const = default;
};

// An RGB-D frame as files: colour as JPEG or PNG, depth as 16-bit PNG in
// depth_unit_m, or empty.
struct LogFrame {
  base::MonotonicTime stamp;
  int64_t sequence = 0;
  double depth_unit_m = 0.001;
  std::string color{};
  std::string depth{};
};

// Where the robot truly was. Only simulators know.
struct LogTruePose {
  base::MonotonicTime stamp;
  geometry::Rigid3 world_from_base;
};

// Something that happened, as text.
struct LogEvent {
  base::MonotonicTime stamp;
  std::string text;
};

// What the base was asked to do.
struct LogCommand {
  base::MonotonicTime stamp;
  core::VelocityCommand command;
};

// RangeSensorInfo, RgbdCalibration and RobotModel hold for what follows them.
using LogEntry =
    std::variant<LogInformation, core::RangeSensorInfo, camera::RgbdCalibration,
                 core::RobotModel, core::LaserScan, core::BaseReading, LogFrame,
                 LogTruePose, LogEvent, LogCommand>;

// Frames to files and back. jpeg_quality < 1: colour as PNG, without loss.
absl::StatusOr<LogFrame> EncodeLogFrame(const core::RgbdFrame& frame,
                                        int jpeg_quality);
// The frame's calibration is left empty.
absl::StatusOr<core::RgbdFrame> DecodeLogFrame(const LogFrame& frame);

// Appends entries to a file. What was written is in the file after a second at
// the latest, if entries keep coming, so that a program that is killed loses no
// more. Not thread-safe.
class AgentLogWriter {
 public:
  // Begins a new file, or goes on with one that is a log: behind its last
  // complete entry, what is left of a broken one is cut off. ALREADY_EXISTS if
  // there is a file and `append` is false; DATA_LOSS if it is no log.
  // clock must outlive the writer.
  static absl::StatusOr<std::unique_ptr<AgentLogWriter>> Open(
      const std::string& path, bool append, const base::Clock& clock);
  ~AgentLogWriter();

  // UNAVAILABLE with the system's reason: a full disk. RESOURCE_EXHAUSTED: the
  // entry is too long.
  absl::Status Write(const LogEntry& entry);
  // Hands everything to the system.
  absl::Status Flush();

  // In the file or on the way there.
  int64_t bytes_written() const { return bytes_; }

 private:
  AgentLogWriter(int fd, std::string path, const base::Clock& clock);

  const int fd_;
  const std::string path_;
  const base::Clock* clock_;
  std::string buffer_;
  base::MonotonicTime last_flush_;
  int64_t bytes_ = 0;
};

// Whether a file that begins with these bytes is an agent log, of any version.
bool IsAgentLog(absl::string_view bytes);

// Reads entries in the file's order. Not thread-safe.
class AgentLogReader {
 public:
  // DATA_LOSS if it is no log, FAILED_PRECONDITION if it is of a newer version.
  static absl::StatusOr<AgentLogReader> Open(const std::string& path);
  // The same for bytes, which must outlive the reader.
  static absl::StatusOr<AgentLogReader> Parse(absl::string_view bytes);

  // The next entry that is whole; nullopt at the end. What is damaged is
  // skipped and counted, what is of an unknown kind is skipped.
  std::optional<LogEntry> Next();

  // From now on, frames are counted and passed over without being copied.
  void SkipFrames() { skips_frames_ = true; }
  int64_t skipped_frames() const { return skipped_frames_; }

  // Bytes that belong to no whole entry, so far. An unfinished last entry, as
  // a kill leaves it, is among them.
  int64_t damaged_bytes() const { return damaged_bytes_; }
  // Where the last whole entry ended.
  size_t end_of_last_entry() const { return end_of_last_; }
  size_t size() const { return bytes_.size(); }

 private:
  AgentLogReader() = default;

  // Behind `bytes_`, if it was opened as a file.
  std::shared_ptr<const base::MappedFile> file_;
  absl::string_view bytes_;
  size_t at_ = 0;
  size_t end_of_last_ = 0;
  int64_t damaged_bytes_ = 0;
  bool skips_frames_ = false;
  int64_t skipped_frames_ = 0;
};

// ---- for tests and other programs: one entry in bytes ----

// A whole record with its header.
std::string EncodeLogRecord(const LogEntry& entry);
// What stands before the first.
std::string AgentLogHeader();

}  // namespace treeline::recording

#endif  // NAV_AGENT_RECORDING_AGENT_LOG_H_
