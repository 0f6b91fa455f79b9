#include "nav_agent/traversability/traversability_options.h"

#include <cmath>
#include <numbers>

#include "common/base/check_range.h"
#include "common/base/status_macros.h"

namespace treeline::traversability {

absl::Status TraversabilityOptions::Validate() const {
  TL_RETURN_IF_ERROR(base::CheckRange("max_slope_rad", max_slope_rad, 0.01,
                                      std::numbers::pi / 4));
  TL_RETURN_IF_ERROR(base::CheckRange("max_step_m", max_step_m, 0, 0.3));
  TL_RETURN_IF_ERROR(
      base::CheckRange("robot_height_m", robot_height_m, 0.1, 5));
  TL_RETURN_IF_ERROR(
      base::CheckRange("min_ground_width_m", min_ground_width_m, 0, 2));
  TL_RETURN_IF_ERROR(
      base::CheckRange("min_platform_area_m2", min_platform_area_m2, 0, 1e6));
  TL_RETURN_IF_ERROR(base::CheckRange("max_riser_m", max_riser_m, 0, 1));
  return base::CheckRange("level_overlap_m", level_overlap_m, 0, 0.5);
}

double LayerGradient_rad(double layer_distance_m, double resolution_m,
                         double run_voxels) {
  // atan2 gives pi / 2 for v = 0, where the quotient is not a number's.
  return std::atan2(layer_distance_m, resolution_m * run_voxels);
}

}  // namespace treeline::traversability
