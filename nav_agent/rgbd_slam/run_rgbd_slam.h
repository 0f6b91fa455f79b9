// A whole recording through RGB-D SLAM.
#ifndef NAV_AGENT_RGBD_SLAM_RUN_RGBD_SLAM_H_
#define NAV_AGENT_RGBD_SLAM_RUN_RGBD_SLAM_H_

#include <functional>
#include <optional>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "common/dataset/dataset.h"
#include "common/dataset/text_formats.h"
#include "nav_agent/rgbd_slam/rgbd_slam.h"

namespace treeline::rgbd_slam {

struct RunRgbdSlamOptions {
  RgbdSlamOptions slam;
  // Replaces the data set's calibration; color_from_depth is not known to the
  // formats themselves.
  std::optional<camera::RgbdCalibration> calibration;
  // Called after each frame with how many are done; may be empty.
  std::function<void(int)> progress;
  // Ends the run with CANCELLED.
  std::stop_token stop;
};

struct RgbdSlamResult {
  // Of the calibration's pose sensor, for each frame of the data set; see
  // RgbdSlam::Trajectory.
  std::vector<std::optional<geometry::Rigid3>> map_from_cameras;
  // dataset::FrameTimes; where time stamps descend, a little after the one
  // before, since a trajectory's times ascend.
  std::vector<dataset::Time_ns> times;
  std::vector<RgbdKeyframe> keyframes;
  RgbdSlamStatistics statistics;
  // Of the tracking of a frame and of the mapping of a keyframe (ms).
  double tracking_p50_ms = 0;
  double tracking_p99_ms = 0;
  double mapping_p50_ms = 0;
  double mapping_p99_ms = 0;
  // Of everything (s).
  double total_s = 0;
};

// Deterministic but for the times. INVALID_ARGUMENT for a data set with frames
// without depth, or with cameras of their own; errors of reading as
// Dataset::Load has them.
absl::StatusOr<RgbdSlamResult> RunRgbdSlam(const dataset::Dataset& dataset,
                                           const RunRgbdSlamOptions& options);

// The frames with a pose, in order of time: a trajectory to write or to score.
std::vector<dataset::TimedPose> TrajectoryOf(const RgbdSlamResult& result);

}  // namespace treeline::rgbd_slam

#endif  // NAV_AGENT_RGBD_SLAM_RUN_RGBD_SLAM_H_
