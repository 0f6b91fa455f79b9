#include "nav_agent/drivers/segway/segway_options.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline::segway {
namespace {

absl::Status CheckWithin(absl::string_view name, double value, double min,
                         double max) {
  if (value >= min && value <= max) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("the base's ", name, " of ",
                                                 value, " is outside [", min,
                                                 ", ", max, "]"));
}

}  // namespace

absl::Status SegwayOptions::Validate() const {
  TL_RETURN_IF_ERROR(wire.Validate());
  TL_RETURN_IF_ERROR(limits.Validate());
  if (receive_channel && *receive_channel != kSegwayChannelA &&
      *receive_channel != kSegwayChannelB) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the base's receive channel is 0x", absl::Hex(*receive_channel),
        "; it has to be 0xAA or 0xBB"));
  }
  if (mode != SegwayMode::kTractor && mode != SegwayMode::kBalanced) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the base cannot be driven in the mode '", SegwayModeName(mode), "'"));
  }
  TL_RETURN_IF_ERROR(CheckWithin("wheel_track_m", wheel_track_m, 0.1, 2));
  TL_RETURN_IF_ERROR(CheckWithin("gain schedule", gain_schedule, 0, 2));
  TL_RETURN_IF_ERROR(
      CheckWithin("max_velocity_scale", max_velocity_scale, 1, 16));
  TL_RETURN_IF_ERROR(
      CheckWithin("max_acceleration_scale", max_acceleration_scale, 1, 16));
  TL_RETURN_IF_ERROR(CheckWithin("max_turn_scale", max_turn_scale, 1, 16));
  TL_RETURN_IF_ERROR(
      CheckWithin("current_limit_scale", current_limit_scale, 1, 256));
  TL_RETURN_IF_ERROR(
      CheckWithin("command_interval_s", command_interval_s, 0.01, 0.1));
  TL_RETURN_IF_ERROR(CheckWithin("link_timeout_s", link_timeout_s, 0.05, 0.4));
  return CheckWithin("reopen_after_s", reopen_after_s, 0.5, 60);
}

}  // namespace treeline::segway
