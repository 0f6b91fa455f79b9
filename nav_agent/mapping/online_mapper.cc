#include "nav_agent/mapping/online_mapper.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/sample_statistics.h"
#include "common/base/status_macros.h"
#include "common/geometry/planar_pose.h"
#include "nav_agent/mapping/grid_mapping.h"

namespace treeline::mapping {
namespace {

// A scan may be as far from the wheels' readings as this, where they begin and
// where they end.
constexpr std::chrono::milliseconds kWithoutReading(200);
// So many scans wait for the wheels; then the oldest is given up.
constexpr size_t kMaxWaitingReadings = 400;
// Grids: every so often a scan, if the robot did not turn faster (rad a scan);
// floors are apart by at least kFloors_m and have so many scans.
constexpr double kKeep_m = 0.1;
constexpr double kKeep_rad = 0.1;
constexpr double kMaxTurn_rad = 0.01;
constexpr double kFloors_m = 0.15;
constexpr int64_t kMinScans = 10;

int64_t Nanoseconds(base::MonotonicTime stamp) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             stamp.time_since_epoch())
      .count();
}

double SecondsOf(recording::RecordingTime time) {
  return std::chrono::duration<double>(time.time_since_epoch()).count();
}

const char* FoundBy(SegmentWitness who) {
  switch (who) {
    case SegmentWitness::kScans:
      return "scans found it";
    case SegmentWitness::kBelief:
      return "it had stayed where it was, as scans said";
    case SegmentWitness::kServer:
      return "the server found it, and scans confirmed it";
  }
  return "?";
}

bool IsLevel(const geometry::Rotation3& level_from_base) {
  return std::hypot(level_from_base.x, level_from_base.y) < 1e-4;
}

}  // namespace

absl::StatusOr<std::unique_ptr<OnlineMapper>> OnlineMapper::Create(
    const core::RangeSensorInfo& laser, const core::RobotModel& robot,
    const RecordingMapOptions& options) {
  TL_RETURN_IF_ERROR(robot.Validate());
  TL_RETURN_IF_ERROR(options.grid.Validate());
  core::SlopeOdometryOptions odometry_options = options.odometry;
  odometry_options.wheel_track_m = robot.wheel_track_m;
  TL_ASSIGN_OR_RETURN(core::SlopeOdometry odometry,
                      core::SlopeOdometry::Create(odometry_options));
  LaserSlamOptions slam_options = options.slam;
  slam_options.odometry = options.odometry_noise;
  slam_options.notices_carries = options.notices_carries;
  TL_ASSIGN_OR_RETURN(
      std::unique_ptr<LaserSlam> slam,
      LaserSlam::Create(laser, robot.base_from_laser, slam_options));
  return std::unique_ptr<OnlineMapper>(new OnlineMapper(
      laser, robot, options, std::move(odometry), std::move(slam)));
}

OnlineMapper::OnlineMapper(const core::RangeSensorInfo& laser,
                           const core::RobotModel& robot,
                           const RecordingMapOptions& options,
                           core::SlopeOdometry odometry,
                           std::unique_ptr<LaserSlam> slam)
    : laser_(laser),
      robot_(robot),
      options_(options),
      odometry_(std::move(odometry)),
      slam_(std::move(slam)) {}

base::MonotonicTime OnlineMapper::EndOf(const core::LaserScan& scan) const {
  const double length_s =
      std::clamp(laser_.beam_interval_s * (laser_.beams - 1), 0.0, 1.0);
  return scan.stamp + std::chrono::nanoseconds(std::llround(1e9 * length_s));
}

absl::Status OnlineMapper::Add(const core::BaseReading& reading) {
  if (absl::Status status = odometry_.Add(reading); !status.ok()) {
    if (refused_readings_++ == 0) first_refused_reading_ = status;
    return status;
  }
  samples_.push_back({.stamp = reading.stamp,
                      .odom_from_base = odometry_.PlanarOdomFromBase(),
                      .height_m = odometry_.height_m(),
                      .level_from_base = odometry_.LevelFromBase()});
  UseWaiting(false);
  Forget();
  return absl::OkStatus();
}

absl::Status OnlineMapper::Add(core::LaserScan scan) {
  if (static_cast<int>(scan.ranges_m.size()) != laser_.beams) {
    ++wrong_beams_;
    return absl::InvalidArgumentError(
        absl::StrCat("a scan of ", scan.ranges_m.size(),
                     " beams from a laser of ", laser_.beams));
  }
  if (last_scan_.has_value() && scan.stamp < *last_scan_) {
    ++scans_back_in_time_;
    return absl::InvalidArgumentError("the laser's clock jumped back");
  }
  last_scan_ = scan.stamp;
  waiting_.push_back(std::move(scan));
  UseWaiting(false);
  if (waiting_.size() > kMaxWaitingReadings) {
    ++scans_without_odometry_;
    waiting_.pop_front();
  }
  return absl::OkStatus();
}

// What no scan can need any more.
void OnlineMapper::Forget() {
  const base::MonotonicTime needed =
      (waiting_.empty() ? samples_.back().stamp : waiting_.front().stamp) -
      kWithoutReading;
  while (samples_.size() > 2 && samples_[1].stamp < needed) {
    samples_.pop_front();
  }
}

OnlineMapper::Sample OnlineMapper::At(base::MonotonicTime time) const {
  const auto after =
      std::lower_bound(samples_.begin(), samples_.end(), time,
                       [](const Sample& sample, base::MonotonicTime t) {
                         return sample.stamp < t;
                       });
  if (after == samples_.end()) return samples_.back();
  if (after == samples_.begin() || after->stamp == time) return *after;
  const Sample& a = *(after - 1);
  const Sample& b = *after;
  const double part = std::chrono::duration<double>(time - a.stamp) /
                      std::chrono::duration<double>(b.stamp - a.stamp);
  const geometry::Rigid2 motion = a.odom_from_base.Inverse() * b.odom_from_base;
  return {.stamp = time,
          .odom_from_base =
              a.odom_from_base * geometry::Rigid2{part * motion.translation,
                                                  part * motion.yaw_rad},
          .height_m = a.height_m + part * (b.height_m - a.height_m),
          .level_from_base =
              geometry::Slerp(a.level_from_base, b.level_from_base, part)};
}

void OnlineMapper::UseWaiting(bool all) {
  while (!waiting_.empty() && (all || !samples_.empty())) {
    const core::LaserScan& scan = waiting_.front();
    if (!all && samples_.back().stamp < EndOf(scan)) return;
    if (samples_.empty() ||
        scan.stamp < samples_.front().stamp - kWithoutReading ||
        scan.stamp > samples_.back().stamp + kWithoutReading) {
      ++scans_without_odometry_;
    } else {
      Use(scan);
    }
    waiting_.pop_front();
  }
}

void OnlineMapper::Use(const core::LaserScan& scan) {
  const Sample first = At(scan.stamp);
  const Sample last = At(EndOf(scan));
  const geometry::Rigid2 first_from_last =
      first.odom_from_base.Inverse() * last.odom_from_base;
  const auto place =
      slam_->AddScan({.stamp = recording::RecordingTime(
                          std::chrono::duration_cast<std::chrono::nanoseconds>(
                              scan.stamp.time_since_epoch())),
                      .odom_from_base = first.odom_from_base,
                      .ranges_m = scan.ranges_m,
                      .level_from_base = first.level_from_base,
                      .height_m = first.height_m,
                      .first_from_last = first_from_last});
  // All that it refuses was refused before.
  if (!place.ok()) return;
  odom_from_base_.push_back(
      {.time = Nanoseconds(scan.stamp),
       .world_from_camera = treeline::mapping::MapFromBase(
           {.stamp = {},
            .map_from_base = first.odom_from_base,
            .height_m = first.height_m,
            .level_from_base = first.level_from_base})});
  last_ = {.stamp = {},
           .map_from_base = *place,
           .height_m = slam_->Height_m(),
           .level_from_base = first.level_from_base};
  if (options_.has_grids) KeepForGrid(scan, first, first_from_last);
}

void OnlineMapper::KeepForGrid(const core::LaserScan& scan,
                               const Sample& sample,
                               const geometry::Rigid2& first_from_last) {
  const geometry::Rigid2 motion =
      odom_from_kept_.Inverse() * sample.odom_from_base;
  const bool has_moved = kept_.empty() ||
                         geometry::Norm(motion.translation) >= kKeep_m ||
                         std::abs(motion.yaw_rad) >= kKeep_rad;
  if (!has_moved || !IsLevel(sample.level_from_base) ||
      std::abs(first_from_last.yaw_rad) > kMaxTurn_rad) {
    return;
  }
  odom_from_kept_ = sample.odom_from_base;
  kept_.push_back(
      {.place = odom_from_base_.size() - 1, .ranges_m = scan.ranges_m});
}

std::optional<dataset::TimedPose> OnlineMapper::MapFromBase() const {
  if (odom_from_base_.empty() || slam_->IsLost()) return std::nullopt;
  return dataset::TimedPose{
      .time = odom_from_base_.back().time,
      .world_from_camera = treeline::mapping::MapFromBase(last_)};
}

bool OnlineMapper::SuggestPlace(base::MonotonicTime stamp,
                                const geometry::Rigid3& map_from_base) {
  const geometry::Vec3& at = map_from_base.translation;
  return slam_->SuggestPlace(
      recording::RecordingTime(
          std::chrono::duration_cast<std::chrono::nanoseconds>(
              stamp.time_since_epoch())),
      geometry::PlanarPose(map_from_base), at.z);
}

std::vector<dataset::TimedPose> OnlineMapper::Trajectory() const {
  return Timed(slam_->Trajectory());
}

std::vector<dataset::TimedPose> OnlineMapper::Timed(
    const std::vector<TrajectoryPose>& trajectory) const {
  std::vector<dataset::TimedPose> timed;
  timed.reserve(trajectory.size());
  for (size_t i = 0; i < trajectory.size(); ++i) {
    if (!trajectory[i].is_known) continue;
    timed.push_back(
        {.time = odom_from_base_[i].time,
         .world_from_camera = treeline::mapping::MapFromBase(trajectory[i])});
  }
  return timed;
}

absl::StatusOr<std::vector<FloorGrid>> OnlineMapper::Floors() const {
  return Floors(slam_->Trajectory());
}

absl::StatusOr<std::vector<FloorGrid>> OnlineMapper::Floors(
    const std::vector<TrajectoryPose>& trajectory) const {
  std::vector<const KeptScan*> by_height;
  for (const KeptScan& kept : kept_) {
    if (trajectory[kept.place].is_known) by_height.push_back(&kept);
  }
  const auto height_m = [&trajectory](const KeptScan* kept) {
    return trajectory[kept->place].height_m;
  };
  std::stable_sort(by_height.begin(), by_height.end(),
                   [&height_m](const KeptScan* a, const KeptScan* b) {
                     return height_m(a) < height_m(b);
                   });
  const geometry::Rigid2 base_from_laser =
      geometry::PlanarPose(robot_.base_from_laser);
  std::vector<FloorGrid> floors;
  size_t begin = 0;
  for (size_t i = 1; i <= by_height.size(); ++i) {
    if (i < by_height.size() &&
        height_m(by_height[i]) - height_m(by_height[i - 1]) < kFloors_m) {
      continue;
    }
    std::vector<GridScan> scans;
    double sum_m = 0;
    for (size_t k = begin; k < i; ++k) {
      const KeptScan& kept = *by_height[k];
      sum_m += height_m(by_height[k]);
      scans.push_back({.map_from_laser = trajectory[kept.place].map_from_base *
                                         base_from_laser,
                       .ranges_m = kept.ranges_m});
    }
    begin = i;
    const auto count = static_cast<int64_t>(scans.size());
    if (count < kMinScans) continue;
    TL_ASSIGN_OR_RETURN(core::OccupancyGrid grid,
                        MapGrid(scans, laser_, options_.grid));
    floors.push_back({.height_m = sum_m / static_cast<double>(count),
                      .scans = count,
                      .grid = std::move(grid)});
  }
  return floors;
}

std::vector<std::string> OnlineMapper::Warnings() const {
  std::vector<std::string> warnings;
  const auto warn = [&warnings](int64_t count, const std::string& what) {
    if (count > 0) warnings.push_back(absl::StrCat(count, what));
  };
  warn(wrong_beams_, absl::StrCat(" scans were left out that have another "
                                  "number of beams than the laser, ",
                                  laser_.beams));
  warn(scans_back_in_time_,
       " scans were left out because the laser's clock jumped back");
  warn(scans_without_odometry_,
       " scans were left out because there are no wheel readings of their "
       "time");
  warn(refused_readings_,
       absl::StrCat(" wheel readings were left out, the first because: ",
                    std::string(first_refused_reading_.message())));
  warn(odometry_.resets(),
       " times the wheels' counters jumped: the robot is taken to have stood");
  return warnings;
}

std::vector<std::string> OnlineMapper::CarryWarnings(
    const std::vector<TrajectoryPose>& trajectory) const {
  std::vector<std::string> warnings;
  for (const Carry& carry : Carries()) {
    if (carry.found.has_value()) {
      warnings.push_back(absl::StrFormat(
          "at %.1f s the robot was carried off, or thought so; %s after %.1f s",
          SecondsOf(carry.at), FoundBy(carry.who),
          recording::SecondsBetween(carry.at, *carry.found)));
    } else {
      warnings.push_back(absl::StrFormat(
          "at %.1f s the robot was carried off, to a place that the map does "
          "not have, and did not come back to where it had been",
          SecondsOf(carry.at)));
    }
  }
  const auto unknown =
      std::count_if(trajectory.begin(), trajectory.end(),
                    [](const TrajectoryPose& pose) { return !pose.is_known; });
  if (unknown > 0) {
    warnings.push_back(absl::StrCat(
        unknown, " of ", trajectory.size(),
        " scans were left out, and the frames of their time: nobody knows "
        "where the robot was carried meanwhile"));
  }
  return warnings;
}

absl::StatusOr<RecordingMap> OnlineMapper::Finish() {
  UseWaiting(true);
  slam_->Finish();
  const std::vector<TrajectoryPose> trajectory = slam_->Trajectory();
  RecordingMap mapping;
  mapping.laser = laser_;
  mapping.base_from_laser = robot_.base_from_laser;
  mapping.map_from_base = Timed(trajectory);
  if (!trajectory.empty() && trajectory.back().is_known) {
    last_ = trajectory.back();
  }
  for (size_t i = 0; i < trajectory.size(); ++i) {
    if (trajectory[i].is_known) {
      mapping.odom_from_base.push_back(odom_from_base_[i]);
    }
  }
  mapping.statistics = slam_->Statistics();
  const std::vector<double>& times_ms = mapping.statistics.front_end_ms;
  mapping.p50_ms = base::Quantile(times_ms, 0.50);
  mapping.p99_ms = base::Quantile(times_ms, 0.99);
  mapping.max_ms = base::Quantile(times_ms, 1.0);
  if (options_.has_grids) {
    TL_ASSIGN_OR_RETURN(mapping.floors, Floors(trajectory));
  }
  mapping.refused_scans =
      wrong_beams_ + scans_back_in_time_ + scans_without_odometry_;
  mapping.refused_readings = refused_readings_;
  mapping.warnings = Warnings();
  for (std::string& warning : CarryWarnings(trajectory)) {
    mapping.warnings.push_back(std::move(warning));
  }
  return mapping;
}

}  // namespace treeline::mapping
