// What is tuned of arriving, waiting, and getting on again.
#ifndef NAV_AGENT_CONTROL_MANOEUVRE_PARAMETERS_H_
#define NAV_AGENT_CONTROL_MANOEUVRE_PARAMETERS_H_

#include <array>

#include "common/base/parameter.h"
#include "nav_agent/control/driving_parameters.h"

namespace treeline::control {

// ---- the goal ----
inline constexpr base::Parameter<double> kGoalNear_m{
    "goal_near", 0.25, "m", base::ParameterOrigin::kTuned,
    "the approach begins here, along the path and in a line"};
inline constexpr base::Parameter<double> kContentShare{
    "goal_deadband_share", 0.35, "", base::ParameterOrigin::kTuned,
    "of the tolerances, within which it goes no further"};
inline constexpr base::Parameter<double> kAbeamShare{
    "abeam_share", 0.75, "", base::ParameterOrigin::kTuned,
    "the same where the goal is beside it"};
inline constexpr base::Parameter<double> kLeaveShare{
    "leave_share", 0.95, "", base::ParameterOrigin::kTuned,
    "of the tolerances, beyond which it moves again"};
inline constexpr base::Parameter<double> kAbeam_m{
    "abeam", 0.02, "m", base::ParameterOrigin::kTuned,
    "ahead or behind by less is beside it"};
inline constexpr base::Parameter<double> kAlignFrom_rad{
    "align_from", 0.5, "rad", base::ParameterOrigin::kTuned,
    "off the line to the goal by more, it turns first"};
inline constexpr base::Parameter<double> kAlignUntil_rad{
    "align_until", 0.1, "rad", base::ParameterOrigin::kTuned,
    "until it is off by less"};
inline constexpr base::Parameter<double> kGoalBrakeShare{
    "goal_brake_share", 0.5, "", base::ParameterOrigin::kTuned,
    "of the robot's deceleration and of its turns: gently"};
inline constexpr base::Parameter<double> kGoalSpeed_mps{
    "goal_speed", 0.25, "m/s", base::ParameterOrigin::kTuned,
    "the fastest of the last decimetres"};
// ---- standing, waiting, blocked ----
inline constexpr base::Parameter<double> kBreak_s{
    "break", 0.4, "s", base::ParameterOrigin::kTuned,
    "a break of the band must last, and be gone for so long: people pass"};
inline constexpr base::Parameter<double> kPatience_s{
    "patience", 4.0, "s", base::ParameterOrigin::kTuned,
    "so long it is waited for what may go away, and other ways are tried"};
inline constexpr base::Parameter<double> kStuck_s{
    "stuck", 1.2, "s", base::ParameterOrigin::kTuned,
    "without getting on for so long, it is hindered"};
// ---- ways out ----
inline constexpr base::Parameter<double> kEscapeAhead_s{
    "escape_ahead", 0.8, "s", base::ParameterOrigin::kTuned,
    "moves are judged by where they lead in this, and twice this; a move and "
    "an escape last so long"};
inline constexpr base::Parameter<double> kEscapeLook_m{
    "escape_look", 0.8, "m", base::ParameterOrigin::kTuned,
    "the point of the track that it should look at"};
inline constexpr base::Parameter<double> kEscapeGain_rad{
    "escape_gain", 0.02, "rad", base::ParameterOrigin::kTuned,
    "a move must be better than none by more"};
inline constexpr base::Parameter<double> kHeldCost_rad{
    "held_cost", 0.5, "rad", base::ParameterOrigin::kTuned,
    "a place from which it may not turn to its track either"};
inline constexpr base::Parameter<double> kRoomWorth{
    "room_worth", 6.0, "rad/m", base::ParameterOrigin::kTuned,
    "what room beside it is worth"};
inline constexpr base::Parameter<double> kRoomWorthMax_m{
    "room_worth_max", 0.15, "m", base::ParameterOrigin::kTuned,
    "up to so much room"};
// ---- people behind ----
inline constexpr base::Parameter<double> kQuiet_s{
    "quiet", 8.0, "s", base::ParameterOrigin::kTuned,
    "nobody has been seen to move for so long: nobody is about"};
inline constexpr base::Parameter<double> kQuietMin_s{
    "quiet_min", 1.5, "s", base::ParameterOrigin::kTuned,
    "the least, for a robot that has stood for long"};
inline constexpr base::Parameter<double> kImpatience{
    "impatience", 0.5, "s/s", base::ParameterOrigin::kTuned,
    "so much less for each second that it has not got on"};
inline constexpr base::Parameter<double> kGotOn_m{
    "got_on", 0.15, "m", base::ParameterOrigin::kTuned,
    "it has got on when it is so far away"};
inline constexpr base::Parameter<std::array<double, 4>> kRoundedAhead_s{
    "rounded_ahead",
    {{0.3, 0.6, 0.9, 1.2}},
    "s",
    base::ParameterOrigin::kTuned,
    "there must be room so far along a rounded turn"};
inline constexpr base::Parameter<int> kTurnParts{
    "turn_parts", 72, "", base::ParameterOrigin::kGeometry,
    "headings of a full turn that are looked at: a corner moves by 4 cm"};

// ---- what follows ----
// A robot that turned by less has not got on: its corners moved by less than a
// cell (rad).
inline constexpr double kProgressAngle_rad = kCell_m / kCorner_m;
// The fastest turn while it moves to the goal: no corner is faster than the
// robot (rad/s).
inline constexpr double kGoalTurn_radps = kGoalSpeed_mps / kCorner_m;
// As gentle as the brake: of speed by distance, and of turning by angle (1/s).
inline constexpr double kGoalGain_hz = kGoalBrakeShare * kTurnGain_hz;

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_MANOEUVRE_PARAMETERS_H_
