// treeline-agent doctor: is this robot fit to drive?
#ifndef NAV_AGENT_APP_DOCTOR_DOCTOR_COMMAND_H_
#define NAV_AGENT_APP_DOCTOR_DOCTOR_COMMAND_H_

#include "common/cli/program.h"

namespace treeline::doctor_app {

cli::Command AddDoctorCommand(CLI::App& app);

}  // namespace treeline::doctor_app

#endif  // NAV_AGENT_APP_DOCTOR_DOCTOR_COMMAND_H_
