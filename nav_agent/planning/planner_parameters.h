// What is tuned of planning.
#ifndef NAV_AGENT_PLANNING_PLANNER_PARAMETERS_H_
#define NAV_AGENT_PLANNING_PLANNER_PARAMETERS_H_

#include "common/base/parameter.h"

namespace treeline::planning {

// ---- what is asked ----
inline constexpr base::Parameter<double> kPlanMargin_m{
    "plan_margin", 0.03, "m", base::ParameterOrigin::kTuned,
    "room beside the footprint: the error of following a line"};
inline constexpr base::Parameter<int> kMaxIterations{
    "max_iterations", 20000, "", base::ParameterOrigin::kTuned,
    "bounds the time of a plan that is not bounded otherwise"};
// ---- what a way costs ----
inline constexpr base::Parameter<double> kComfort_m{
    "comfort", 0.25, "m", base::ParameterOrigin::kTuned,
    "nearer than this beyond the circumradius to things a metre costs more"};
inline constexpr base::Parameter<double> kNearCost{
    "near_cost", 1.0, "", base::ParameterOrigin::kTuned,
    "at contact, so much more"};
inline constexpr base::Parameter<double> kComfortLength{
    "comfort_length", 0.005, "", base::ParameterOrigin::kTuned,
    "of the shortest way's length: what a cheaper way may be longer"};
inline constexpr base::Parameter<double> kShortShare{
    "short_share", 0.7, "", base::ParameterOrigin::kTuned,
    "of the time, or of iterations: a short way is looked for; the rest makes "
    "it cheap"};
inline constexpr base::Parameter<double> kSlopeCost{
    "slope_cost", 2.0, "", base::ParameterOrigin::kTuned,
    "on ground inclined by a sine of 1, so much more"};
inline constexpr base::Parameter<double> kTurnCost{
    "turn_cost", 0.05, "m/rad", base::ParameterOrigin::kTuned,
    "turning costs as much as driving this"};
// ---- how finely ways are looked at ----
inline constexpr base::Parameter<double> kTurnStep{
    "turn_step", 0.25, "cells", base::ParameterOrigin::kGeometry,
    "by which the furthest corner moves between headings that are checked"};
inline constexpr base::Parameter<double> kWayStep_m{
    "way_step", 0.1, "m", base::ParameterOrigin::kGeometry,
    "two cells: costs, paths and ways off a start are taken in such steps"};
inline constexpr base::Parameter<int> kEndHeadings{
    "end_headings", 12, "", base::ParameterOrigin::kTuned,
    "that are tried to both sides of an end that has no room"};
inline constexpr base::Parameter<int> kLeavingWay{
    "leaving_way", 5, "steps", base::ParameterOrigin::kGeometry,
    "of WayStep: a robot that cannot turn leaves by its length at most"};
// ---- routes over regions ----
inline constexpr base::Parameter<double> kNarrowCost{
    "narrow_cost", 8.0, "", base::ParameterOrigin::kTuned,
    "a metre costs so much more where the footprint cannot stand in a cell's "
    "middle: such ways are tried last"};
inline constexpr base::Parameter<int> kStandHeadings{
    "stand_headings", 16, "", base::ParameterOrigin::kGeometry,
    "that are tried there, as many as the lattice's"};
inline constexpr base::Parameter<int> kRouteAttempts{
    "route_attempts", 4, "", base::ParameterOrigin::kTuned,
    "routes that are tried with lines along them alone"};
inline constexpr base::Parameter<int> kBridgedAttempts{
    "bridged_attempts", 3, "", base::ParameterOrigin::kTuned,
    "then so many with trees over their narrow places"};
inline constexpr base::Parameter<double> kStuckCost{
    "stuck_cost", 4.0, "", base::ParameterOrigin::kTuned,
    "regions where the footprint got stuck cost so much more for the next"};
inline constexpr base::Parameter<double> kStuckReach_m{
    "stuck_reach", 0.6, "m", base::ParameterOrigin::kGeometry,
    "such regions are within a robot's length"};
inline constexpr base::Parameter<int> kBridgeIterations{
    "bridge_iterations", 150, "", base::ParameterOrigin::kTuned,
    "of two trees over a narrow place of a route"};
inline constexpr base::Parameter<double> kBridgeSpread{
    "bridge_spread", 0.3, "", base::ParameterOrigin::kTuned,
    "of its length: the deviation of their samples"};
inline constexpr base::Parameter<int> kBridgeNodes{
    "bridge_nodes", 8000, "nodes", base::ParameterOrigin::kTuned,
    "that the lattice may look at over a narrow place"};
inline constexpr base::Parameter<double> kSamePlace_m{
    "same_place", 0.4, "m", base::ParameterOrigin::kTuned,
    "narrow places whose ends are nearer than this are one: none is searched "
    "twice"};
inline constexpr base::Parameter<double> kAlternativeCost{
    "alternative_cost", 1.15, "", base::ParameterOrigin::kTuned,
    "routes longer than the best way by this are not looked at: blocks of "
    "cells have eight directions, so lengths are up to 8 % out"};
inline constexpr base::Parameter<double> kSight_m{
    "sight", 2.5, "m", base::ParameterOrigin::kTuned,
    "what is seen from a route over at most this is on the same side of "
    "things"};
// ---- trees ----
inline constexpr base::Parameter<double> kMaxStep_m{
    "max_step", 2.0, "m", base::ParameterOrigin::kTuned,
    "longer steps leave no nodes for others to begin at"};
inline constexpr base::Parameter<double> kLevelDistance_m{
    "level_distance", 2.0, "m", base::ParameterOrigin::kTuned,
    "what another level is further away"};
inline constexpr base::Parameter<int> kRootSteps{
    "root_steps", 6, "steps", base::ParameterOrigin::kTuned,
    "a root whose robot cannot turn leaves it in so many steps"};
inline constexpr base::Parameter<int> kGoalEvery{
    "goal_every", 16, "samples", base::ParameterOrigin::kTuned,
    "one sample in so many is the other tree's root"};
inline constexpr base::Parameter<int> kUnguidedIterations{
    "unguided_iterations", 300, "", base::ParameterOrigin::kTuned,
    "the trees grow so long before a guide is looked for: an open room takes "
    "less"};
inline constexpr base::Parameter<int> kAnywhereEvery{
    "anywhere_every", 4, "samples", base::ParameterOrigin::kTuned,
    "one in so many is anywhere once there is a guide"};
inline constexpr base::Parameter<double> kGuideSpacing_m{
    "guide_spacing", 0.15, "m", base::ParameterOrigin::kTuned,
    "points of a guide, and the deviation of samples about them; no less than "
    "a cell"};
inline constexpr base::Parameter<int> kEasyIterations{
    "easy_iterations", 600, "", base::ParameterOrigin::kTuned,
    "trees that have not met by then do not meet soon"};
// ---- making a way better ----
inline constexpr base::Parameter<int> kIdleAttempts{
    "idle_attempts", 250, "", base::ParameterOrigin::kTuned,
    "a way is left alone after so many in a row without a gain"};
inline constexpr base::Parameter<double> kMinGain_m{
    "min_gain", 1e-4, "m", base::ParameterOrigin::kTuned, "less is no gain"};
inline constexpr base::Parameter<double> kMinLine_m{
    "min_line", 0.02, "m", base::ParameterOrigin::kGeometry,
    "shorter lines have no direction to speak of"};
inline constexpr base::Parameter<int> kMoveEvery{
    "move_every", 3, "", base::ParameterOrigin::kTuned,
    "one attempt in so many moves a point, the others cut a corner"};
inline constexpr base::Parameter<int> kShiftedPoints{
    "shifted_points", 8, "points", base::ParameterOrigin::kTuned,
    "at most so many in a row are moved at once"};
inline constexpr base::Parameter<double> kShortcut_m{
    "shortcut", 6.0, "m", base::ParameterOrigin::kTuned,
    "three of four lines that are tried instead of others are of at most this"};
inline constexpr base::Parameter<double> kMaxCut_m{
    "max_cut", 1.5, "m", base::ParameterOrigin::kTuned,
    "corners are cut off so far from their point"};
inline constexpr base::Parameter<int> kIdleShare{
    "idle_share", 8, "", base::ParameterOrigin::kTuned,
    "a way of more points is left alone after so many attempts for each"};
inline constexpr base::Parameter<int> kQuickAttempts{
    "quick_attempts", 60, "", base::ParameterOrigin::kTuned,
    "another way is worked on if so many without a gain make it as cheap as "
    "the best, but for QuickExcess"};
inline constexpr base::Parameter<double> kQuickExcess{
    "quick_excess", 1.06, "", base::ParameterOrigin::kTuned,
    "of the best way's cost"};
inline constexpr base::Parameter<int> kFairAttempts{
    "fair_attempts", 120, "", base::ParameterOrigin::kTuned,
    "then so many more, if those make it as cheap but for FairExcess"};
inline constexpr base::Parameter<double> kFairExcess{
    "fair_excess", 1.02, "", base::ParameterOrigin::kTuned,
    "of the best way's cost"};
inline constexpr base::Parameter<int> kRestartIterations{
    "restart_iterations", 200, "", base::ParameterOrigin::kTuned,
    "of trees that look for another way"};
inline constexpr base::Parameter<int> kIdleRestarts{
    "idle_restarts", 40, "", base::ParameterOrigin::kTuned,
    "without a gain end the search"};
inline constexpr base::Parameter<double> kRestartGain{
    "restart_gain", 0.001, "", base::ParameterOrigin::kTuned,
    "of the cost: less is no gain of a restart"};
inline constexpr base::Parameter<int> kRestartTries{
    "restart_tries", 8, "", base::ParameterOrigin::kTuned,
    "samples that are drawn for one within the ellipse"};
inline constexpr base::Parameter<int> kPullAhead{
    "pull_ahead", 40, "points", base::ParameterOrigin::kTuned,
    "lines are tried over at most so many points of a guide"};
inline constexpr base::Parameter<double> kPullSpacingMax_m{
    "pull_spacing_max", 0.3, "m", base::ParameterOrigin::kTuned, "and at most"};
// ---- the lattice ----
inline constexpr base::Parameter<double> kGreed{
    "heuristic_weight", 1.5, "", base::ParameterOrigin::kTuned,
    "what is left to go counts more: fewer places, and ways are improved "
    "anyway"};
inline constexpr base::Parameter<double> kLastLine_m{
    "last_line", 1.0, "m", base::ParameterOrigin::kTuned,
    "from so near straight lines to the goal are tried"};
inline constexpr base::Parameter<double> kLastTurn_rad{
    "last_turn", 0.6, "rad", base::ParameterOrigin::kGeometry,
    "that need a turn of at most this: others are of other nodes"};
inline constexpr base::Parameter<int> kNicheNodes{
    "niche_nodes", 20000, "nodes", base::ParameterOrigin::kTuned,
    "a niche around the goal is no larger"};
inline constexpr base::Parameter<int> kFloodAfter{
    "flood_after", 4000, "nodes", base::ParameterOrigin::kTuned,
    "a search as long as this first asks a flood whether there is a way"};
// ---- planners of OMPL ----
inline constexpr base::Parameter<double> kOmplRange_m{
    "ompl_range", 1.5, "m", base::ParameterOrigin::kTuned,
    "the longest edge of their trees"};
inline constexpr base::Parameter<double> kOmplShare{
    "ompl_share", 0.9, "", base::ParameterOrigin::kTuned,
    "of the time, for their search; the rest for making it better"};
inline constexpr base::Parameter<double> kOmplLimit{
    "ompl_limit", 0.95, "", base::ParameterOrigin::kTuned,
    "of the time, after which a planner that did not end is left"};
inline constexpr base::Parameter<int> kOmplAskEvery{
    "ompl_ask_every", 256, "questions", base::ParameterOrigin::kTuned,
    "about bounds and distances, between two looks at the clock"};
// ---- how often time and stop are looked at ----
inline constexpr base::Parameter<int> kStopEvery{
    "stop_every", 32, "", base::ParameterOrigin::kTuned,
    "steps of trees, nodes, attempts: a millisecond or so"};

// ---- what follows ----
// A root is left in steps of two, ways are pulled tight over points no nearer
// than one (m).
inline constexpr double kRootStep_m = 2 * kWayStep_m;
inline constexpr double kPullSpacingMin_m = kWayStep_m;
// Of planners that only know places to turn in, four times the robot's length.
inline constexpr int kLongLeavingWay = 4 * kLeavingWay;

// Steps of a tree are no shorter, to get away from walls that are touched (m).
inline constexpr double kMinStep_m = kWayStep_m;

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_PLANNER_PARAMETERS_H_
