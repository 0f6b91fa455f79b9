#include "nav_agent/rgbd_slam/run_rgbd_slam.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/base/clock.h"
#include "common/base/sample_statistics.h"
#include "common/base/status_macros.h"

namespace treeline::rgbd_slam {
namespace {

constexpr dataset::Time_ns kFramePeriod_ns = 33'333'333;

// The number at a stem's end: "seq-01/frame-000123" -> 123.
std::optional<int64_t> NumberOf(absl::string_view stem) {
  size_t begin = stem.size();
  while (begin > 0 &&
         absl::ascii_isdigit(static_cast<unsigned char>(stem[begin - 1])))
    --begin;
  int64_t number = 0;
  if (!absl::SimpleAtoi(stem.substr(begin), &number) || number > 100'000'000) {
    return std::nullopt;
  }
  return number;
}

dataset::Time_ns TimeOf(const std::string& stem, int index) {
  if (const absl::StatusOr<dataset::Time_ns> time = dataset::ParseTime_ns(stem);
      time.ok()) {
    return *time;
  }
  return kFramePeriod_ns * NumberOf(stem).value_or(index);
}

}  // namespace

std::vector<dataset::Time_ns> FrameTimes(const dataset::Dataset& dataset) {
  std::vector<dataset::Time_ns> times;
  for (int i = 0; i < dataset.size(); ++i) {
    const dataset::Time_ns time = TimeOf(dataset.frame(i).stem, i);
    times.push_back(times.empty()
                        ? time
                        : std::max(time, times.back() + kFramePeriod_ns / 100));
  }
  return times;
}

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
  result.times = FrameTimes(dataset);
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
