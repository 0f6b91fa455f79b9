// What is tuned of following a path.
#ifndef NAV_AGENT_CONTROL_DRIVING_PARAMETERS_H_
#define NAV_AGENT_CONTROL_DRIVING_PARAMETERS_H_

#include "common/base/parameter.h"
#include "nav_agent/control/obstacle_parameters.h"
#include "nav_agent/control/setting_parameters.h"

namespace treeline::control {

// ---- room and commands ----
// ---- the path ----
inline constexpr base::Parameter<double> kPathBack_m{
    "path_back", 0.3, "m", base::ParameterOrigin::kTuned,
    "the nearest point of the path is looked for so far back"};
inline constexpr base::Parameter<double> kPathAhead_m{
    "path_ahead", 1.0, "m", base::ParameterOrigin::kTuned,
    "and ahead; twice as far on a new path"};
inline constexpr base::Parameter<double> kStoreyHeight_m{
    "storey_height", 1.0, "m", base::ParameterOrigin::kGeometry,
    "what differs more is of another floor"};
// ---- the band ----
inline constexpr base::Parameter<double> kHorizon_m{
    "horizon", 3.0, "m", base::ParameterOrigin::kTuned,
    "of the path that the band follows, as far as the window shows it"};
inline constexpr base::Parameter<double> kLostBand_m{
    "lost_band", 0.5, "m", base::ParameterOrigin::kTuned,
    "a robot that is further off was pushed, or told another pose"};
inline constexpr base::Parameter<double> kSkipCost{
    "skip_cost", 0.3, "m/m", base::ParameterOrigin::kTuned,
    "a way around may come back to the path late, but not for nothing, and "
    "corners are not cut off"};
inline constexpr base::Parameter<double> kRepulsion{
    "repulsion", 2.5, "1/m", base::ParameterOrigin::kTuned,
    "k_r, in units of k_c; narrow places are passed in the middle"};
inline constexpr base::Parameter<double> kBandGain{
    "band_gain", 0.4, "", base::ParameterOrigin::kTuned,
    "of a bubble's move by radius and force: with more they swing"};
inline constexpr base::Parameter<double> kTurnWay{
    "turn_path", 0.1, "m/rad", base::ParameterOrigin::kGeometry,
    "what a turn between neighbours takes of their room"};
inline constexpr base::Parameter<int> kBandIterations{
    "band_iterations", 3, "", base::ParameterOrigin::kTuned,
    "a step; 40 steps a second do the rest"};
inline constexpr base::Parameter<double> kGradientStep_m{
    "gradient_step", 0.03, "m", base::ParameterOrigin::kGeometry,
    "to either side: gradients are taken over more than a cell"};
inline constexpr base::Parameter<double> kFlatGradient{
    "flat_gradient", 0.1, "", base::ParameterOrigin::kTuned,
    "within something the footprint's distance says little"};
inline constexpr base::Parameter<double> kOverlapShare{
    "overlap_share", 0.9, "", base::ParameterOrigin::kTuned,
    "of both radii: bubbles that overlap by less get one between them"};
// ---- the search ----
inline constexpr base::Parameter<double> kRoomPrice{
    "room_price", 4.0, "", base::ParameterOrigin::kTuned,
    "up to 1 + this times as much"};
// ---- speeds along a track ----
inline constexpr base::Parameter<double> kAccelerationShare{
    "acceleration_share", 0.6, "", base::ParameterOrigin::kTuned,
    "of the robot's, for profiles: the rest is for corrections"};
inline constexpr base::Parameter<double> kYawShare{
    "yaw_share", 0.7, "", base::ParameterOrigin::kTuned, "the same of turning"};
inline constexpr base::Parameter<double> kLookAheadBase_m{
    "look_ahead_base", 0.22, "m", base::ParameterOrigin::kTuned,
    "pure pursuit steers for a point so far ahead, standing; lines do not "
    "swing"};
inline constexpr base::Parameter<double> kLookAheadTime_s{
    "look_ahead_time", 0.45, "s", base::ParameterOrigin::kTuned,
    "and so much further by its speed"};
inline constexpr base::Parameter<double> kSlowSpeed_mps{
    "slow_speed", 0.15, "m/s", base::ParameterOrigin::kTuned,
    "where there is no room beside it, of ways out, and to see whether it "
    "might set off"};
inline constexpr base::Parameter<double> kNarrowGain_hz{
    "narrow_gain", 1.2, "1/s", base::ParameterOrigin::kTuned,
    "more speed by room beside the footprint"};
inline constexpr base::Parameter<double> kDirection_m{
    "direction", 0.15, "m", base::ParameterOrigin::kGeometry,
    "three points of a track: its direction, and its curvature"};
inline constexpr base::Parameter<double> kSlopeSlowing{
    "slope_slowing", 0.5, "", base::ParameterOrigin::kTuned,
    "of the speed, lost on the steepest slope"};
inline constexpr base::Parameter<double> kTurnFrom_rad{
    "turn_from", 0.9, "rad", base::ParameterOrigin::kTuned,
    "off its heading by more, it turns on the spot"};
inline constexpr base::Parameter<double> kTurnUntil_rad{
    "turn_until", 0.25, "rad", base::ParameterOrigin::kTuned,
    "until it is off by less"};
inline constexpr base::Parameter<double> kTurnGain_hz{
    "turn_gain", 4.0, "1/s", base::ParameterOrigin::kTuned,
    "near the end of a turn in proportion: lateness must not make it swing"};

// ---- what follows ----
// Turns are slow if the robot's corners are (rad/s).
inline constexpr double kSlowTurn_radps = kSlowSpeed_mps / kCorner_m;
// The slowest that is driven where there is a way (m/s).
inline constexpr double kCreep_mps = kSlowSpeed_mps / 2;
// A turn that is off by less is no motion any more (rad).
inline constexpr double kTurned_rad = kStandingTurn_radps / kTurnGain_hz;
// Ways out of something, and about the start of a search, are within the
// robot's corners (m).
inline constexpr double kLeaving_m = kCorner_m;
// Of two commands: less is jitter of the clock (s).
inline constexpr double kMinInterval_s = kCycle_s / 5;

// A base says what it did late, and scans of two lasers come apart: by four
// cycles at most (s).
inline constexpr double kLag_s = 4 * kCycle_s;
// A search that found nothing finds nothing before what is late has come
// (steps).
inline constexpr auto kRestSteps = static_cast<int>(kLag_s / kCycle_s);
// Scans further apart say nothing of speeds (s).
inline constexpr double kLongestInterval_s = 10 * kCycle_s;
// Points of a track are a cell apart; so far a bubble moves in one go, and a
// robot that moved as far has got on (m).
inline constexpr double kCell_m = kCostmapResolution_m;
// Bubbles, and places on the path that are looked at, are no nearer to each
// other; a search stays this far from the window's edge; no obstacle is taken
// for smaller (m).
inline constexpr double kTwoCells_m = 2 * kCostmapResolution_m;
// New bubbles on the path are this far apart (m).
inline constexpr double kFourCells_m = 4 * kCostmapResolution_m;
// Twice what the horizon holds at the smallest spacing.
inline constexpr auto kMaxBubbles =
    static_cast<int>(2 * kHorizon_m / kTwoCells_m);

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_DRIVING_PARAMETERS_H_
