// The tuned constants of the supervisor, and the table of all of the folder.
#ifndef NAV_AGENT_BEHAVIOR_PARAMETERS_H_
#define NAV_AGENT_BEHAVIOR_PARAMETERS_H_

#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "common/base/parameter.h"
#include "nav_agent/behavior/relocalization_parameters.h"
#include "nav_agent/control/obstacle_parameters.h"
#include "nav_agent/planning/planner_parameters.h"

namespace treeline::behavior {

// ---- The supervisor ----

inline constexpr base::Parameter<int64_t> kSeeThroughEvery{
    "see_through_every", 4, "", base::ParameterOrigin::kTuned,
    "scans between looks through blockages"};
inline constexpr base::Parameter<int> kSeeThroughBeamStep{
    "see_through_beam_step", 2, "", base::ParameterOrigin::kTuned,
    "beams between those that are looked at"};
inline constexpr base::Parameter<double> kMaxAskAhead_m{
    "max_ask_ahead", 1.0, "m", base::ParameterOrigin::kTuned,
    "room that a lost robot asks for"};
inline constexpr base::Parameter<size_t> kShownParticles{
    "shown_particles", 500, "", base::ParameterOrigin::kPhysics,
    "bounds a snapshot"};
inline constexpr base::Parameter<size_t> kMaxWaitingEvents{
    "max_waiting_events", 10000, "", base::ParameterOrigin::kPhysics,
    "bounds the memory of events that nobody takes"};
inline constexpr base::Parameter<double> kManualLease_s{
    "manual_lease", 0.3, "s", base::ParameterOrigin::kPhysics,
    "of driving by hand without a word; bases keep a velocity as long"};

// ---- What sensors say ----

inline constexpr base::Parameter<double> kMinRangeShare{
    "min_range_share", 0.2, "", base::ParameterOrigin::kTuned,
    "a scan of fewer ranges tells nothing"};
inline constexpr base::Parameter<double> kFrozen_s{
    "frozen", 0.5, "s", base::ParameterOrigin::kTuned,
    "the same readings for so long while the base moves"};
inline constexpr base::Parameter<double> kFrozenRetry_s{
    "frozen_retry", 2, "s", base::ParameterOrigin::kTuned,
    "of standing, then they are tried again"};
inline constexpr base::Parameter<int> kFrozenRetries{
    "frozen_retries", 3, "", base::ParameterOrigin::kTuned, "so often"};

// ---- Goals ----

inline constexpr base::Parameter<double> kPassPose_m{
    "pass_pose", 0.3, "m", base::ParameterOrigin::kTuned,
    "a pose that is driven through counts as reached"};
inline constexpr base::Parameter<double> kBetterPathShare{
    "better_path_share", 0.1, "", base::ParameterOrigin::kTuned,
    "of what is to go: worth a new path"};
inline constexpr base::Parameter<double> kMinProgress_rad{
    "min_progress", 0.5, "rad", base::ParameterOrigin::kTuned, "or of a turn"};
inline constexpr base::Parameter<double> kProgressTime_s{
    "progress_time", 10, "s", base::ParameterOrigin::kTuned,
    "else the robot does not get on; so long it also waits for a plan, and "
    "beside a goal that is taken"};
inline constexpr base::Parameter<int> kMaxReplans{
    "max_replans", 6, "", base::ParameterOrigin::kTuned,
    "without getting on; then recoveries begin"};
inline constexpr base::Parameter<double> kArrivalSlack_m{
    "arrival_slack", 0.02, "m", base::ParameterOrigin::kGeometry,
    "beyond the controller's tolerance, which is of a step ago"};
inline constexpr base::Parameter<double> kArrivalSlack_rad{
    "arrival_slack", 0.03, "rad", base::ParameterOrigin::kGeometry,
    "the same, of the heading"};
inline constexpr base::Parameter<double> kArrivalDispute_s{
    "arrival_dispute", 2, "s", base::ParameterOrigin::kTuned,
    "a controller that wrongly says that it has arrived gets so long"};
inline constexpr base::Parameter<double> kBetterPathStart_m{
    "better_path_start", 0.8, "m", base::ParameterOrigin::kTuned,
    "a better path begins this near to the robot"};
inline constexpr base::Parameter<double> kMaxStepMove_m{
    "max_step_move", 0.3, "m", base::ParameterOrigin::kPhysics,
    "further means that the estimate jumped"};
inline constexpr base::Parameter<double> kStraightYawRate_radps{
    "straight_yaw_rate", 0.2, "rad/s", base::ParameterOrigin::kTuned,
    "slower is about straight ahead"};

// ---- Recoveries on the way to a goal ----

inline constexpr base::Parameter<int> kMaxRecoveries{
    "max_recoveries", 10, "", base::ParameterOrigin::kTuned,
    "of a goal, before it fails"};
inline constexpr base::Parameter<double> kRefillProgress_m{
    "refill_progress", 1.0, "m", base::ParameterOrigin::kTuned,
    "of getting on gives all of them back"};
inline constexpr base::Parameter<double> kBackUp_m{
    "back_up", 0.3, "m", base::ParameterOrigin::kTuned, "of one recovery"};
inline constexpr base::Parameter<int> kBoldAfter{
    "bold_after", 4, "", base::ParameterOrigin::kTuned,
    "recoveries; then it backs up among people, too"};

// ---- What stands in the way is remembered ----

inline constexpr base::Parameter<double> kBlockageMemory_s{
    "blockage_memory", 30, "s", base::ParameterOrigin::kTuned,
    "the first time; twice as long each time it is met again"};
inline constexpr base::Parameter<double> kMaxBlockageRadius_m{
    "max_blockage_radius", 0.6, "m", base::ParameterOrigin::kTuned,
    "what is larger is several; also from where the band broke to the first "
    "seen cell"};
inline constexpr base::Parameter<double> kBlockageMetAgain_s{
    "blockage_met_again", 2, "s", base::ParameterOrigin::kTuned,
    "the same, seen twice at once, was not met again"};
inline constexpr base::Parameter<int> kSeeThroughBeams{
    "see_through_beams", 4, "", base::ParameterOrigin::kTuned,
    "that pass its middle"};
inline constexpr base::Parameter<int> kSeeThroughScans{
    "see_through_scans", 5, "", base::ParameterOrigin::kTuned, "in a row"};
inline constexpr base::Parameter<double> kMaxSeeThrough_m{
    "max_see_through", 4, "m", base::ParameterOrigin::kTuned,
    "few beams meet what is further away"};
inline constexpr base::Parameter<double> kBlockageMiddle{
    "blockage_middle", 0.7, "", base::ParameterOrigin::kTuned,
    "part of its radius"};
inline constexpr base::Parameter<double> kObstacleReach_m{
    "obstacle_reach", 1.6, "m", base::ParameterOrigin::kTuned,
    "and to the last"};
inline constexpr base::Parameter<double> kObstacleGap_m{
    "obstacle_gap", 0.55, "m", base::ParameterOrigin::kGeometry,
    "parts with less between them belong together: the robot is wider"};

// ---- Safe stops ----

inline constexpr base::Parameter<double> kTiltNoise_rad{
    "tilt_noise", 0.06, "rad", base::ParameterOrigin::kMeasured,
    "of the inertial sensor while the robot brakes: beyond its max_slope_rad, "
    "or on level ground"};
inline constexpr base::Parameter<double> kLateStep_s{
    "late_step", 0.3, "s", base::ParameterOrigin::kPhysics,
    "after that the base stops by itself; twelve scans of a UTM-30LX"};
inline constexpr base::Parameter<double> kMissedDeadline{
    "missed_deadline", 1.5, "", base::ParameterOrigin::kTuned,
    "of a period: the step came late"};
inline constexpr base::Parameter<double> kDeadlineNote_s{
    "deadline_note", 10, "s", base::ParameterOrigin::kTuned,
    "one event about late steps in so long"};

// ---- what follows from others ----

// Steps in a second.
inline constexpr double kControlRate_hz = 1 / control::kCycle_s;
// Clocks differ by less than two cycles.
inline constexpr double kMaxFutureStamp_s = 2 * control::kCycle_s;
// A base is lost that is silent for twice as long as it may be late.
inline constexpr double kOdometryTimeout_s = 2 * control::kLag_s;
// The last part of the way back is not waited for.
inline constexpr double kBackUpTolerance_m = kArrivalSlack_m;

// Without scans the robot goes on for as long as the base without commands.
inline constexpr double kLaserTimeout_s = kLateStep_s;
// An estimate may be late by what scans and wheels may be.
inline constexpr double kMaxEstimateAge_s =
    kLaserTimeout_s + kOdometryTimeout_s;
// Lasers of a robot whose wheels have both moved by more than a range's noise
// do not say the same (sum of both, m).
inline constexpr double kScanMotion_m = 2 * control::kLaserNoise_m;
// A first path is found in a tenth of what a better one takes.
inline constexpr int kPlanIterations = planning::kMaxIterations;
inline constexpr int kFirstPlanIterations = kPlanIterations / 10;
// A beam looks through a blockage if it is neither of the ground nor above what
// stood there.
inline constexpr double kMinSeeThroughHeight_m = control::kGroundTolerance_m;
inline constexpr double kMaxSeeThroughHeight_m = control::kLookHeight_m;
// Of a plan in the background; and beside a goal where something stands.
inline constexpr double kMaxPlan_s = kProgressTime_s;
inline constexpr double kGoalWait_s = kProgressTime_s;
inline constexpr double kMinProgress_m = control::kGotOn_m;
// A robot's length ahead counts as blocked when it re-routes; that begins at
// its front.
inline constexpr double kRerouteAhead_m = planning::kStuckReach_m;
inline constexpr double kRerouteRadius_m = kRerouteAhead_m / 2;
// Slow, as an escape: it has no eyes behind. And as gentle as at a goal.
inline constexpr double kBackUp_mps = control::kSlowSpeed_mps;
inline constexpr double kLookAround_radps = control::kGoalTurn_radps;
// It may take three times as long as that does, waiting for a quiet moment; and
// one and a half times as long as a full turn (s).
inline constexpr double kMaxBackUp_s = 3 * kBackUp_m / kBackUp_mps;
inline constexpr double kMaxLookAround_s =
    1.5 * 2 * std::numbers::pi / kLookAround_radps;
// Less is not worth it: it may be the map's grid (m).
inline constexpr double kMinBackUp_m = control::kTwoCells_m;
// A first wait lasts until what was in the way may have gone, and any until
// what moves counts as standing (s).
inline constexpr double kFirstWait_s = control::kRecently_s;
inline constexpr double kMinWait_s = control::kStandingAfter_s;
// Somebody moves right now, or it leans right now (s).
inline constexpr double kSomebodyMoves_s = control::kSeenNow_s;
inline constexpr double kTilt_s = control::kSeenNow_s;
// Faster than that is more than a creep.
inline constexpr double kStraightSpeed_mps = control::kCreep_mps;
// Bounds a goal's recoveries.
inline constexpr int kMaxGivenBack = 3 * kMaxRecoveries;
// Nobody has moved for so long: nobody is about, and what moved stands; or not
// at this moment.
inline constexpr double kNobodyMovedFor_s = control::kQuiet_s;
inline constexpr double kQuietMoment_s = control::kQuietMin_s;
// As much as the local costmap widens what it sees.
inline constexpr double kBlockageMargin_m = control::kBodyWidening_m;
// Discs this near are of one place, which is the smallest that beams are to
// pass; discs side by side touch; only the front is seen, and what is behind
// that by one is of it.
inline constexpr double kSameBlockage_m = control::kTwoCells_m;
inline constexpr double kMinBlockageRadius_m = kSameBlockage_m;
inline constexpr double kDiscSpacing_m = 2 * kMinBlockageRadius_m;
inline constexpr double kBlockageDepth_m = kDiscSpacing_m;
// One that a way around it met is larger by what ways keep of it.
inline constexpr double kBlockageGrowth_m = planning::kPlanMargin_m;
inline constexpr double kObstacleNear_m = kMaxBlockageRadius_m;

// Something that moves counts as standing when nobody has moved for so long.
inline constexpr double kWaitForMoving_s = kNobodyMovedFor_s;
// Waits, and what is remembered of a blockage, double three times.
inline constexpr double kLongestWait_s = 8 * kFirstWait_s;
inline constexpr double kMaxBlockageMemory_s = 8 * kBlockageMemory_s;
// Before the robot goes on, all must be well for as long as after any stop.
inline constexpr double kAllWell_s = kSettle_s;
// The base may lean so much more than its model says, and ground that leans
// less is level.
inline constexpr double kTiltMargin_rad = kTiltNoise_rad;
inline constexpr double kLevelGround_rad = kTiltNoise_rad;

// All of the folder, relocalization_parameters.h first.
std::vector<base::ParameterRow> BehaviorParameters();

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_PARAMETERS_H_
