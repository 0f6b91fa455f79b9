// An agent's log as MCAP with ROS 2's messages (docs/reference/log.md).
#ifndef NAV_AGENT_ROS_LOG_LOG_TO_MCAP_H_
#define NAV_AGENT_ROS_LOG_LOG_TO_MCAP_H_

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/mcap/mcap_writer.h"
#include "common/ros2/messages/message_codec.h"
#include "common/ros2/messages/message_schema.h"
#include "common/ros2/messages/nav_messages.h"
#include "nav_agent/core/slope_odometry.h"
#include "nav_agent/recording/agent_log.h"

namespace treeline::ros_log {

// Not thread-safe.
class LogToMcap {
 public:
  // The errors of McapWriter::Open.
  static absl::StatusOr<std::unique_ptr<LogToMcap>> Open(
      const std::string& path, mcap::Compression compression);

  // In the log's order. UNAVAILABLE: the disk is full.
  absl::Status Add(const recording::LogEntry& entry);
  // A map and a trajectory, at the time of the newest entry.
  absl::Status AddMap(const messages::OccupancyGrid& map);
  absl::Status AddPath(const messages::Path& path);
  absl::Status Close() { return writer_->Close(); }

  int64_t messages() const { return messages_; }
  int64_t newest_ns() const { return newest_ns_; }
  // What could not be carried over, a sentence each.
  const std::set<std::string>& notes() const { return notes_; }

 private:
  explicit LogToMcap(std::unique_ptr<mcap::McapWriter> writer)
      : writer_(std::move(writer)) {}

  template <messages::Message M>
  absl::Status Write(const char* topic, int64_t time_ns, const M& message);
  // What holds for what follows is written at the time of what follows first.
  absl::Status WriteDescription(int64_t time_ns);
  absl::Status Take(const recording::LogInformation& information);
  absl::Status Take(const core::RangeSensorInfo& info);
  absl::Status Take(const camera::RgbdCalibration& calibration);
  absl::Status Take(const core::RobotModel& robot);
  absl::Status Take(const core::LaserScan& scan);
  absl::Status Take(const core::BaseReading& reading);
  absl::Status Take(const recording::LogFrame& frame);
  absl::Status Take(const recording::LogTruePose& pose);
  absl::Status Take(const recording::LogEvent& event);
  absl::Status Take(const recording::LogCommand& command);

  const std::unique_ptr<mcap::McapWriter> writer_;
  std::map<std::string, uint16_t> channels_;
  std::optional<core::RangeSensorInfo> laser_;
  std::optional<camera::RgbdCalibration> calibration_;
  core::RobotModel robot_;
  bool has_robot_ = false;
  bool is_description_written_ = false;
  // Of the recording, until there is a time for it.
  std::vector<std::string> information_;
  std::optional<core::SlopeOdometry> odometry_;
  int64_t newest_ns_ = 0;
  int64_t messages_ = 0;
  std::set<std::string> notes_;
};

}  // namespace treeline::ros_log

#endif  // NAV_AGENT_ROS_LOG_LOG_TO_MCAP_H_
