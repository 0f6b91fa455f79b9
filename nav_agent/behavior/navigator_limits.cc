#include "nav_agent/behavior/navigator_limits.h"

#include "common/base/check_range.h"
#include "common/base/status_macros.h"

namespace treeline::behavior {
namespace {

absl::Status CheckTime(const char* name, double value_s) {
  return base::CheckRange(name, value_s, 1e-3, 600);
}
absl::Status CheckWay(const char* name, double value_m) {
  return base::CheckRange(name, value_m, 1e-3, 10);
}

}  // namespace

absl::Status NavigatorLimits::Validate() const {
  TL_RETURN_IF_ERROR(CheckWay("through_m", waypoint_tolerance_m));
  TL_RETURN_IF_ERROR(base::CheckRange("better_share", better_share, 0, 1));
  TL_RETURN_IF_ERROR(CheckWay("progress_m", progress_m));
  TL_RETURN_IF_ERROR(base::CheckRange("progress_rad", progress_rad, 0.01, 3.1));
  TL_RETURN_IF_ERROR(CheckTime("progress_s", progress_s));
  TL_RETURN_IF_ERROR(CheckTime("wait_for_moving_s", wait_for_moving_s));
  TL_RETURN_IF_ERROR(CheckTime("plan_s", plan_s));
  TL_RETURN_IF_ERROR(base::CheckRange("max_replans", max_replans, 0, 1000));
  TL_RETURN_IF_ERROR(
      base::CheckRange("max_recoveries", max_recoveries, 0, 1000));
  TL_RETURN_IF_ERROR(CheckWay("refill_m", recovery_reset_m));
  TL_RETURN_IF_ERROR(CheckWay("back_up_m", back_up_m));
  TL_RETURN_IF_ERROR(base::CheckRange("back_up_mps", back_up_mps, 0.01, 2));
  TL_RETURN_IF_ERROR(CheckTime("back_up_s", back_up_s));
  TL_RETURN_IF_ERROR(base::CheckRange("look_radps", look_radps, 0.01, 3));
  TL_RETURN_IF_ERROR(CheckTime("look_s", look_s));
  TL_RETURN_IF_ERROR(CheckTime("first_wait_s", first_wait_s));
  TL_RETURN_IF_ERROR(CheckTime("longest_wait_s", longest_wait_s));
  TL_RETURN_IF_ERROR(
      base::CheckRange("blockage_margin_m", blockage_margin_m, 0, 1));
  TL_RETURN_IF_ERROR(CheckTime("blockage_s", blockage_s));
  TL_RETURN_IF_ERROR(CheckTime("longest_blockage_s", longest_blockage_s));
  TL_RETURN_IF_ERROR(CheckTime("settle_s", settle_s));
  TL_RETURN_IF_ERROR(
      base::CheckRange("tilt_margin_rad", tilt_margin_rad, 0, 0.5));
  TL_RETURN_IF_ERROR(CheckTime("tilt_s", tilt_s));
  return CheckTime("late_s", late_s);
}

}  // namespace treeline::behavior
