// The tuned constants of the robot's program, for people.
#ifndef NAV_AGENT_APP_RUN_PARAMETER_TABLES_H_
#define NAV_AGENT_APP_RUN_PARAMETER_TABLES_H_

#include <span>
#include <string>
#include <vector>

#include "common/base/parameter.h"

namespace treeline::run_app {

// The constants of one folder.
struct ParameterTable {
  std::string folder;
  std::vector<base::ParameterRow> rows;
};

// One a folder that has some.
std::vector<ParameterTable> AgentParameterTables();

// After the settings of `run --print-config`: comments, so that the whole can
// be read back as a file of settings.
std::string ParametersAsYamlComments(std::span<const ParameterTable> tables);

// The page docs/reference/parameters.md.
std::string ParametersAsMarkdown(std::span<const ParameterTable> tables);

}  // namespace treeline::run_app

#endif  // NAV_AGENT_APP_RUN_PARAMETER_TABLES_H_
