// The tuned constants of docking and charging, and the table of all of them.
#ifndef NAV_AGENT_DOCKING_PARAMETERS_H_
#define NAV_AGENT_DOCKING_PARAMETERS_H_

#include <vector>

#include "common/base/parameter.h"

namespace treeline::docking {

// ---- where and how well ----

inline constexpr base::Parameter<double> kTolerance_m{
    "dock_tolerance", 0.02, "m", base::ParameterOrigin::kGeometry,
    "from the docked pose: what contacts of chargers allow"};
inline constexpr base::Parameter<double> kTolerance_rad{
    "dock_tolerance_angle", 0.035, "rad", base::ParameterOrigin::kGeometry,
    "the same of the heading, 2 degrees"};
inline constexpr base::Parameter<double> kAtDock_m{
    "at_dock", 0.15, "m", base::ParameterOrigin::kTuned,
    "nearer to the docked pose it is at the dock, or has touched it: what "
    "localization may be off, and more"};
inline constexpr base::Parameter<double> kAtDock_rad{
    "at_dock_angle", 0.17, "rad", base::ParameterOrigin::kTuned,
    "the same of the heading, 10 degrees"};
inline constexpr base::Parameter<double> kPress_m{
    "dock_press", 0.03, "m", base::ParameterOrigin::kTuned,
    "so much further it looks for the contact: what localization is off"};
inline constexpr base::Parameter<double> kStagingRoom_m{
    "staging_room", 0.4, "m", base::ParameterOrigin::kTuned,
    "between the robot's circle at its staging pose and the docked pose: way "
    "enough to come from the tolerance of a goal onto the line"};

// ---- what the laser sees from it ----

inline constexpr base::Parameter<int> kViewScans{
    "view_scans", 20, "", base::ParameterOrigin::kTuned,
    "of a robot that stands in its dock, for its view: a centimetre of noise "
    "becomes 2 mm, and it is done before a verdict that it is lost"};
inline constexpr base::Parameter<double> kViewReach_m{
    "view_reach", 0.2, "m", base::ParameterOrigin::kTuned,
    "so far off its view is looked for: twice what localization was seen off"};
inline constexpr base::Parameter<double> kViewTurn_rad{
    "view_turn", 0.14, "rad", base::ParameterOrigin::kTuned,
    "the same of the heading, 8 degrees"};
inline constexpr base::Parameter<double> kViewResponse{
    "view_response", 0.5, "", base::ParameterOrigin::kTuned,
    "of the scan's points, so many lie on the view's: the rest is what has "
    "moved since, and what the dock hides from there"};
inline constexpr base::Parameter<double> kInDockResponse{
    "in_dock_response", 0.7, "", base::ParameterOrigin::kTuned,
    "the same of a robot that would stand in it: it sees all of that"};
inline constexpr base::Parameter<double> kViewStd_m{
    "view_std", 0.04, "m", base::ParameterOrigin::kTuned,
    "by the matcher's careful word: in rooms it says 1 to 2 cm, along a bare "
    "corridor, where the laser does not tell where, 12"};
inline constexpr base::Parameter<double> kSeenFor_s{
    "view_seen_for", 1, "s", base::ParameterOrigin::kTuned,
    "so long it goes by where it saw the dock last"};
inline constexpr base::Parameter<double> kBodyReach_m{
    "dock_moved_reach", 0.1, "m", base::ParameterOrigin::kTuned,
    "a dock that was moved further is one for somebody to look at"};
inline constexpr base::Parameter<double> kBodyMoved_m{
    "dock_moved", 0.015, "m", base::ParameterOrigin::kTuned,
    "it was not moved by less: so well its body is seen"};

// ---- the drive ----

inline constexpr base::Parameter<double> kDockSpeed_mps{
    "dock_speed", 0.12, "m/s", base::ParameterOrigin::kTuned,
    "slow enough to be stepped away from"};
inline constexpr base::Parameter<double> kTouchSpeed_mps{
    "touch_speed", 0.03, "m/s", base::ParameterOrigin::kTuned,
    "what a contact may be pressed with; a base still obeys it"};
inline constexpr base::Parameter<double> kSpeedOfWay_ps{
    "dock_speed_of_way", 0.4, "1/s", base::ParameterOrigin::kTuned,
    "of the way that is left, until it touches"};
inline constexpr base::Parameter<double> kTurnSpeed_radps{
    "dock_turn_speed", 0.3, "rad/s", base::ParameterOrigin::kTuned,
    "on the spot: at the staging pose, and to be straight at last"};
inline constexpr base::Parameter<double> kLinesInWay{
    "lines_in_way", 5, "", base::ParameterOrigin::kTuned,
    "lengths of the pull to the line in the way from the staging pose: what it "
    "is beside it falls to a twenty-fifth"};
inline constexpr base::Parameter<double> kMaxCurvature_pm{
    "dock_curvature", 2.5, "1/m", base::ParameterOrigin::kTuned,
    "no tighter: the laser keeps the dock in view"};

// ---- patience ----

inline constexpr base::Parameter<int> kTries{"dock_tries", 3, "",
                                             base::ParameterOrigin::kTuned,
                                             "then somebody has to look"};
inline constexpr base::Parameter<double> kPatience_s{
    "dock_patience", 15, "s", base::ParameterOrigin::kTuned,
    "without getting on: people step aside sooner"};
inline constexpr base::Parameter<double> kContact_s{
    "contact", 5, "s", base::ParameterOrigin::kPhysics,
    "from a contact until the battery tells of it"};
inline constexpr base::Parameter<double> kIdle_s{
    "idle_before_charge", 10, "s", base::ParameterOrigin::kTuned,
    "an operator who gives one goal after another is not interrupted"};
inline constexpr base::Parameter<double> kLow_s{
    "low_before_charge", 5, "s", base::ParameterOrigin::kTuned,
    "one reading of a battery says nothing: a motor that starts draws it down"};
inline constexpr base::Parameter<double> kRetry_s{
    "charge_retry", 300, "s", base::ParameterOrigin::kTuned,
    "after no dock could be reached: doors open"};

// In the order above.
std::vector<base::ParameterRow> DockingParameters();

}  // namespace treeline::docking

#endif  // NAV_AGENT_DOCKING_PARAMETERS_H_
