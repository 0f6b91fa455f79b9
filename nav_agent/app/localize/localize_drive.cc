#include "nav_agent/app/localize/localize_drive.h"

#include <algorithm>
#include <chrono>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "common/base/status_macros.h"
#include "nav_agent/core/slope_odometry.h"
#include "nav_agent/recording/agent_log.h"

namespace treeline::localize_app {
namespace {

struct OdometrySample {
  base::MonotonicTime stamp;
  geometry::Rigid2 odom_from_base;
  geometry::Rotation3 level_from_base;
};

base::MonotonicTime Later(base::MonotonicTime time, double seconds) {
  return time + std::chrono::duration_cast<base::MonotonicTime::duration>(
                    std::chrono::duration<double>(seconds));
}

geometry::Rigid2 Between(const geometry::Rigid2& a, const geometry::Rigid2& b,
                         double t) {
  return {a.translation + t * (b.translation - a.translation),
          geometry::NormalizedAngle_rad(
              a.yaw_rad +
              t * geometry::NormalizedAngle_rad(b.yaw_rad - a.yaw_rad))};
}

// What of a log localization needs, in the order of arrival.
class DriveBuilder {
 public:
  explicit DriveBuilder(const DriveReadOptions& options) : options_(options) {}

  absl::Status Add(recording::LogEntry entry) {
    if (const auto* robot = std::get_if<core::RobotModel>(&entry)) {
      drive_.base_from_laser = robot->base_from_laser;
      wheel_track_m_ = robot->wheel_track_m;
    } else if (const auto* info = std::get_if<core::RangeSensorInfo>(&entry)) {
      drive_.laser = *info;
      has_laser_ = true;
    } else if (const auto* reading = std::get_if<core::BaseReading>(&entry)) {
      return AddReading(*reading);
    } else if (auto* scan = std::get_if<core::LaserScan>(&entry)) {
      AddScan(std::move(*scan));
    } else if (const auto* truth =
                   std::get_if<recording::LogTruePose>(&entry)) {
      truth_.push_back(*truth);
    }
    return absl::OkStatus();
  }

  absl::StatusOr<RecordedDrive> Finish(const std::string& path,
                                       int64_t damaged_bytes) {
    if (!has_laser_) {
      return absl::FailedPreconditionError(
          absl::StrCat(path, ": the log names no laser scanner"));
    }
    if (samples_.empty()) {
      return absl::FailedPreconditionError(
          absl::StrCat(path, ": the log has no usable wheel reading (",
                       drive_.refused_readings, " were refused)"));
    }
    for (core::LaserScan& scan : scans_) Place(scan);
    if (drive_.scans.empty()) {
      return absl::FailedPreconditionError(
          absl::StrCat(path, ": the log has no usable scan (",
                       drive_.refused_scans, " were refused)"));
    }
    drive_.has_tilt = true;
    drive_.damaged_bytes = damaged_bytes;
    return std::move(drive_);
  }

 private:
  absl::Status AddReading(const core::BaseReading& reading) {
    if (!odometry_.has_value()) {
      TL_ASSIGN_OR_RETURN(odometry_, core::SlopeOdometry::Create(
                                         {.wheel_track_m = wheel_track_m_}));
    }
    if (!odometry_->Add(reading).ok()) {
      ++drive_.refused_readings;
      return absl::OkStatus();
    }
    samples_.push_back({.stamp = reading.stamp,
                        .odom_from_base = odometry_->PlanarOdomFromBase(),
                        .level_from_base = odometry_->LevelFromBase()});
    return absl::OkStatus();
  }

  void AddScan(core::LaserScan scan) {
    if (!has_laser_ ||
        std::cmp_not_equal(scan.ranges_m.size(), drive_.laser.beams) ||
        (!scans_.empty() && scan.stamp <= last_scan_)) {
      ++drive_.refused_scans;
      return;
    }
    last_scan_ = scan.stamp;
    if (!scans_.empty() &&
        base::SecondsBetween(scans_.back().stamp, scan.stamp) <
            options_.min_interval_s) {
      return;
    }
    scan.intensities.clear();
    scans_.push_back(std::move(scan));
  }

  // Between the samples around the scan's middle.
  void Place(core::LaserScan& scan) {
    const base::MonotonicTime middle =
        Later(scan.stamp,
              0.5 * drive_.laser.beam_interval_s * (drive_.laser.beams - 1));
    const auto after =
        std::ranges::lower_bound(samples_, middle, {}, &OdometrySample::stamp);
    // Where wheels were read in that moment, no matter when before: logs of
    // people who wrote both together are few a minute.
    const bool is_exact = after != samples_.end() && after->stamp == middle;
    if (!is_exact && (after == samples_.begin() || after == samples_.end() ||
                      base::SecondsBetween((after - 1)->stamp, after->stamp) >
                          options_.max_gap_s)) {
      ++drive_.refused_scans;
      return;
    }
    const OdometrySample& before = is_exact ? *after : *(after - 1);
    const double t = is_exact
                         ? 0
                         : base::SecondsBetween(before.stamp, middle) /
                               base::SecondsBetween(before.stamp, after->stamp);
    drive_.scans.push_back(
        {.stamp = recording::RecordingTime(
             std::chrono::duration_cast<std::chrono::nanoseconds>(
                 middle.time_since_epoch())),
         .odom_from_base =
             Between(before.odom_from_base, after->odom_from_base, t),
         .level_from_base =
             geometry::Slerp(before.level_from_base, after->level_from_base, t),
         .ranges_m = std::move(scan.ranges_m),
         .world_from_base = TruthAt(middle)});
  }

  std::optional<geometry::Rigid3> TruthAt(base::MonotonicTime time) const {
    const auto after = std::ranges::lower_bound(truth_, time, {},
                                                &recording::LogTruePose::stamp);
    if (after == truth_.begin() || after == truth_.end()) return std::nullopt;
    const recording::LogTruePose& before = *(after - 1);
    const double gap_s = base::SecondsBetween(before.stamp, after->stamp);
    if (!(gap_s > 0) || gap_s > options_.max_gap_s) return std::nullopt;
    const double t = base::SecondsBetween(before.stamp, time) / gap_s;
    const geometry::Vec3& a = before.world_from_base.translation;
    const geometry::Vec3& b = after->world_from_base.translation;
    return geometry::Rigid3{
        .rotation = geometry::Slerp(before.world_from_base.rotation,
                                    after->world_from_base.rotation, t),
        .translation = a + t * (b - a)};
  }

  DriveReadOptions options_;
  RecordedDrive drive_;
  bool has_laser_ = false;
  double wheel_track_m_ = core::RobotModel().wheel_track_m;
  std::optional<core::SlopeOdometry> odometry_;
  std::vector<OdometrySample> samples_;
  std::vector<core::LaserScan> scans_;
  std::vector<recording::LogTruePose> truth_;
  base::MonotonicTime last_scan_;
};

}  // namespace

RecordedDrive DriveOf(const recording::LaserLog& log) {
  RecordedDrive drive;
  drive.laser = log.laser;
  const geometry::Rigid2& laser = log.base_from_laser;
  drive.base_from_laser = {
      .rotation = geometry::Rotation3::FromAxisAngle({0, 0, laser.yaw_rad}),
      .translation = {laser.translation.x, laser.translation.y, 0}};
  drive.scans.reserve(log.scans.size());
  for (const recording::RecordedScan& scan : log.scans) {
    drive.scans.push_back({.stamp = scan.stamp,
                           .odom_from_base = scan.odom_from_base,
                           .level_from_base = {},
                           .ranges_m = scan.ranges_m,
                           .world_from_base = std::nullopt});
  }
  return drive;
}

absl::StatusOr<RecordedDrive> ReadDrive(const std::string& path,
                                        const DriveReadOptions& options) {
  absl::StatusOr<recording::AgentLogReader> reader =
      recording::AgentLogReader::Open(path);
  if (absl::IsDataLoss(reader.status())) {
    TL_ASSIGN_OR_RETURN(const recording::LaserLog log,
                        recording::ReadLaserLog(path));
    return DriveOf(log);
  }
  TL_RETURN_IF_ERROR(reader.status());
  DriveBuilder builder(options);
  while (std::optional<recording::LogEntry> entry = reader->Next()) {
    TL_RETURN_IF_ERROR(builder.Add(*std::move(entry)));
  }
  return builder.Finish(path, reader->damaged_bytes());
}

}  // namespace treeline::localize_app
