#include "nav_agent/app/map/map_from_log.h"

#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <span>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "common/base/status_macros.h"
#include "common/dataset/tum.h"
#include "nav_agent/recording/agent_log.h"

namespace treeline::map_app {
namespace {

// Between two scans; a longer silence of the laser leaves a hole.
constexpr dataset::Time_ns kMaxGap_ns = 500'000'000;

dataset::Time_ns TimeOf(base::MonotonicTime stamp) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             stamp.time_since_epoch())
      .count();
}

// The ends of a scan's beams in the laser's frame.
std::vector<geometry::Vec3> PointsOf(const core::LaserScan& scan,
                                     const core::RangeSensorInfo& laser) {
  std::vector<geometry::Vec3> points;
  const int beams =
      std::min(laser.beams, static_cast<int>(scan.ranges_m.size()));
  for (int i = 0; i < beams; ++i) {
    const double range_m = scan.ranges_m[static_cast<size_t>(i)];
    if (!(range_m > laser.range_min_m && range_m < laser.range_max_m)) continue;
    const double angle_rad = laser.AngleOf_rad(i);
    points.push_back(
        {range_m * std::cos(angle_rad), range_m * std::sin(angle_rad), 0});
  }
  return points;
}

// The second pass: what a log's frames and scans show, where the robot was.
class LogFuser {
 public:
  LogFuser(const MapOptions& options, const mapping::RecordingMap& drive,
           MapAssembly& assembly)
      : drive_(drive),
        assembly_(assembly),
        frame_gate_(options.keyframe_m, options.keyframe_rad),
        scan_gate_(options.scan_m, options.scan_rad) {}

  absl::Status Take(const recording::LogEntry& entry) {
    if (const auto* robot = std::get_if<core::RobotModel>(&entry))
      robot_ = *robot;
    if (const auto* laser = std::get_if<core::RangeSensorInfo>(&entry)) {
      laser_ = *laser;
    }
    if (const auto* camera = std::get_if<camera::RgbdCalibration>(&entry)) {
      return TakeCamera(*camera);
    }
    if (const auto* frame = std::get_if<recording::LogFrame>(&entry))
      return Take(*frame);
    if (const auto* scan = std::get_if<core::LaserScan>(&entry))
      return Take(*scan);
    return absl::OkStatus();
  }

  int64_t left_out() const { return left_out_; }
  const std::optional<std::string>& first_fault() const { return fault_; }

 private:
  absl::Status TakeCamera(const camera::RgbdCalibration& camera) {
    if (camera_.has_value() && *camera_ == camera) return absl::OkStatus();
    if (camera_.has_value()) {
      return absl::InvalidArgumentError(
          "the camera's calibration changes within the log; one map is of one "
          "camera");
    }
    camera_ = camera;
    return assembly_.SetCamera(camera);
  }

  std::optional<geometry::Rigid3> BaseAt(base::MonotonicTime stamp) const {
    return dataset::InterpolatePose(drive_.map_from_base, TimeOf(stamp),
                                    kMaxGap_ns);
  }

  absl::Status Take(const recording::LogFrame& frame) {
    const std::optional<geometry::Rigid3> map_from_base = BaseAt(frame.stamp);
    if (!map_from_base.has_value() || frame.depth.empty() ||
        !camera_.has_value()) {
      ++left_out_;
      return absl::OkStatus();
    }
    const geometry::Rigid3 map_from_camera =
        *map_from_base * robot_.base_from_camera;
    if (!frame_gate_.Passes(map_from_camera)) return absl::OkStatus();
    const absl::Status added = assembly_.AddKeyframe(
        frame.color, frame.depth, frame.depth_unit_m, map_from_camera);
    if (!absl::IsInvalidArgument(added)) return added;
    ++left_out_;
    if (!fault_.has_value()) {
      fault_ = absl::StrCat("frame ", frame.sequence, ": ", added.message());
    }
    return absl::OkStatus();
  }

  absl::Status Take(const core::LaserScan& scan) {
    const std::optional<geometry::Rigid3> map_from_base = BaseAt(scan.stamp);
    if (!map_from_base.has_value()) return absl::OkStatus();
    const geometry::Rigid3 map_from_laser =
        *map_from_base * robot_.base_from_laser;
    if (!scan_gate_.Passes(map_from_laser)) return absl::OkStatus();
    return assembly_.AddPoints(PointsOf(scan, laser_), map_from_laser);
  }

  const mapping::RecordingMap& drive_;
  MapAssembly& assembly_;
  MotionGate frame_gate_;
  MotionGate scan_gate_;
  core::RobotModel robot_;
  core::RangeSensorInfo laser_;
  std::optional<camera::RgbdCalibration> camera_;
  int64_t left_out_ = 0;
  std::optional<std::string> fault_;
};

absl::Status FuseLog(const std::string& log, const MapLogOptions& options,
                     MapAssembly& assembly, MapLogResult& result) {
  TL_ASSIGN_OR_RETURN(recording::AgentLogReader reader,
                      recording::AgentLogReader::Open(log));
  LogFuser fuser(options.map, result.drive, assembly);
  std::error_code error;
  const auto bytes =
      static_cast<double>(std::filesystem::file_size(log, error));
  while (std::optional<recording::LogEntry> entry = reader.Next()) {
    if (options.stop.stop_requested()) {
      return absl::CancelledError("interrupted");
    }
    TL_RETURN_IF_ERROR(fuser.Take(*entry));
    if (options.progress && bytes > 0) {
      options.progress("fusing",
                       static_cast<double>(reader.end_of_last_entry()) / bytes);
    }
  }
  result.frames_left_out = fuser.left_out();
  if (fuser.first_fault().has_value()) {
    result.warnings.push_back(*fuser.first_fault());
  }
  return absl::OkStatus();
}

std::optional<double> RmseOf(const mapping::RecordingMap& drive) {
  std::optional<geometry::Rigid3> world_from_map;
  double sum = 0;
  int64_t count = 0;
  for (const dataset::TimedPose& pose : drive.map_from_base) {
    const std::optional<geometry::Rigid3> truth =
        dataset::InterpolatePose(drive.truth, pose.time, kMaxGap_ns);
    if (!truth.has_value()) continue;
    if (!world_from_map.has_value()) {
      world_from_map = *truth * pose.world_from_camera.Inverse();
    }
    const geometry::Rigid3 estimate = *world_from_map * pose.world_from_camera;
    sum += geometry::SquaredNorm(estimate.translation - truth->translation);
    ++count;
  }
  if (count == 0) return std::nullopt;
  return std::sqrt(sum / static_cast<double>(count));
}

absl::StatusOr<MapSummary> FinishPlanar(const MapProvenance& provenance,
                                        const mapping::RecordingMap& drive,
                                        MapAssembly& assembly) {
  if (drive.floors.empty()) {
    return absl::FailedPreconditionError(
        "too little for a map: scans count every 10 cm, and a floor needs ten "
        "of them; drive a few metres");
  }
  std::vector<core::OccupancyGrid> grids;
  std::vector<double> heights_m;
  for (const mapping::FloorGrid& floor : drive.floors) {
    grids.push_back(floor.grid);
    heights_m.push_back(floor.height_m);
  }
  return assembly.FinishPlanar(provenance, grids, heights_m,
                               drive.base_from_laser.translation.z);
}

}  // namespace

absl::StatusOr<MapLogResult> MapLog(const std::string& log,
                                    const MapLogOptions& options) {
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<MapAssembly> assembly,
                      MapAssembly::Begin(options.map));
  mapping::RecordingMapOptions drive = options.drive;
  drive.grid.resolution_m = options.map.fusion.resolution_m;
  drive.stop = options.stop;
  drive.progress = [&options](const mapping::RecordingMapProgress& progress) {
    if (options.progress) options.progress("laser SLAM", progress.part);
  };
  MapLogResult result;
  TL_ASSIGN_OR_RETURN(result.drive, mapping::MapRecording(log, drive));
  result.warnings = result.drive.warnings;
  result.rmse_m = RmseOf(result.drive);
  if (result.drive.frames > 0) {
    TL_RETURN_IF_ERROR(FuseLog(log, options, *assembly, result));
  }
  const bool is_planar = assembly->keyframes() == 0;
  MapProvenance provenance = {
      .source = log,
      .method = is_planar ? "laser SLAM, planar" : "laser SLAM, RGB-D fused",
      .trajectory_of = "base",
      .trajectory = result.drive.map_from_base};
  if (is_planar) {
    for (dataset::TimedPose& pose : provenance.trajectory) {
      pose.time += options.scan_delay.count();
    }
  }
  if (result.drive.robot.has_value()) {
    provenance.half_width_m = result.drive.robot->half_width_m;
  }
  if (is_planar) {
    absl::StatusOr<MapSummary> summary =
        FinishPlanar(provenance, result.drive, *assembly);
    // What was left out may be the reason.
    if (!summary.ok() && !result.warnings.empty()) {
      return absl::Status(summary.status().code(),
                          absl::StrCat(summary.status().message(), "\n",
                                       absl::StrJoin(result.warnings, "\n")));
    }
    TL_ASSIGN_OR_RETURN(result.summary, std::move(summary));
  } else {
    TL_ASSIGN_OR_RETURN(result.summary, assembly->Finish(provenance));
  }
  return result;
}

}  // namespace treeline::map_app
