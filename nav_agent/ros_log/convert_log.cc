#include "nav_agent/ros_log/convert_log.h"

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/dataset/text_formats.h"
#include "common/ros2/bag/open_bag.h"
#include "common/ros2/conversions/geometry_values.h"
#include "nav_agent/bridge/agent_values/laser_values.h"
#include "nav_agent/core/map_file.h"
#include "nav_agent/ros_log/log_to_mcap.h"
#include "nav_agent/ros_log/log_topics.h"
#include "nav_agent/ros_log/wheels_of_odometry.h"

namespace treeline::ros_log {
namespace {

namespace fs = std::filesystem;

base::MonotonicTime StampOf(recording::RecordingTime time) {
  return base::MonotonicTime(time.time_since_epoch());
}

void Remove(const std::string& path) {
  std::error_code ignored;
  fs::remove(path, ignored);
}

absl::Status AddTrajectory(const std::string& file, LogToMcap& writer) {
  TL_ASSIGN_OR_RETURN(const std::string text, base::ReadFile(file));
  TL_ASSIGN_OR_RETURN(const std::vector<dataset::TimedPose> poses,
                      dataset::ParseTimedPoses(text, file));
  messages::Path path;
  path.header = {.stamp = messages::TimeOf(writer.newest_ns()),
                 .frame_id = kMapFrame};
  for (const dataset::TimedPose& pose : poses) {
    path.poses.push_back({.header = {.stamp = messages::TimeOf(pose.time),
                                     .frame_id = kMapFrame},
                          .pose = conversions::PoseOf(pose.world_from_camera)});
  }
  return writer.AddPath(path);
}

absl::Status AddMapAndTrajectory(const ConvertOptions& options,
                                 LogToMcap& writer) {
  if (!options.map.empty()) {
    TL_ASSIGN_OR_RETURN(const core::OccupancyGrid grid,
                        core::ReadMap(options.map));
    TL_RETURN_IF_ERROR(writer.AddMap(agent_values::MessageOf(
        grid, {.stamp = messages::TimeOf(writer.newest_ns()),
               .frame_id = kMapFrame})));
  }
  return options.trajectory.empty() ? absl::OkStatus()
                                    : AddTrajectory(options.trajectory, writer);
}

absl::StatusOr<ConvertedLog> ToMcap(const std::string& from,
                                    const std::string& to,
                                    const ConvertOptions& options) {
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<LogToMcap> writer,
                      LogToMcap::Open(to, options.compression));
  TL_ASSIGN_OR_RETURN(
      ConvertedLog converted,
      ReadAnyLog(from, options.bag, [&](const recording::LogEntry& entry) {
        return writer->Add(entry);
      }));
  TL_RETURN_IF_ERROR(AddMapAndTrajectory(options, *writer));
  TL_RETURN_IF_ERROR(writer->Close());
  converted.messages = writer->messages();
  converted.notes.insert(converted.notes.end(), writer->notes().begin(),
                         writer->notes().end());
  return converted;
}

absl::StatusOr<ConvertedLog> ToAgentLog(
    const std::string& from, const std::string& to,
    const BagLogOptions& options,
    const recording::LogCorrection& correction = {}) {
  const base::SteadyClock clock;
  TL_ASSIGN_OR_RETURN(
      const std::unique_ptr<recording::AgentLogWriter> writer,
      recording::AgentLogWriter::Open(to, /*append=*/false, clock));
  // Holds if the log names no robot.
  if (correction.robot.has_value()) {
    TL_RETURN_IF_ERROR(writer->Write(*correction.robot));
  }
  TL_ASSIGN_OR_RETURN(ConvertedLog converted,
                      ReadAnyLog(from, options, [&](recording::LogEntry entry) {
                        recording::Correct(correction, entry);
                        return writer->Write(entry);
                      }));
  TL_RETURN_IF_ERROR(writer->Flush());
  return converted;
}

}  // namespace

std::vector<recording::LogEntry> EntriesOf(const recording::LaserLog& log) {
  std::vector<recording::LogEntry> entries;
  core::RobotModel robot;
  const geometry::Rigid2& laser = log.base_from_laser;
  // No log says how high it is.
  robot.base_from_laser = {
      .rotation = geometry::Rotation3::FromAxisAngle({0, 0, laser.yaw_rad}),
      .translation = {laser.translation.x, laser.translation.y, 0}};
  entries.emplace_back(robot);
  entries.emplace_back(log.laser);
  WheelsOfOdometry wheels(robot.wheel_track_m);
  auto odometry = log.odometry.begin();
  for (const recording::RecordedScan& scan : log.scans) {
    for (; odometry != log.odometry.end() && odometry->stamp < scan.stamp;
         ++odometry) {
      entries.emplace_back(
          wheels.Add(StampOf(odometry->stamp), odometry->odom_from_base));
    }
    entries.emplace_back(wheels.Add(StampOf(scan.stamp), scan.odom_from_base));
    entries.emplace_back(core::LaserScan{.stamp = StampOf(scan.stamp),
                                         .ranges_m = scan.ranges_m,
                                         .intensities = {}});
  }
  for (; odometry != log.odometry.end(); ++odometry) {
    entries.emplace_back(
        wheels.Add(StampOf(odometry->stamp), odometry->odom_from_base));
  }
  return entries;
}

absl::StatusOr<ConvertedLog> ReadAnyLog(const std::string& path,
                                        const BagLogOptions& options,
                                        const TakeEntry& take) {
  ConvertedLog converted;
  const auto counted = [&](recording::LogEntry entry) {
    ++converted.entries;
    return take(std::move(entry));
  };
  if (bag::IsBag(path) || fs::is_directory(path)) {
    converted.from = "recording of ROS";
    TL_ASSIGN_OR_RETURN(const std::unique_ptr<bag::Bag> bag,
                        bag::OpenBag(path));
    auto read = ReadBagAsLog(*bag, options, counted);
    if (!read.ok()) return base::Annotate(read.status(), path);
    converted.notes = std::move(read->notes);
    return converted;
  }
  auto reader = recording::AgentLogReader::Open(path);
  if (reader.ok()) {
    converted.from = "agent log";
    if (!options.with_frames) reader->SkipFrames();
    while (std::optional<recording::LogEntry> entry = reader->Next()) {
      TL_RETURN_IF_ERROR(counted(*std::move(entry)));
    }
    if (reader->damaged_bytes() > 0) {
      converted.notes.push_back(absl::StrCat(
          reader->damaged_bytes(), " bytes are damaged and were passed over"));
    }
    return converted;
  }
  if (!absl::IsDataLoss(reader.status())) return reader.status();
  converted.from = "laser log";
  TL_ASSIGN_OR_RETURN(const recording::LaserLog log,
                      recording::ReadLaserLog(path));
  converted.notes = log.warnings;
  for (recording::LogEntry& entry : EntriesOf(log)) {
    TL_RETURN_IF_ERROR(counted(std::move(entry)));
  }
  return converted;
}

absl::StatusOr<ConvertedLog> ConvertLog(const std::string& from,
                                        const std::string& to,
                                        const ConvertOptions& options) {
  if (fs::exists(to)) {
    return absl::AlreadyExistsError(
        absl::StrCat(to, " is there already; remove it, or choose another"));
  }
  const bool is_mcap = absl::EndsWith(to, ".mcap");
  if (!is_mcap && !(options.map.empty() && options.trajectory.empty())) {
    return absl::InvalidArgumentError(
        "a map and a trajectory go into .mcap files alone");
  }
  auto converted =
      is_mcap ? ToMcap(from, to, options) : ToAgentLog(from, to, options.bag);
  if (!converted.ok()) Remove(to);
  return converted;
}

absl::StatusOr<AsAgentLog> AsAgentLog::Open(const std::string& path,
                                            bool with_frames) {
  return Open(path, with_frames, {});
}

absl::StatusOr<AsAgentLog> AsAgentLog::Open(
    const std::string& path, bool with_frames,
    const recording::LogCorrection& correction) {
  if (!bag::IsBag(path) && correction.IsNone()) {
    return AsAgentLog(path, std::nullopt);
  }
  TL_ASSIGN_OR_RETURN(base::TemporaryFolder folder,
                      base::TemporaryFolder::Make("treeline-log"));
  std::string temporary = folder.path() + "/log.tlog";
  AsAgentLog made(std::move(temporary), std::move(folder));
  BagLogOptions options;
  options.with_frames = with_frames;
  TL_ASSIGN_OR_RETURN(ConvertedLog converted,
                      ToAgentLog(path, made.path_, options, correction));
  if (converted.from == "laser log") {
    return absl::InvalidArgumentError(absl::StrCat(
        path,
        ": a laser log tells poses, not wheels: there is nothing to "
        "correct in it; leave --robot out"));
  }
  made.notes_ = std::move(converted.notes);
  return made;
}

}  // namespace treeline::ros_log
