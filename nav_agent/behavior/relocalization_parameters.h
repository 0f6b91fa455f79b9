// The tuned constants of lost robots. parameters.h has those of the supervisor,
// and the table of all.
#ifndef NAV_AGENT_BEHAVIOR_RELOCALIZATION_PARAMETERS_H_
#define NAV_AGENT_BEHAVIOR_RELOCALIZATION_PARAMETERS_H_

#include <cstddef>
#include <cstdint>
#include <numbers>

#include "common/base/parameter.h"
#include "nav_agent/control/driving_parameters.h"
#include "nav_agent/control/manoeuvre_parameters.h"
#include "nav_agent/control/setting_parameters.h"
#include "nav_agent/localization/parameters.h"

namespace treeline::behavior {

// ---- Fix gate: whether a server's answer can be where the robot is ----

inline constexpr base::Parameter<double> kMinFixConfidence{
    "min_fix_confidence", 0.3, "", base::ParameterOrigin::kTuned,
    "the server's own probability below which a fix is refused; kidnaps in "
    "lab"};
inline constexpr base::Parameter<double> kSureFixConfidence{
    "sure_fix_confidence", 0.9, "", base::ParameterOrigin::kTuned,
    "from here on the server counts as sure; kidnaps in lab"};
inline constexpr base::Parameter<double> kMaxTiltError_rad{
    "max_tilt_error", 0.07, "rad", base::ParameterOrigin::kMeasured,
    "4 degrees; the inertial sensor is good to half a degree"};
inline constexpr base::Parameter<double> kMinFixExplained{
    "min_fix_explained", 0.5, "", base::ParameterOrigin::kTuned,
    "right places explain 0.86 to 0.98 of the beams, wrong ones 0.18 to 0.47 "
    "(lab)"};
inline constexpr base::Parameter<double> kMaxFixContradicted{
    "max_fix_contradicted", 0.25, "", base::ParameterOrigin::kTuned,
    "right places contradict at most 0.07 of the beams, wrong ones 0.11 to "
    "0.51 (lab); also what a fix may lose to where the robot thought it was"};
inline constexpr base::Parameter<double> kSureExplained{
    "sure_explained", 0.75, "", base::ParameterOrigin::kTuned,
    "below all right places in lab; also for what the laser finds alone"};
inline constexpr base::Parameter<double> kSureContradicted{
    "sure_contradicted", 0.08, "", base::ParameterOrigin::kTuned,
    "just above all right places in lab; a fix that loses by more to where the "
    "robot thought it was is weak"};
inline constexpr base::Parameter<int> kMinJudgedBeams{
    "min_judged_beams", 25, "", base::ParameterOrigin::kTuned,
    "of about 120: fewer beams say nothing"};
inline constexpr base::Parameter<double> kPairDistance_m{
    "pair_distance", 0.3, "m", base::ParameterOrigin::kTuned,
    "two fixes that agree, over the wheels' way between them; one alone may "
    "be off by half of this, and its deviation is not believed to be more"};
inline constexpr base::Parameter<double> kMinFixStd_m{
    "min_fix_std", 0.08, "m", base::ParameterOrigin::kTuned,
    "a fix is never better known than this"};
inline constexpr base::Parameter<double> kGhostReach_m{
    "ghost_reach", 1, "m", base::ParameterOrigin::kGeometry,
    "what the map has and reaches further from the robot is no ghost of a "
    "person or a cart"};
inline constexpr base::Parameter<double> kMinSeenThrough_m{
    "min_seen_through", 0.4, "m", base::ParameterOrigin::kGeometry,
    "of its cells beside each other that beams must pass beside the robot; "
    "less "
    "is a leg, which beams miss"};
inline constexpr base::Parameter<double> kSamePlace_m{
    "same_place", 0.5, "m", base::ParameterOrigin::kTuned,
    "nearer places are the same one"};
inline constexpr base::Parameter<double> kSamePlace_rad{
    "same_place", 0.35, "rad", base::ParameterOrigin::kTuned,
    "the same, of the heading; also the most of a drift"};
inline constexpr base::Parameter<double> kFitMoveCost_per_m{
    "fit_move_cost", 0.2, "1/m", base::ParameterOrigin::kTuned,
    "score that moving a fix must gain, and by the lever turning it"};
inline constexpr base::Parameter<double> kOtherView_rad{
    "other_view", 0.3, "rad", base::ParameterOrigin::kTuned,
    "views turned by more show something else, so their odds add up"};
inline constexpr base::Parameter<double> kSureLogOdds{
    "sure_log_odds", 4.6, "", base::ParameterOrigin::kTuned,
    "99 of 100: more than one view of 0.99 has"};
inline constexpr base::Parameter<int> kMaxRefusedFixes{
    "max_refused_fixes", 3, "", base::ParameterOrigin::kTuned,
    "sure fixes refused in a row: the server knows another place"};

// ---- A lost robot: when it stands, how it turns, how long it waits ----

inline constexpr base::Parameter<double> kSettle_s{
    "settle", 0.3, "s", base::ParameterOrigin::kTuned,
    "after the wheels stand, or all is well, until that is believed"};
inline constexpr base::Parameter<double> kMaxStopping_s{
    "max_stopping", 5, "s", base::ParameterOrigin::kTuned,
    "a robot that does not come to a stand looks all the same"};
inline constexpr base::Parameter<double> kLostPictureRate_hz{
    "lost_picture_rate", 10, "1/s", base::ParameterOrigin::kTuned,
    "at least, of a lost robot"};
inline constexpr base::Parameter<double> kCameraTimeout_s{
    "camera_timeout", 2, "s", base::ParameterOrigin::kTuned,
    "a camera without a picture for so long is silent; an older picture is of "
    "another place"};
inline constexpr base::Parameter<double> kAnswerDeadline_s{
    "answer_deadline", 3, "s", base::ParameterOrigin::kTuned,
    "of one question to the server"};
inline constexpr base::Parameter<double> kAnswerGrace_s{
    "answer_grace", 0.5, "s", base::ParameterOrigin::kTuned,
    "what the port may be late by"};
inline constexpr base::Parameter<double> kAnswerPatience_s{
    "answer_patience", 1, "s", base::ParameterOrigin::kTuned,
    "so long the robot stands and does nothing but wait"};
inline constexpr base::Parameter<int> kMaxQuestions{
    "max_questions", 30, "", base::ParameterOrigin::kTuned, "of one recovery"};
inline constexpr base::Parameter<int> kMaxFailures{
    "max_failures", 2, "", base::ParameterOrigin::kTuned,
    "questions in a row without an answer"};
inline constexpr base::Parameter<double> kMaxLaserSearch_s{
    "max_laser_search", 120, "s", base::ParameterOrigin::kTuned,
    "then the robot needs help"};
inline constexpr base::Parameter<double> kRecoveryTurn_radps{
    "recovery_turn", 0.8, "rad/s", base::ParameterOrigin::kTuned,
    "of a robot that does not know its place"};
inline constexpr base::Parameter<double> kMinTurnSpeed_radps{
    "min_turn_speed", 0.12, "rad/s", base::ParameterOrigin::kTuned,
    "so that a turn comes to its end"};
inline constexpr base::Parameter<double> kTurnStart_s{
    "turn_start", 1.5, "s", base::ParameterOrigin::kTuned,
    "who has not begun to turn by then has no room"};
inline constexpr base::Parameter<double> kSwingBlocked_s{
    "swing_blocked", 0.6, "s", base::ParameterOrigin::kTuned,
    "who has not turned for so long swings back"};
inline constexpr base::Parameter<int> kMaxSidesBlocked{
    "max_sides_blocked", 8, "", base::ParameterOrigin::kTuned,
    "tries to go ahead"};
inline constexpr base::Parameter<double> kRefusedPromise{
    "refused_promise", 0.03, "", base::ParameterOrigin::kTuned,
    "of a direction whose answer was refused"};

// ---- Confirming a fix ----

inline constexpr base::Parameter<int> kConfirmScans{
    "confirm_scans", 8, "", base::ParameterOrigin::kTuned, "scans in a row"};
inline constexpr base::Parameter<int> kQuestionsBeforeLaser{
    "questions_before_laser", 4, "", base::ParameterOrigin::kTuned,
    "then the laser's own place is tried before a second view"};
inline constexpr base::Parameter<double> kUniquePlaceVariance_m2{
    "unique_place_variance", 0.01, "m^2", base::ParameterOrigin::kMeasured,
    "the search's last step is 6 cm"};
inline constexpr base::Parameter<double> kUniquePlaceVariance_rad2{
    "unique_place_variance", 0.0064, "rad^2", base::ParameterOrigin::kMeasured,
    "and 2 degrees"};

// ---- Searching by laser ----

inline constexpr base::Parameter<double> kSearchContradicted{
    "search_contradicted", 0.12, "", base::ParameterOrigin::kTuned,
    "thin legs are thicker in voxels: right places contradict up to 0.1"};
inline constexpr base::Parameter<double> kSearchHold_s{
    "search_hold", 5, "s", base::ParameterOrigin::kTuned,
    "a place must hold for so long"};
inline constexpr base::Parameter<double> kSearchHold_rad{
    "search_hold", 3.5, "rad", base::ParameterOrigin::kTuned,
    "200 degrees: it has seen all around"};
inline constexpr base::Parameter<double> kAliasMargin{
    "alias_margin", 0.12, "", base::ParameterOrigin::kTuned,
    "scores closer than this are alike (rows of windows, equal offices)"};
inline constexpr base::Parameter<double> kMinSearchMove_m{
    "min_search_move", 0.3, "m", base::ParameterOrigin::kTuned,
    "shorter moves show nothing new; also kept free ahead"};
inline constexpr base::Parameter<double> kMaxBadScanShare{
    "max_bad_scan_share", 0.2, "", base::ParameterOrigin::kTuned,
    "of the scans while a place holds: somebody walks by"};
inline constexpr base::Parameter<int> kFreeBadScans{
    "free_bad_scans", 2, "", base::ParameterOrigin::kTuned,
    "that do not count"};
inline constexpr base::Parameter<double> kSupposedShare{
    "supposed_share", 0.25, "", base::ParameterOrigin::kPhysics,
    "of a place that is left, from which on what the map has about it is kept "
    "away from: four at most, which bounds what a step costs"};
inline constexpr base::Parameter<double> kPartingMinShare{
    "parting_min_share", 0.02, "", base::ParameterOrigin::kTuned,
    "of a place that views are to part from others: the rest goes by itself"};
inline constexpr base::Parameter<double> kPartingShare{
    "parting_share", 0.1, "", base::ParameterOrigin::kTuned,
    "of the beams: two places of which so many differ are parted by 1 - 1/e"};
inline constexpr base::Parameter<double> kPartingCost_per_m{
    "parting_cost", 0.03, "1/m", base::ParameterOrigin::kTuned,
    "of the way to a view, in its gain"};
inline constexpr base::Parameter<size_t> kPartingPlaces{
    "parting_places", 6, "", base::ParameterOrigin::kPhysics,
    "the likeliest: bounds what a view costs"};
inline constexpr base::Parameter<int> kPartingBeams{
    "parting_beams", 72, "", base::ParameterOrigin::kPhysics,
    "of an expected scan: bounds what a view costs"};
inline constexpr base::Parameter<double> kCameFrom_rad{
    "came_from", 0.8, "rad", base::ParameterOrigin::kTuned,
    "around straight back"};

// ---- The check while driving ----

inline constexpr base::Parameter<double> kCheckInterval_s{
    "check_interval", 20, "s", base::ParameterOrigin::kTuned,
    "between two checks, and between questions to a server that may have come "
    "back"};
inline constexpr base::Parameter<double> kCheckToldAfter_s{
    "check_told_after", 2, "s", base::ParameterOrigin::kTuned,
    "what a person says is checked soon"};
// Of a robot that recovers: where the way is not as the map has it, it may be
// elsewhere.
inline constexpr double kCheckInTrouble_s = kCheckInterval_s / 4;
inline constexpr base::Parameter<double> kMinCorrectionGain{
    "min_correction_gain", 0.03, "", base::ParameterOrigin::kTuned,
    "of the scan's score"};

// ---- Where to look next ----

inline constexpr base::Parameter<double> kHalfView_rad{
    "half_view", 0.5, "rad", base::ParameterOrigin::kGeometry,
    "half of the field of view of an Xtion"};
inline constexpr base::Parameter<double> kUnseenPrior{
    "unseen_prior", 0.35, "", base::ParameterOrigin::kTuned,
    "chance of a direction that the laser has not seen"};
inline constexpr base::Parameter<double> kMinWorthRange_m{
    "min_worth_range", 0.6, "m", base::ParameterOrigin::kTuned,
    "nearer walls fill the picture"};
inline constexpr base::Parameter<double> kFullWorthRange_m{
    "full_worth_range", 1.5, "m", base::ParameterOrigin::kTuned,
    "from here on pictures tell most"};
inline constexpr base::Parameter<double> kFarWorthRange_m{
    "far_worth_range", 6, "m", base::ParameterOrigin::kTuned,
    "open space beyond has no depth: what is twice as far tells half as much"};
inline constexpr base::Parameter<size_t> kMinViewBeams{
    "min_view_beams", 3, "", base::ParameterOrigin::kTuned,
    "fewer beams in view say nothing: as if it had not been seen"};
inline constexpr base::Parameter<double> kRangeStep_m{
    "range_step", 0.3, "m", base::ParameterOrigin::kTuned,
    "between beams: an edge"};
inline constexpr base::Parameter<double> kFullStructureSteps{
    "full_structure_steps", 6, "", base::ParameterOrigin::kTuned,
    "so many edges are all that counts"};
inline constexpr base::Parameter<double> kViewPriorBase{
    "view_prior_base", 0.05, "", base::ParameterOrigin::kTuned,
    "chance of a view of nothing"};
inline constexpr base::Parameter<double> kViewPriorWorth{
    "view_prior_worth", 0.4, "", base::ParameterOrigin::kTuned,
    "and what its distances add"};
inline constexpr base::Parameter<double> kViewPriorStructure{
    "view_prior_structure", 0.35, "", base::ParameterOrigin::kTuned,
    "and its edges"};
inline constexpr base::Parameter<double> kSharedView_rad{
    "shared_view", 0.45, "rad", base::ParameterOrigin::kTuned,
    "standard deviation over which answers tell of neighbours"};
inline constexpr base::Parameter<double> kKnownWorth{
    "known_worth", 0.5, "", base::ParameterOrigin::kTuned,
    "to ask again, or to go where the robot came from, tells half as much"};
inline constexpr base::Parameter<double> kTurnCost_per_rad{
    "turn_cost", 0.1, "1/rad", base::ParameterOrigin::kTuned, "in probability"};
inline constexpr base::Parameter<double> kSecondViewGain{
    "second_view_gain", 0.5, "", base::ParameterOrigin::kTuned,
    "of such a direction"};

// ---- what follows from others ----

// For a sharp picture the robot moves by less than half of what counts as
// standing elsewhere.
inline constexpr double kStandstillSpeed_mps = control::kMinSpeed_mps;
inline constexpr double kStandstillYawRate_radps = control::kMinTurn_radps;
// The heading of two fixes that agree (rad).
inline constexpr double kPairAngle_rad =
    kPairDistance_m / localization::kHeadingLever_m;
// A covariance that says more than two fixes may differ by is not believed (m).
inline constexpr double kMaxFixStd_m = kPairDistance_m;
// A drift is not to what is another place to the search over the map; beyond,
// one of the two is wrong (m).
inline constexpr double kMaxDrift_m = localization::kOtherPlace_m;
// A fix is of the ground that is no further above or below it than what the
// robot goes over: other floors are further away (m).
inline constexpr double kMaxFixHeight_m = localization::kMaxRise_m;
// Turning a fix moves what is a lever away (1/rad).
inline constexpr double kFitTurnCost_per_rad =
    kFitMoveCost_per_m * localization::kHeadingLever_m;
// Beams that fit better where the robot thought it was speak against a fix as
// those that contradict it do: from here on it is refused, or weak.
inline constexpr double kRefusedWorseThanBelief = kMaxFixContradicted;
inline constexpr double kMaxWorseThanBelief = kSureContradicted;
// Scans of a robot that turns to confirm a fix may be half way from sure to
// refused: people walk by.
inline constexpr double kConfirmExplained =
    (kSureExplained + kMinFixExplained) / 2;
inline constexpr double kConfirmContradicted =
    (kSureContradicted + kMaxFixContradicted) / 2;
// Of what is seen through, beams may end on so much as a sure fix may be
// contradicted by.
inline constexpr double kMaxGhostHitShare = kSureContradicted;
// A fix may be off by half of what two may differ by.
inline constexpr double kFixSearch_m = kPairDistance_m / 2;
inline constexpr double kFixSearch_rad = kPairAngle_rad / 2;
inline constexpr double kMinFixStd_rad =
    kMinFixStd_m / localization::kHeadingLever_m;
inline constexpr double kMaxFixStd_rad =
    kMaxFixStd_m / localization::kHeadingLever_m;
// A second view is away from the first by twice what makes it another one,
// about.
inline constexpr double kSecondView_rad = 2 * kOtherView_rad;
inline constexpr double kSecondViewWidth_rad = kOtherView_rad;
// As slow as where there is no room: the map is not known.
inline constexpr double kRecoveryMove_mps = control::kSlowSpeed_mps;
// On a way that the map has free wherever the robot may be it is faster.
inline constexpr double kKnownWayMove_mps = 3 * control::kSlowSpeed_mps;
// Views that part places are looked for as far as two windows reach (m).
inline constexpr double kPartingReach_m = 2 * control::kCostmapSize_m;
// A view that parts places is worth as much as a picture.
inline constexpr double kMinPartingGain = 2 * kRefusedPromise;
// Room beside the robot on such a way: a cell of the costmap (m).
inline constexpr double kPartingRoom_m = control::kCostmapResolution_m;
// Turns of a robot that does not know its place are those of one near its goal.
inline constexpr double kTurnGain_per_s = control::kGoalGain_hz;
inline constexpr double kTurnTolerance_rad = control::kAlignUntil_rad;
// A view that was seen whole may be beside the camera by what a turn is off.
inline constexpr double kViewEdgeSlack_rad = kTurnTolerance_rad;
// A turn to the next view takes no longer than one and a half times a full
// turn; a leg of a search none longer than to turn around and back; to confirm
// takes less than a full turn (s).
inline constexpr double kFullTurn_s =
    2 * std::numbers::pi / kRecoveryTurn_radps;
inline constexpr double kMaxTurning_s = 1.5 * kFullTurn_s;
inline constexpr double kMaxSearchLeg_s = 2 * kFullTurn_s;
inline constexpr double kMaxConfirming_s = kFullTurn_s;
// While it confirms it turns as gently as at a goal: AMCL follows better.
inline constexpr double kConfirmTurn_radps = control::kGoalTurn_radps;
// Scans that are apart by half of what a camera sees are of something else.
inline constexpr double kNewViewTurn_rad = kHalfView_rad;
// Who has not turned for so long is held to both sides, for certain.
inline constexpr double kSearchHeld_s = 4 * kSwingBlocked_s;
// What held the robot counts from the same place only, and it keeps away from
// that by what is no progress.
inline constexpr double kHeldPlace_m = control::kGotOn_m;
inline constexpr double kHeldMargin_rad = control::kProgressAngle_rad;
// Room for a little way ahead (m).
inline constexpr double kMinFreeAhead_m = kMinSearchMove_m;
// While it searches, a picture after a question has been waited for (s).
inline constexpr double kAskInterval_s = kAnswerDeadline_s + kAnswerPatience_s;
inline constexpr double kAskFailedInterval_s = kCheckInterval_s;
// What has not turned enough in half of the time has no room.
inline constexpr double kConfirmNoRoom_s = kMaxConfirming_s / 2;
// A trial ends after half as many bad scans again as there must be good ones.
inline constexpr int kMaxBadScans = kConfirmScans * 3 / 2;
// The place before is less well known than it was: as one found by laser (m^2,
// rad^2).
inline constexpr double kRestoredVariance = kUniquePlaceVariance_m2;
// A picture as old as two are apart is not asked about.
inline constexpr double kMaxPictureAge_s = 2 / kLostPictureRate_hz;
// All questions of a recovery, each answered at its deadline; then the laser
// looks alone.
inline constexpr double kMaxServerSearch_s = kMaxQuestions * kAnswerDeadline_s;
// Bounds the memory of fixes that wait for a second one.
inline constexpr size_t kMaxWaitingFixes = localization::kMaxWaitingScans;

// A place that was taken is as well known as the worst of fixes.
inline constexpr double kMaxConfirmStd_m = kMaxFixStd_m;
inline constexpr double kSearchStd_m = kMaxFixStd_m;
// Two fixes in a row, each as far off as two may differ.
inline constexpr double kMaxConfirmDrift_m = 2 * kPairDistance_m;
// What has been found is not lost any more.
inline constexpr double kMaxSearchLostProbability = localization::kWithdrawLost;
inline constexpr double kMaxConfirmLostProbability =
    localization::kWithdrawLost;
// AMCL knows its place if as much of its weight is there.
inline constexpr double kKnownShare = 1 - localization::kWithdrawLost;
// AMCL's own measure of having found the place.
inline constexpr double kSearchShare = localization::kFoundShare;
// A picture is of after the robot has come to rest.
inline constexpr double kPictureSettle_s = kSettle_s;
// Twice what a direction promises whose answer was refused.
inline constexpr double kMinPromise = 2 * kRefusedPromise;
// A check agrees as two fixes do, whatever the deviations.
inline constexpr double kCheckAgree_m = kPairDistance_m;
inline constexpr double kCheckAgree_rad = kPairAngle_rad;
inline constexpr double kMaxDrift_rad = kSamePlace_rad;

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_RELOCALIZATION_PARAMETERS_H_
