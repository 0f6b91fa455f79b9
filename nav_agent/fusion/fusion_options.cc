#include "nav_agent/fusion/fusion_options.h"

#include "common/base/check_range.h"
#include "common/base/status_macros.h"

namespace treeline::fusion {
namespace {

constexpr double kAlmost0 = 1e-6;
constexpr double kAlmost1 = 1 - kAlmost0;

}  // namespace

absl::Status FusionOptions::Validate() const {
  TL_RETURN_IF_ERROR(base::CheckRange("resolution_m", resolution_m, 0.01, 0.5));
  TL_RETURN_IF_ERROR(
      base::CheckRange("hit_probability", hit_probability, 0.5, kAlmost1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("miss_probability", miss_probability, kAlmost0, 0.5));
  TL_RETURN_IF_ERROR(base::CheckRange("lowest_probability", lowest_probability,
                                      kAlmost0, 0.5));
  TL_RETURN_IF_ERROR(base::CheckRange("highest_probability",
                                      highest_probability, 0.5, kAlmost1));
  TL_RETURN_IF_ERROR(base::CheckRange("occupied_threshold", occupied_threshold,
                                      kAlmost0, kAlmost1));
  TL_RETURN_IF_ERROR(base::CheckRange("max_depth_m", max_depth_m, 0.01, 20));
  TL_RETURN_IF_ERROR(
      base::CheckRange("min_depth_m", min_depth_m, 0, max_depth_m - 0.001));
  TL_RETURN_IF_ERROR(
      base::CheckRange("max_point_range_m", max_point_range_m, 0.01, 60));
  TL_RETURN_IF_ERROR(base::CheckRange("pixel_step", pixel_step, 0, 16));
  TL_RETURN_IF_ERROR(
      base::CheckRange("outlier_neighbors", outlier_neighbors, 0, 8));
  TL_RETURN_IF_ERROR(base::CheckRange("outlier_deviations", outlier_deviations,
                                      kAlmost0, 100));
  TL_RETURN_IF_ERROR(
      base::CheckRange("clearing_range_m", clearing_range_m, 0.01, 20));
  TL_RETURN_IF_ERROR(
      base::CheckRange("min_clearing_views", min_clearing_views, 1, 1000));
  TL_RETURN_IF_ERROR(
      base::CheckRange("min_clearing_share", min_clearing_share, 0, 100));
  TL_RETURN_IF_ERROR(base::CheckRange("min_clearing_share_beside",
                                      min_clearing_share_beside, 0, 100));
  TL_RETURN_IF_ERROR(base::CheckRange("max_glimpses", max_glimpses, 0, 1000));
  return base::CheckRange("max_bytes", static_cast<double>(max_bytes),
                          static_cast<double>(1 << 20), 1e15);
}

}  // namespace treeline::fusion
