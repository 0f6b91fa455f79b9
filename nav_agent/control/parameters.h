// The table of this folder's tuned constants.
#ifndef NAV_AGENT_CONTROL_PARAMETERS_H_
#define NAV_AGENT_CONTROL_PARAMETERS_H_

#include <vector>

#include "common/base/parameter.h"

namespace treeline::control {

// All of setting_, obstacle_, driving_ and manoeuvre_parameters.h, in this
// order. Those whose origin is kTuned were chosen in simulated drives.
std::vector<base::ParameterRow> ControlParameters();

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_PARAMETERS_H_
