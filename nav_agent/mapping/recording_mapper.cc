#include "nav_agent/mapping/recording_mapper.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <numbers>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/clock.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "nav_agent/mapping/online_mapper.h"
#include "nav_agent/mapping/run_laser_slam.h"
#include "nav_agent/mapping/seen_place.h"
#include "nav_agent/recording/agent_log.h"
#include "nav_agent/recording/laser_log.h"

namespace treeline::mapping {
namespace {

constexpr int64_t kProgressEvery = 50;  // scans

// One agent log on its way through a mapper.
class AgentLogMapping {
 public:
  explicit AgentLogMapping(const RecordingMapOptions& options)
      : options_(options) {}

  absl::Status Use(recording::LogEntry entry) {
    return std::visit([this](auto& value) { return Take(value); }, entry);
  }
  absl::StatusOr<RecordingMap> Finish();
  int64_t scans() const { return scans_; }

 private:
  absl::Status Take(const recording::LogInformation& information) {
    if (!mapping_.information.empty()) mapping_.information += '\n';
    mapping_.information += information.text;
    return absl::OkStatus();
  }
  absl::Status Take(const core::RangeSensorInfo& laser) {
    if (laser_.has_value() && *laser_ != laser) is_other_laser_ = true;
    if (!laser_.has_value() || *laser_ == laser) is_other_laser_ = false;
    if (!laser_.has_value()) laser_ = laser;
    return absl::OkStatus();
  }
  absl::Status Take(const camera::RgbdCalibration& calibration) {
    if (!mapping_.calibration.has_value()) mapping_.calibration = calibration;
    return absl::OkStatus();
  }
  absl::Status Take(const core::RobotModel& robot) {
    if (!mapping_.robot.has_value()) mapping_.robot = robot;
    return absl::OkStatus();
  }
  absl::Status Take(core::LaserScan& scan);
  absl::Status Take(const core::BaseReading& reading);
  absl::Status Take(const recording::LogTruePose& pose) {
    const dataset::Time_ns time =
        std::chrono::duration_cast<std::chrono::nanoseconds>(
            pose.stamp.time_since_epoch())
            .count();
    // As a trajectory that can be interpolated.
    if (mapping_.truth.empty() || mapping_.truth.back().time < time) {
      mapping_.truth.push_back(
          {.time = time, .world_from_camera = pose.world_from_base});
    }
    return absl::OkStatus();
  }
  absl::Status Take(const recording::LogFrame& /*frame*/) {
    return absl::OkStatus();
  }
  absl::Status Take(const recording::LogEvent& event) {
    const auto map_from_base = ParseSeenPlace(event.text);
    // A robot that was found meanwhile does not need it.
    if (map_from_base.has_value() && mapper_ != nullptr) {
      mapper_->SuggestPlace(event.stamp, *map_from_base);
    }
    return absl::OkStatus();
  }
  absl::Status Take(const recording::LogCommand& /*command*/) {
    return absl::OkStatus();
  }

  absl::Status MakeMapper() {
    const core::RobotModel& robot =
        mapping_.robot.has_value() ? *mapping_.robot : options_.robot;
    TL_ASSIGN_OR_RETURN(mapper_,
                        OnlineMapper::Create(*laser_, robot, options_));
    for (const core::BaseReading& reading : early_readings_) {
      // What is refused is counted.
      mapper_->Add(reading).IgnoreError();
    }
    early_readings_.clear();
    return absl::OkStatus();
  }

  const RecordingMapOptions& options_;
  RecordingMap mapping_;
  std::optional<core::RangeSensorInfo> laser_;
  bool is_other_laser_ = false;
  std::unique_ptr<OnlineMapper> mapper_;
  // Before the first scan.
  std::vector<core::BaseReading> early_readings_;
  int64_t scans_ = 0;
  int64_t readings_ = 0;
  int64_t scans_without_laser_ = 0;
  int64_t scans_of_other_laser_ = 0;
};

absl::Status AgentLogMapping::Take(core::LaserScan& scan) {
  ++scans_;
  if (!laser_.has_value()) {
    ++scans_without_laser_;
    return absl::OkStatus();
  }
  if (is_other_laser_) {
    ++scans_of_other_laser_;
    return absl::OkStatus();
  }
  if (mapper_ == nullptr) TL_RETURN_IF_ERROR(MakeMapper());
  mapper_->Add(std::move(scan)).IgnoreError();
  return absl::OkStatus();
}

absl::Status AgentLogMapping::Take(const core::BaseReading& reading) {
  ++readings_;
  if (mapper_ == nullptr) {
    early_readings_.push_back(reading);
  } else {
    mapper_->Add(reading).IgnoreError();
  }
  return absl::OkStatus();
}

absl::StatusOr<RecordingMap> AgentLogMapping::Finish() {
  if (scans_ == 0) {
    return absl::FailedPreconditionError("the log has no laser scans");
  }
  if (mapper_ == nullptr) {
    return absl::FailedPreconditionError(
        "the log does not say what its laser scanner is");
  }
  if (readings_ == 0) {
    return absl::FailedPreconditionError("the log has no wheel readings");
  }
  TL_ASSIGN_OR_RETURN(RecordingMap mapping, mapper_->Finish());
  if (mapping.map_from_base.empty()) {
    return absl::FailedPreconditionError(
        absl::StrCat("none of the log's scans can be used: ",
                     mapping.warnings.empty() ? "" : mapping.warnings.front()));
  }
  mapping.information = std::move(mapping_.information);
  mapping.robot = mapping_.robot;
  mapping.calibration = std::move(mapping_.calibration);
  mapping.truth = std::move(mapping_.truth);
  mapping.refused_scans += scans_without_laser_ + scans_of_other_laser_;
  if (scans_without_laser_ > 0) {
    mapping.warnings.push_back(absl::StrCat(
        scans_without_laser_,
        " scans were left out that came before the laser's description"));
  }
  if (scans_of_other_laser_ > 0) {
    mapping.warnings.push_back(
        absl::StrCat(scans_of_other_laser_,
                     " scans were left out that are of another laser than "
                     "the first"));
  }
  return mapping;
}

absl::StatusOr<RecordingMap> MapAgentLog(const std::string& path,
                                         const RecordingMapOptions& options) {
  TL_ASSIGN_OR_RETURN(recording::AgentLogReader reader,
                      recording::AgentLogReader::Open(path));
  reader.SkipFrames();
  AgentLogMapping log(options);
  int64_t told = 0;
  while (std::optional<recording::LogEntry> entry = reader.Next()) {
    if (options.stop.stop_requested()) {
      return absl::CancelledError("stopped while mapping");
    }
    TL_RETURN_IF_ERROR(log.Use(*std::move(entry)));
    if (options.progress && log.scans() >= told + kProgressEvery) {
      told = log.scans();
      options.progress(
          {.scans = told,
           .part = static_cast<double>(reader.end_of_last_entry()) /
                   static_cast<double>(reader.size())});
    }
  }
  TL_ASSIGN_OR_RETURN(RecordingMap mapping, log.Finish());
  mapping.frames = reader.skipped_frames();
  mapping.damaged_bytes = reader.damaged_bytes();
  if (mapping.damaged_bytes > 0) {
    mapping.warnings.push_back(
        absl::StrCat(mapping.damaged_bytes,
                     " bytes of the log are damaged and were passed over"));
  }
  return mapping;
}

absl::StatusOr<RecordingMap> MapLaserLog(const std::string& path,
                                         const RecordingMapOptions& options) {
  TL_ASSIGN_OR_RETURN(const recording::LaserLog log,
                      recording::ReadLaserLog(path));
  RunLaserSlamOptions run;
  run.slam = options.slam;
  run.grid = options.grid;
  run.stop = options.stop;
  if (options.progress) {
    run.progress = [&](size_t scans) {
      options.progress({.scans = static_cast<int64_t>(scans),
                        .part = static_cast<double>(scans) /
                                static_cast<double>(log.scans.size())});
    };
  }
  TL_ASSIGN_OR_RETURN(LaserSlamResult result, RunLaserSlam(log, run));
  RecordingMap mapping;
  mapping.format = RecordingFormat::kLaserLog;
  mapping.laser = log.laser;
  const geometry::Rigid2& mount = log.base_from_laser;
  mapping.base_from_laser = MapFromBase({.stamp = {}, .map_from_base = mount});
  for (size_t i = 0; i < log.scans.size(); ++i) {
    const dataset::Time_ns time = log.scans[i].stamp.time_since_epoch().count();
    mapping.map_from_base.push_back(
        {.time = time, .world_from_camera = MapFromBase(result.trajectory[i])});
    const geometry::Rigid2 odom_from_base =
        log.scans.front().odom_from_base.Inverse() *
        log.scans[i].odom_from_base;
    mapping.odom_from_base.push_back(
        {.time = time,
         .world_from_camera =
             MapFromBase({.stamp = {}, .map_from_base = odom_from_base})});
  }
  if (options.has_grids) {
    mapping.floors.push_back({.height_m = 0,
                              .scans = result.statistics.scans,
                              .grid = std::move(result.grid)});
  }
  mapping.p50_ms = result.p50_ms;
  mapping.p99_ms = result.p99_ms;
  mapping.max_ms = result.max_ms;
  mapping.statistics = std::move(result.statistics);
  mapping.warnings = log.warnings;
  return mapping;
}

void WarnOfUnmatched(RecordingMap& mapping) {
  const LaserSlamStatistics& s = mapping.statistics;
  if (s.unmatched == 0) return;
  constexpr double kDegPerRad = 180 / std::numbers::pi;
  mapping.warnings.push_back(absl::StrFormat(
      "%d of %d scans that were looked at matched nothing before them; where "
      "they are is odometry's, which may be wrong there by %.2f m and %.1f "
      "degrees (one standard deviation)",
      s.unmatched, s.looked_at, s.unmatched_sigma_m,
      s.unmatched_sigma_rad * kDegPerRad));
}

absl::StatusOr<bool> IsAgentLogFile(const std::string& path) {
  TL_ASSIGN_OR_RETURN(const base::MappedFile file,
                      base::MappedFile::Open(path));
  const absl::string_view bytes(reinterpret_cast<const char*>(file.data()),
                                static_cast<size_t>(file.size()));
  return recording::IsAgentLog(bytes);
}

}  // namespace

absl::Status RecordingMapOptions::Validate() const {
  TL_RETURN_IF_ERROR(slam.Validate());
  TL_RETURN_IF_ERROR(odometry.Validate());
  TL_RETURN_IF_ERROR(robot.Validate());
  return grid.Validate();
}

absl::StatusOr<RecordingMap> MapRecording(const std::string& path,
                                          const RecordingMapOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  const base::SteadyClock clock;
  const base::MonotonicTime start = clock.Now();
  TL_ASSIGN_OR_RETURN(const bool is_agent_log, IsAgentLogFile(path));
  auto mapping =
      is_agent_log ? MapAgentLog(path, options) : MapLaserLog(path, options);
  if (!mapping.ok()) return mapping;
  WarnOfUnmatched(*mapping);
  mapping->total_s = base::MillisecondsBetween(start, clock.Now()) / 1000;
  return mapping;
}

}  // namespace treeline::mapping
