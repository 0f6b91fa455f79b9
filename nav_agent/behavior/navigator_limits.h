// How long, how far and how often a robot tries before it says that it cannot.
#ifndef NAV_AGENT_BEHAVIOR_NAVIGATOR_LIMITS_H_
#define NAV_AGENT_BEHAVIOR_NAVIGATOR_LIMITS_H_

#include "absl/status/status.h"

namespace treeline::behavior {

// Times in (0, 600] s, ways in (0, 10] m, speeds in (0, 2].
struct NavigatorLimits {
  // ---- waypoints ----
  // A pose that is driven through counts as reached from here.
  double through_m = 0.3;
  // A better path is taken if it is shorter by this share of what is to go.
  double better_share = 0.1;

  // ---- the progress watchdog ----
  // So much of the way, or of a turn, within so long.
  double progress_m = 0.15;
  double progress_rad = 0.5;
  double progress_s = 10;
  // How long something that moves is waited for before it counts as standing.
  double wait_for_moving_s = 8;
  // A plan takes this long at most (background).
  double plan_s = 10;
  // Ways around what stands in the way that are tried without getting on by
  // refill_m; then recoveries begin.
  int max_replans = 6;

  // ---- recoveries ----
  // So many a goal, before it fails; all of them again after getting on by so
  // much further than ever.
  int max_recoveries = 10;
  double refill_m = 1.0;
  double back_up_m = 0.3;
  double back_up_mps = 0.12;
  double back_up_s = 6;
  double look_radps = 0.6;
  double look_s = 16;
  // The first wait, and the longest: it doubles every third recovery.
  double first_wait_s = 3;
  double longest_wait_s = 24;

  // ---- what stands in the way is remembered ----
  // Beyond what was seen of it (m): as much as the local costmap widens what it
  // sees (LocalCostmapOptions::widening_m), or ways are planned that the band
  // refuses.
  double blockage_margin_m = 0.15;
  // So long (s) the first time, twice as long each time that it is met again.
  double blockage_s = 30;
  double longest_blockage_s = 240;

  // ---- safe stops ----
  // All must be well for so long before the robot goes on.
  double settle_s = 0.3;
  // Tilt beyond the robot's max_slope_rad by this much, for so long.
  double tilt_margin_rad = 0.06;
  double tilt_s = 0.15;
  // A step this late means that the base had no command (s).
  double late_s = 0.3;

  // INVALID_ARGUMENT names the field.
  absl::Status Validate() const;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_NAVIGATOR_LIMITS_H_
