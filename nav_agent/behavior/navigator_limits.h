// How long, how far and how often a robot tries before it says that it cannot.
#ifndef NAV_AGENT_BEHAVIOR_NAVIGATOR_LIMITS_H_
#define NAV_AGENT_BEHAVIOR_NAVIGATOR_LIMITS_H_

#include "absl/status/status.h"
#include "nav_agent/behavior/parameters.h"

namespace treeline::behavior {

// Times in (0, 600] s, ways in (0, 10] m, speeds in (0, 2].
struct NavigatorLimits {
  // ---- waypoints ----
  // A pose that is driven through counts as reached from here.
  double waypoint_tolerance_m = kPassPose_m;
  // A better path is taken if it is shorter by this share of what is to go.
  double better_share = kBetterPathShare;

  // ---- the progress watchdog ----
  // So much of the way, or of a turn, within so long.
  double progress_m = kMinProgress_m;
  double progress_rad = kMinProgress_rad;
  double progress_s = kProgressTime_s;
  // How long something that moves is waited for before it counts as standing.
  double wait_for_moving_s = kWaitForMoving_s;
  // A plan takes this long at most (background).
  double plan_s = kMaxPlan_s;
  // Ways around what stands in the way that are tried without getting on by
  // recovery_reset_m; then recoveries begin.
  int max_replans = kMaxReplans;

  // ---- recoveries ----
  // So many a goal, before it fails; all of them again after getting on by so
  // much further than ever.
  int max_recoveries = kMaxRecoveries;
  double recovery_reset_m = kRefillProgress_m;
  double back_up_m = kBackUp_m;
  double back_up_mps = kBackUp_mps;
  double back_up_s = kMaxBackUp_s;
  double look_radps = kLookAround_radps;
  double look_s = kMaxLookAround_s;
  // The first wait, and the longest: it doubles every third recovery.
  double first_wait_s = kFirstWait_s;
  double longest_wait_s = kLongestWait_s;

  // ---- what stands in the way is remembered ----
  // Beyond what was seen of it (m): as much as the local costmap widens what it
  // sees (LocalCostmapOptions::widening_m), or ways are planned that the band
  // refuses.
  double blockage_margin_m = kBlockageMargin_m;
  // So long (s) the first time, twice as long each time that it is met again.
  double blockage_s = kBlockageMemory_s;
  double longest_blockage_s = kMaxBlockageMemory_s;

  // ---- safe stops ----
  // All must be well for so long before the robot goes on.
  double settle_s = kAllWell_s;
  // Tilt beyond the robot's max_slope_rad by this much, for so long.
  double tilt_margin_rad = kTiltMargin_rad;
  double tilt_s = kTilt_s;
  // A step this late means that the base had no command (s).
  double late_s = kLateStep_s;

  // INVALID_ARGUMENT names the field.
  absl::Status Validate() const;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_NAVIGATOR_LIMITS_H_
