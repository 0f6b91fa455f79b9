#include "common/base/check_range.h"
#include "common/base/status_macros.h"
#include "nav_agent/behavior/navigator.h"

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
  TL_RETURN_IF_ERROR(CheckWay("through_m", through_m));
  TL_RETURN_IF_ERROR(base::CheckRange("better_share", better_share, 0, 1));
  TL_RETURN_IF_ERROR(CheckWay("progress_m", progress_m));
  TL_RETURN_IF_ERROR(base::CheckRange("progress_rad", progress_rad, 0.01, 3.1));
  TL_RETURN_IF_ERROR(CheckTime("progress_s", progress_s));
  TL_RETURN_IF_ERROR(CheckTime("wait_for_moving_s", wait_for_moving_s));
  TL_RETURN_IF_ERROR(CheckTime("plan_s", plan_s));
  TL_RETURN_IF_ERROR(base::CheckRange("max_replans", max_replans, 0, 1000));
  TL_RETURN_IF_ERROR(
      base::CheckRange("max_recoveries", max_recoveries, 0, 1000));
  TL_RETURN_IF_ERROR(CheckWay("refill_m", refill_m));
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
  return base::CheckRange("depth_hz", depth_hz, 0, 30);
}

const char* NavigatorModeName(NavigatorMode mode) {
  switch (mode) {
    case NavigatorMode::kIdle:
      return "idle";
    case NavigatorMode::kPlanning:
      return "planning";
    case NavigatorMode::kDriving:
      return "driving";
    case NavigatorMode::kRecovering:
      return "recovering";
    case NavigatorMode::kLost:
      return "lost";
    case NavigatorMode::kRelocalizing:
      return "relocalizing";
    case NavigatorMode::kPaused:
      return "paused";
    case NavigatorMode::kSafeStop:
      return "safe_stop";
    case NavigatorMode::kNeedHelp:
      return "need_help";
  }
  return "unknown";
}

}  // namespace treeline::behavior
