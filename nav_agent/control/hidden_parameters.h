// What is tuned of people who are out of sight.
#ifndef NAV_AGENT_CONTROL_HIDDEN_PARAMETERS_H_
#define NAV_AGENT_CONTROL_HIDDEN_PARAMETERS_H_

#include "common/base/parameter.h"

namespace treeline::control {

inline constexpr base::Parameter<double> kLostArea_m2{
    "lost_area", 1.2, "m2", base::ParameterOrigin::kTuned,
    "who may be anywhere in more room is hardly where the robot's edge is"};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_HIDDEN_PARAMETERS_H_
