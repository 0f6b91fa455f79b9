// What a LocalController does if it is not told otherwise.
#ifndef NAV_AGENT_CONTROL_SETTING_PARAMETERS_H_
#define NAV_AGENT_CONTROL_SETTING_PARAMETERS_H_

#include "common/base/parameter.h"

namespace treeline::control {

inline constexpr base::Parameter<double> kCostmapSize_m{
    "costmap_size", 4.0, "m", base::ParameterOrigin::kGeometry,
    "the band's horizon to either side of the robot, and room to pass"};
inline constexpr base::Parameter<double> kCostmapResolution_m{
    "costmap_resolution", 0.05, "m", base::ParameterOrigin::kGeometry,
    "a voxel of the map: finer shows nothing more"};
inline constexpr base::Parameter<double> kMaxForward_mps{
    "max_forward", 0.6, "m/s", base::ParameterOrigin::kTuned,
    "a walking pace among people; the agent's setting"};
inline constexpr base::Parameter<double> kGoalTolerance_m{
    "goal_tolerance", 0.10, "m", base::ParameterOrigin::kTuned,
    "nearer to its goal it is there; the agent's setting"};
inline constexpr base::Parameter<double> kGoalToleranceAngle_rad{
    "goal_tolerance_angle", 0.15, "rad", base::ParameterOrigin::kTuned,
    "the same of the heading"};
inline constexpr base::Parameter<double> kInflation_m{
    "inflation", 0.5, "m", base::ParameterOrigin::kTuned,
    "room beside the footprint that the band keeps where there is room"};

inline constexpr base::Parameter<double> kCycle_s{
    "cycle", 0.025, "s", base::ParameterOrigin::kPhysics,
    "40 commands and scans a second"};
inline constexpr base::Parameter<double> kDepthRate_hz{
    "depth_rate", 5, "1/s", base::ParameterOrigin::kTuned,
    "pictures for obstacles that the laser does not meet"};
inline constexpr base::Parameter<double> kStandingSpeed_mps{
    "standing_speed", 0.02, "m/s", base::ParameterOrigin::kTuned,
    "slower than this the robot stands; the slowest of an approach"};
inline constexpr base::Parameter<double> kCorner_m{
    "corner", 0.43, "m", base::ParameterOrigin::kGeometry,
    "from the axle's middle to the robot's furthest corner: what a turn of 1 "
    "rad moves"};

// ---- what follows ----
// A robot turns slowly if its corners move slowly, and stands if they do
// (rad/s).
inline constexpr double kStandingTurn_radps = kStandingSpeed_mps / kCorner_m;
// Half of that is no motion at all: pictures are sharp, and what is left of a
// command is not worth it.
inline constexpr double kMinSpeed_mps = kStandingSpeed_mps / 2;
inline constexpr double kMinTurn_radps = kStandingTurn_radps / 2;

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_SETTING_PARAMETERS_H_
