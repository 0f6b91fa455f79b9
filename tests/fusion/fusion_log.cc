#include "tests/fusion/fusion_log.h"

#include <algorithm>
#include <optional>
#include <variant>

#include "common/base/status_macros.h"
#include "common/image/decode.h"
#include "nav_agent/recording/agent_log.h"

namespace treeline {

geometry::Rigid3 PoseAt(const std::vector<StampedPose>& poses,
                        base::MonotonicTime stamp) {
  const auto after =
      std::upper_bound(poses.begin(), poses.end(), stamp,
                       [](base::MonotonicTime time, const StampedPose& pose) {
                         return time < pose.stamp;
                       });
  if (after == poses.begin()) return after->world_from_base;
  const StampedPose& a = *(after - 1);
  if (after == poses.end()) return a.world_from_base;
  const double part = std::chrono::duration<double>(stamp - a.stamp) /
                      std::chrono::duration<double>(after->stamp - a.stamp);
  const geometry::Rigid3& b = after->world_from_base;
  return {
      .rotation = geometry::Slerp(a.world_from_base.rotation, b.rotation, part),
      .translation =
          (1 - part) * a.world_from_base.translation + part * b.translation};
}

absl::StatusOr<std::vector<StampedPose>> ReadTruePoses(
    const std::string& path) {
  TL_ASSIGN_OR_RETURN(recording::AgentLogReader reader,
                      recording::AgentLogReader::Open(path));
  std::vector<StampedPose> poses;
  while (const std::optional<recording::LogEntry> entry = reader.Next()) {
    if (const auto* pose = std::get_if<recording::LogTruePose>(&*entry)) {
      poses.push_back({pose->stamp, pose->world_from_base});
    }
  }
  if (poses.empty()) {
    return absl::NotFoundError(path + " holds no true poses");
  }
  return poses;
}

absl::Status ForEachView(
    const std::string& path, int every,
    const std::function<absl::Status(const LoggedView&)>& visit) {
  TL_ASSIGN_OR_RETURN(recording::AgentLogReader reader,
                      recording::AgentLogReader::Open(path));
  camera::RgbdCalibration calibration;
  core::RobotModel robot;
  int frames = 0;
  while (const std::optional<recording::LogEntry> entry = reader.Next()) {
    if (const auto* found = std::get_if<camera::RgbdCalibration>(&*entry)) {
      calibration = *found;
    } else if (const auto* model = std::get_if<core::RobotModel>(&*entry)) {
      robot = *model;
    } else if (const auto* frame = std::get_if<recording::LogFrame>(&*entry)) {
      if (frame->depth.empty() || frames++ % every != 0) continue;
      TL_ASSIGN_OR_RETURN(
          image::DepthImage depth,
          image::DecodeDepthPng(frame->depth, frame->depth_unit_m));
      TL_RETURN_IF_ERROR(
          visit({.stamp = frame->stamp,
                 .depth = std::move(depth),
                 .camera = calibration.depth,
                 .base_from_camera = camera::PoseOfSensor(
                     robot.base_from_camera, calibration.pose_sensor,
                     camera::RgbdSensor::kDepth, calibration)}));
    }
  }
  return absl::OkStatus();
}

}  // namespace treeline
