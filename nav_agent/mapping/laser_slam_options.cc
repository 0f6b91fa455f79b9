#include "nav_agent/mapping/laser_slam_options.h"

#include "common/base/status_macros.h"

namespace treeline::mapping {

absl::Status LaserSlamOptions::Validate() const {
  TL_RETURN_IF_ERROR(points.Validate());
  TL_RETURN_IF_ERROR(matcher.Validate());
  TL_RETURN_IF_ERROR(loops.Validate());
  const bool lengths =
      keyscan_m > 0 && keyscan_rad > 0 && still_m > 0 && still_rad > 0 &&
      between_m > 0 && between_rad > 0 && max_search_m > 0 &&
      max_search_rad > 0 && search_sigmas > 0 && lost_search_rad > 0 &&
      poor_response > 0 && better_response >= 0 && max_gap_m > 0 &&
      max_tilt > 0 && ground_margin_m >= 0 && ground_reach_m > 0;
  const bool noise =
      odometry.m > 0 && odometry.rad > 0 && odometry.m_per_m >= 0 &&
      odometry.m_per_rad >= 0 && odometry.rad_per_rad >= 0 &&
      odometry.rad_per_m >= 0 && odometry.min_search_m >= 0 &&
      odometry.min_search_rad >= 0 && odometry.initial_scale >= 1;
  if (!lengths || !noise || window < 1 || min_points < 3 || min_alike < 1 ||
      polish_rounds < 0 || !carries.IsValid() || !segments.IsValid() ||
      !(graph.kernel_sigmas > 0) || graph.max_iterations < 1 ||
      !(max_search_m <= 20)) {
    return absl::InvalidArgumentError(
        "laser SLAM: lengths, angles, counts and what odometry may be wrong "
        "by must be above 0, max_search_m at most 20");
  }
  return absl::OkStatus();
}

}  // namespace treeline::mapping
