#include "nav_agent/rgbd_slam/run_rgbd_slam.h"

#include <algorithm>
#include <cstddef>
#include <memory>

#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "common/base/sample_statistics.h"
#include "common/base/status_macros.h"
#include "common/dataset/frame_times.h"

namespace treeline::rgbd_slam {
namespace {

// Between two frames of a trajectory.
constexpr dataset::Time_ns kMinGap_ns = 333'333;

std::vector<dataset::Time_ns> AscendingFrameTimes(
    const dataset::Dataset& dataset) {
  std::vector<dataset::Time_ns> times = dataset::FrameTimes(dataset);
  for (size_t i = 1; i < times.size(); ++i) {
    times[i] = std::max(times[i], times[i - 1] + kMinGap_ns);
  }
  return times;
}

}  // namespace

absl::StatusOr<RgbdSlamResult> RunRgbdSlam(const dataset::Dataset& dataset,
                                           const RunRgbdSlamOptions& options) {
  const base::SteadyClock clock;
  const base::MonotonicTime start = clock.Now();
  for (int i = 0; i < dataset.size(); ++i) {
    if (dataset.frame(i).depth_path.empty() || dataset.frame(i).color_camera) {
      return absl::InvalidArgumentError(absl::StrCat(
          dataset.uri(), ": frame ", dataset.frame(i).stem,
          dataset.frame(i).color_camera ? " has a camera of its own"
                                        : " has no depth"));
    }
  }
  TL_ASSIGN_OR_RETURN(
      const std::unique_ptr<RgbdSlam> slam,
      RgbdSlam::Create(options.slam,
                       options.calibration.value_or(dataset.calibration())));
  RgbdSlamResult result;
  result.times = AscendingFrameTimes(dataset);
  for (int i = 0; i < dataset.size(); ++i) {
    if (options.stop.stop_requested()) {
      return absl::CancelledError("stopped while mapping");
    }
    TL_ASSIGN_OR_RETURN(const image::Frame frame, dataset.Load(i));
    const auto place =
        slam->AddFrame(frame, result.times[static_cast<size_t>(i)]);
    if (!place.ok()) {
      return base::Annotate(place.status(),
                            absl::StrCat("frame ", dataset.frame(i).stem));
    }
    if (options.progress) options.progress(i + 1);
  }
  slam->Finish();
  result.map_from_cameras = slam->Trajectory();
  result.keyframes = slam->Keyframes();
  result.statistics = slam->Statistics();
  result.tracking_p50_ms = base::Quantile(result.statistics.tracking_ms, 0.50);
  result.tracking_p99_ms = base::Quantile(result.statistics.tracking_ms, 0.99);
  result.mapping_p50_ms = base::Quantile(result.statistics.mapping_ms, 0.50);
  result.mapping_p99_ms = base::Quantile(result.statistics.mapping_ms, 0.99);
  result.total_s = base::MillisecondsBetween(start, clock.Now()) / 1000;
  return result;
}

std::vector<dataset::TimedPose> TrajectoryOf(const RgbdSlamResult& result) {
  std::vector<dataset::TimedPose> poses;
  for (size_t i = 0; i < result.map_from_cameras.size(); ++i) {
    if (!result.map_from_cameras[i]) continue;
    poses.push_back({result.times[i], *result.map_from_cameras[i]});
  }
  return poses;
}

}  // namespace treeline::rgbd_slam
