// Between files of logs, by what they are.
#ifndef NAV_AGENT_ROS_LOG_CONVERT_LOG_H_
#define NAV_AGENT_ROS_LOG_CONVERT_LOG_H_

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "common/base/temporary_folder.h"
#include "common/mcap/mcap_compression.h"
#include "nav_agent/recording/laser_log.h"
#include "nav_agent/recording/log_correction.h"
#include "nav_agent/ros_log/bag_to_log.h"

namespace treeline::ros_log {

struct ConvertOptions {
  BagLogOptions bag{};
  mcap::Compression compression = mcap::Compression::kZstd;
  // Written into an MCAP file, too, if not empty: a map (map_server's YAML),
  // and a trajectory "time tx ty tz qx qy qz qw" (TUM).
  std::string map{};
  std::string trajectory{};
};

struct ConvertedLog {
  // "agent log", "recording of ROS", "laser log".
  std::string from;
  int64_t entries = 0;
  // Of MCAP.
  int64_t messages = 0;
  std::vector<std::string> notes;
};

// `log` as entries of an agent's log: its scans, its odometry as wheel readings
// of the default robot, and where the laser is.
std::vector<recording::LogEntry> EntriesOf(const recording::LaserLog& log);

// Reads an agent log, a recording of ROS (bag::OpenBag) or a public laser log
// (recording::ReadLaserLog) and hands over what it holds.
absl::StatusOr<ConvertedLog> ReadAnyLog(const std::string& path,
                                        const BagLogOptions& options,
                                        const TakeEntry& take);

// Writes MCAP if `to` ends in .mcap, else an agent log. ALREADY_EXISTS if there
// is a file `to`; after an error there is none.
absl::StatusOr<ConvertedLog> ConvertLog(const std::string& from,
                                        const std::string& to,
                                        const ConvertOptions& options);

// A recording of ROS as a temporary agent log, for what reads only those; so
// any log that is corrected; any other file as it is.
class AsAgentLog {
 public:
  // The errors of reading.
  static absl::StatusOr<AsAgentLog> Open(const std::string& path,
                                         bool with_frames);
  // INVALID_ARGUMENT: a public laser log, which tells poses and not wheels.
  static absl::StatusOr<AsAgentLog> Open(
      const std::string& path, bool with_frames,
      const recording::LogCorrection& correction);

  const std::string& path() const { return path_; }
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  AsAgentLog(std::string path, std::optional<base::TemporaryFolder> folder)
      : path_(std::move(path)), folder_(std::move(folder)) {}

  std::string path_;
  std::optional<base::TemporaryFolder> folder_;  // that it lies in
  std::vector<std::string> notes_;
};

}  // namespace treeline::ros_log

#endif  // NAV_AGENT_ROS_LOG_CONVERT_LOG_H_
