// The tuned constants of the supervisor, and the table of all of the folder.
#ifndef NAV_AGENT_BEHAVIOR_PARAMETERS_H_
#define NAV_AGENT_BEHAVIOR_PARAMETERS_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/base/parameter.h"
#include "nav_agent/behavior/relocalization_parameters.h"
#include "nav_agent/control/obstacle_parameters.h"
#include "nav_agent/planning/planner_parameters.h"

namespace treeline::behavior {

// ---- The supervisor ----

inline constexpr base::Parameter<double> kMaxEstimateAge_s{
    "max_estimate_age", 0.5, "s", base::ParameterOrigin::kTuned,
    "an older estimate tells nothing"};
inline constexpr base::Parameter<int64_t> kSeeThroughEvery{
    "see_through_every", 4, "", base::ParameterOrigin::kTuned,
    "scans between looks through blockages"};
inline constexpr base::Parameter<int> kSeeThroughBeamStep{
    "see_through_beam_step", 2, "", base::ParameterOrigin::kTuned,
    "beams between those that are looked at"};
inline constexpr base::Parameter<double> kBlockageDepth_m{
    "blockage_depth", 0.25, "m", base::ParameterOrigin::kTuned,
    "what is seen this near to a blockage is of it"};
inline constexpr base::Parameter<double> kMaxAskAhead_m{
    "max_ask_ahead", 1.0, "m", base::ParameterOrigin::kTuned,
    "room that a lost robot asks for"};
inline constexpr base::Parameter<size_t> kShownParticles{
    "shown_particles", 500, "", base::ParameterOrigin::kPhysics,
    "bounds a snapshot"};
inline constexpr base::Parameter<size_t> kMaxWaitingEvents{
    "max_waiting_events", 10000, "", base::ParameterOrigin::kPhysics,
    "bounds the memory of events that nobody takes"};

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
inline constexpr base::Parameter<double> kMinMotion{
    "min_motion", 0.02, "", base::ParameterOrigin::kTuned,
    "slower wheels may repeat themselves (m/s and rad/s; and m or rad between "
    "scans)"};

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
inline constexpr base::Parameter<double> kRerouteAhead_m{
    "reroute_ahead", 0.6, "m", base::ParameterOrigin::kTuned,
    "that counts as blocked when the robot re-routes"};
inline constexpr base::Parameter<double> kMinWait_s{
    "min_wait", 1, "s", base::ParameterOrigin::kTuned,
    "a wait lasts so long, whatever has gone meanwhile"};
inline constexpr base::Parameter<double> kMaxStepMove_m{
    "max_step_move", 0.3, "m", base::ParameterOrigin::kPhysics,
    "further means that the estimate jumped"};
inline constexpr base::Parameter<double> kStraightSpeed_mps{
    "straight_speed", 0.1, "m/s", base::ParameterOrigin::kTuned,
    "faster is more than a crawl"};
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
inline constexpr base::Parameter<double> kMaxBackUp_s{
    "max_back_up", 6, "s", base::ParameterOrigin::kTuned,
    "more than twice what that takes"};
inline constexpr base::Parameter<double> kMaxLookAround_s{
    "max_look_around", 16, "s", base::ParameterOrigin::kTuned,
    "one and a half times what a full turn takes"};
inline constexpr base::Parameter<double> kFirstWait_s{
    "first_wait", 3, "s", base::ParameterOrigin::kTuned,
    "doubles every third recovery"};
inline constexpr base::Parameter<double> kMinBackUp_m{
    "min_back_up", 0.08, "m", base::ParameterOrigin::kTuned,
    "less is not worth it"};
inline constexpr base::Parameter<int> kBoldAfter{
    "bold_after", 4, "", base::ParameterOrigin::kTuned,
    "recoveries; then it backs up among people, too"};
inline constexpr base::Parameter<double> kSomebodyMoves_s{
    "somebody_moves", 0.2, "s", base::ParameterOrigin::kTuned,
    "less: somebody moves right now"};

// ---- What stands in the way is remembered ----

inline constexpr base::Parameter<double> kBlockageMemory_s{
    "blockage_memory", 30, "s", base::ParameterOrigin::kTuned,
    "the first time; twice as long each time it is met again"};
inline constexpr base::Parameter<double> kMaxBlockageRadius_m{
    "max_blockage_radius", 0.6, "m", base::ParameterOrigin::kTuned,
    "what is larger is several; also from where the band broke to the first "
    "seen cell"};
inline constexpr base::Parameter<double> kSameBlockage_m{
    "same_blockage", 0.1, "m", base::ParameterOrigin::kTuned,
    "discs this near are of one place; also the smallest that beams are to "
    "pass"};
inline constexpr base::Parameter<double> kBlockageMetAgain_s{
    "blockage_met_again", 2, "s", base::ParameterOrigin::kTuned,
    "the same, seen twice at once, was not met again"};
inline constexpr base::Parameter<double> kBlockageGrowth_m{
    "blockage_growth", 0.03, "m", base::ParameterOrigin::kTuned,
    "one that a way around it met is so much larger"};
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
inline constexpr base::Parameter<double> kDiscSpacing_m{
    "disc_spacing", 0.2, "m", base::ParameterOrigin::kTuned,
    "between discs, and to the one behind each: only the front is seen"};

// ---- Safe stops ----

inline constexpr base::Parameter<double> kTiltNoise_rad{
    "tilt_noise", 0.06, "rad", base::ParameterOrigin::kMeasured,
    "of the inertial sensor while the robot brakes: beyond its max_slope_rad, "
    "or on level ground"};
inline constexpr base::Parameter<double> kTilt_s{
    "tilt", 0.15, "s", base::ParameterOrigin::kTuned, "for so long"};
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
// What is ahead of a robot that re-routes begins at its front.
inline constexpr double kRerouteRadius_m = kRerouteAhead_m / 2;
// Slow, as an escape: it has no eyes behind. And as gentle as at a goal.
inline constexpr double kBackUp_mps = control::kEscapeSpeed_mps;
inline constexpr double kLookAround_radps = control::kGoalTurn_radps;
// Bounds a goal's recoveries.
inline constexpr int kMaxGivenBack = 3 * kMaxRecoveries;
// Nobody has moved for so long: nobody is about, and what moved stands; or not
// at this moment.
inline constexpr double kNobodyMovedFor_s = control::kQuiet_s;
inline constexpr double kQuietMoment_s = control::kQuietMin_s;
// As much as the local costmap widens what it sees.
inline constexpr double kBlockageMargin_m = control::kBodyWidening_m;
inline constexpr double kMinBlockageRadius_m = kSameBlockage_m;
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
