#include "nav_agent/app/map/trajectory_files.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/dataset/dataset.h"
#include "common/dataset/frame_times.h"
#include "nav_agent/map_bundle/map_bundle.h"
#include "nav_agent/recording/laser_log.h"

namespace treeline::map_app {

namespace {

absl::StatusOr<std::vector<dataset::TimedPose>> PosesOfRecording(
    const std::string& uri, const std::string& pose_file) {
  dataset::DatasetOptions options;
  options.uri = uri;
  options.pose_file = pose_file;
  TL_ASSIGN_OR_RETURN(const dataset::Dataset dataset,
                      dataset::Dataset::Open(options));
  const std::vector<dataset::Time_ns> times = dataset::FrameTimes(dataset);
  std::vector<dataset::TimedPose> poses;
  for (int i = 0; i < dataset.size(); ++i) {
    const auto& pose = dataset.frame(i).world_from_camera;
    if (pose.has_value()) {
      poses.push_back({times[static_cast<size_t>(i)], *pose});
    }
  }
  if (poses.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(uri, ": there are no poses in it"));
  }
  return poses;
}

}  // namespace

absl::StatusOr<std::vector<dataset::TimedPose>> ReadTrajectory(
    const std::string& path, const std::string& pose_file) {
  for (const char* format : {"7scenes:", "tum:"}) {
    if (absl::StartsWith(path, format)) {
      return PosesOfRecording(path, pose_file);
    }
  }
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    return ReadTrajectory(
        absl::StrCat(path, "/", map_bundle::kBundleTrajectory));
  }
  TL_ASSIGN_OR_RETURN(const std::string bytes, base::ReadFile(path));
  absl::StatusOr<std::vector<dataset::TimedPose>> poses =
      dataset::ParseTimedPoses(bytes, path);
  if (!poses.ok()) {
    const absl::StatusOr<recording::LaserLog> log =
        recording::ParseLaserLog(bytes, path);
    // What a person meant is more likely a trajectory.
    if (!log.ok()) return poses.status();
    poses.emplace();
    for (const recording::RecordedScan& scan : log->scans) {
      const geometry::Rigid2& pose = scan.odom_from_base;
      poses->push_back(
          {scan.stamp.time_since_epoch().count(),
           {geometry::Rotation3::FromAxisAngle({0, 0, pose.yaw_rad}),
            {pose.translation.x, pose.translation.y, 0}}});
    }
  }
  if (poses->empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": there are no poses in it"));
  }
  return poses;
}

}  // namespace treeline::map_app
