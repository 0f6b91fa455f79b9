#include "nav_agent/mapping/run_laser_slam.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>

#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "common/base/sample_statistics.h"
#include "common/base/status_macros.h"

namespace treeline::mapping {
namespace {

geometry::Rigid3 ToRigid3(const geometry::Rigid2& a) {
  return {.rotation = geometry::Rotation3::FromAxisAngle({0, 0, a.yaw_rad}),
          .translation = {a.translation.x, a.translation.y, 0}};
}

}  // namespace

absl::StatusOr<LaserSlamResult> RunLaserSlam(
    const recording::LaserLog& log, const RunLaserSlamOptions& options) {
  const base::SteadyClock clock;
  const base::MonotonicTime start = clock.Now();
  TL_RETURN_IF_ERROR(options.grid.Validate());
  TL_ASSIGN_OR_RETURN(
      const std::unique_ptr<LaserSlam> slam,
      LaserSlam::Create(log.laser, ToRigid3(log.base_from_laser),
                        options.slam));
  for (size_t i = 0; i < log.scans.size(); ++i) {
    if (options.stop.stop_requested()) {
      return absl::CancelledError("stopped while mapping");
    }
    const recording::RecordedScan& scan = log.scans[i];
    const auto place = slam->AddScan({.stamp = scan.stamp,
                                      .odom_from_base = scan.odom_from_base,
                                      .ranges_m = scan.ranges_m,
                                      .level_from_base = {}});
    if (!place.ok()) {
      return base::Annotate(
          place.status(),
          absl::StrCat("scan ", i, " at ",
                       recording::FormatRecordingTime(scan.stamp)));
    }
    if (options.progress) options.progress(i + 1);
  }
  slam->Finish();
  LaserSlamResult result = {.trajectory = slam->Trajectory(),
                            .grid = {},
                            .statistics = slam->Statistics()};
  std::vector<GridScan> scans;
  scans.reserve(log.scans.size());
  for (size_t i = 0; i < log.scans.size(); ++i) {
    scans.push_back({.map_from_laser = result.trajectory[i].map_from_base *
                                       log.base_from_laser,
                     .ranges_m = log.scans[i].ranges_m});
  }
  TL_ASSIGN_OR_RETURN(result.grid, MapGrid(scans, log.laser, options.grid));
  const std::vector<double>& times_ms = result.statistics.front_end_ms;
  result.p50_ms = base::Quantile(times_ms, 0.50);
  result.p99_ms = base::Quantile(times_ms, 0.99);
  result.max_ms = base::Quantile(times_ms, 1.0);
  result.total_s = base::MillisecondsBetween(start, clock.Now()) / 1000;
  return result;
}

}  // namespace treeline::mapping
