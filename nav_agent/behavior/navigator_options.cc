#include "nav_agent/behavior/navigator_options.h"

#include "common/base/check_range.h"
#include "common/base/status_macros.h"

namespace treeline::behavior {

absl::Status NavigatorOptions::Validate() const {
  TL_RETURN_IF_ERROR(map.Validate());
  TL_RETURN_IF_ERROR(planner.Validate());
  TL_RETURN_IF_ERROR(control.Validate());
  TL_RETURN_IF_ERROR(tracker.Validate());
  TL_RETURN_IF_ERROR(lost.Validate());
  TL_RETURN_IF_ERROR(limits.Validate());
  TL_RETURN_IF_ERROR(base::CheckRange("plan_steps", plan_steps, 0, 400));
  if (plan_steps > 0 && plans_in_background) {
    return absl::InvalidArgumentError(
        "plan_steps and plans_in_background exclude each other");
  }
  TL_RETURN_IF_ERROR(base::CheckRange("control_hz", control_hz, 10, 200));
  TL_RETURN_IF_ERROR(
      base::CheckRange("laser_timeout_s", laser_timeout_s, 0.05, 5));
  TL_RETURN_IF_ERROR(
      base::CheckRange("odometry_timeout_s", odometry_timeout_s, 0.05, 5));
  TL_RETURN_IF_ERROR(
      base::CheckRange("manual_lease_s", manual_lease_s, 1e-3, 1000));
  return base::CheckRange("depth_hz", depth_hz, 0, 30);
}

}  // namespace treeline::behavior
