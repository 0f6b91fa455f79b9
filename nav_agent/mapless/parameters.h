// The tuned constants of driving without a map, and the table of all of them.
#ifndef NAV_AGENT_MAPLESS_PARAMETERS_H_
#define NAV_AGENT_MAPLESS_PARAMETERS_H_

#include <vector>

#include "common/base/parameter.h"

namespace treeline::mapless {

// ---- The evidence grid ----

inline constexpr base::Parameter<double> kCell_m{
    "evidence_cell", 0.04, "m", base::ParameterOrigin::kTuned,
    "finer costs time, coarser closes narrow ways; on fields 1 to 40"};
inline constexpr base::Parameter<int> kHitEvidence{
    "hit_evidence", 4, "", base::ParameterOrigin::kTuned,
    "of a beam that ends in a cell, against one that passes; a thin post is "
    "passed by many"};
inline constexpr base::Parameter<int> kMaxEvidence{
    "max_evidence", 24, "", base::ParameterOrigin::kTuned,
    "so many scans must see a thing gone, 0.6 s"};

// ---- The way ----

inline constexpr base::Parameter<double> kBodyMargin_m{
    "body_margin", 0.03, "m", base::ParameterOrigin::kGeometry,
    "beside the body, for the width of a cell"};
inline constexpr base::Parameter<double> kSoftRoom_m{
    "soft_room", 0.25, "m", base::ParameterOrigin::kTuned,
    "beyond the body's circle, from where nearness costs"};
inline constexpr base::Parameter<double> kNearCost{
    "near_cost", 3, "", base::ParameterOrigin::kTuned,
    "a metre with the body at an obstacle costs so many more"};
inline constexpr base::Parameter<double> kPresentWay{
    "present_way", 0.8, "", base::ParameterOrigin::kTuned,
    "what a metre of the present way costs: another must be a fifth better"};
inline constexpr base::Parameter<double> kWayWidth_m{
    "way_width", 0.3, "m", base::ParameterOrigin::kTuned,
    "this near to it is the present way"};
inline constexpr base::Parameter<double> kReplan_s{
    "replan_interval", 0.15, "s", base::ParameterOrigin::kTuned,
    "between plans on what was seen since"};

// ---- The rollouts ----

inline constexpr base::Parameter<double> kHorizon_s{
    "rollout_horizon", 1.3, "s", base::ParameterOrigin::kTuned,
    "that commands are tried out for"};
inline constexpr base::Parameter<double> kFirstPart_s{
    "rollout_first_part", 0.4, "s", base::ParameterOrigin::kTuned,
    "then a rollout turns otherwise"};
inline constexpr base::Parameter<double> kAhead_m{
    "look_ahead", 0.3, "m", base::ParameterOrigin::kTuned,
    "before the base, whose way to go counts as much as its own: it turns "
    "towards the way"};
inline constexpr base::Parameter<double> kSlowest_mps{
    "slowest", 0.35, "m/s", base::ParameterOrigin::kTuned,
    "where something is as near as the body allows"};
inline constexpr base::Parameter<double> kSpeedOfRoom_ps{
    "speed_of_room", 8, "1/s", base::ParameterOrigin::kTuned,
    "so much faster for each metre of room beside the body"};
inline constexpr base::Parameter<double> kStuck_s{
    "stuck", 1.0, "s", base::ParameterOrigin::kTuned,
    "of standing on the way; then it backs off"};
inline constexpr base::Parameter<double> kBackOff_s{
    "back_off", 1.0, "s", base::ParameterOrigin::kTuned, "for so long"};

// ---- What moves ----

inline constexpr base::Parameter<int> kFittedScans{
    "mover_fitted_scans", 14, "scans", base::ParameterOrigin::kTuned,
    "place and speed of what moves are those of a straight line through so "
    "many, 0.35 s"};
inline constexpr base::Parameter<double> kMoverMemory_s{
    "mover_memory", 1.5, "s", base::ParameterOrigin::kTuned,
    "out of sight it moves on as it did, for so long"};
inline constexpr base::Parameter<double> kMoverSpread_m{
    "mover_spread", 0.06, "m", base::ParameterOrigin::kTuned,
    "how far off what moves may be of where it is seen"};
inline constexpr base::Parameter<double> kMoverSpread_mps{
    "mover_spread_rate", 0.12, "m/s", base::ParameterOrigin::kTuned,
    "and so much further each second that it is foretold"};
inline constexpr base::Parameter<double> kTouchCost_mps{
    "touch_cost", 60, "m/s", base::ParameterOrigin::kTuned,
    "a second of touching what moves is as dear as so many metres of way"};

inline constexpr base::Parameter<double> kBlindCost{
    "blind_cost", 3, "", base::ParameterOrigin::kTuned,
    "a metre backwards among what moves, where no laser looks, costs so many"};

// All of the folder.
std::vector<base::ParameterRow> MaplessParameters();

}  // namespace treeline::mapless

#endif  // NAV_AGENT_MAPLESS_PARAMETERS_H_
