// Parameter files of ROS 2, as settings.
#ifndef NAV_AGENT_APP_BRIDGE_ROS_PARAMETERS_H_
#define NAV_AGENT_APP_BRIDGE_ROS_PARAMETERS_H_

#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/config/setting.h"
#include "common/yaml/yaml_node.h"

namespace treeline::bridge_app {

// The text that ParseValue takes for what a parameter's value states: lists
// separated by commas, and of settings that are true or false all of YAML's
// words for it. INVALID_ARGUMENT for what is neither a value nor a list of
// them.
absl::StatusOr<std::string> ParameterText(const config::Setting& setting,
                                          const yaml::YamlNode& value);

// An error that names what was probably meant.
absl::Status UnknownParameter(const std::vector<config::Setting>& settings,
                              absl::string_view name);

// Whether a node's full name ("/robot1/treeline") is meant by a pattern of a
// file: "*" is one part of it, "**" any number, also none. A slash in front may
// be missing.
bool IsMeantBy(absl::string_view pattern, absl::string_view node);

struct RosParameter {
  std::string text;
  // "FILE:LINE".
  std::string origin;
};

struct RosParameters {
  // By the setting's name.
  std::map<std::string, RosParameter> values;
  // What is left out, for people.
  std::vector<std::string> notes;
};

// What the file has for this node (its full name), the last of several counts
// (https://design.ros2.org/articles/ros_command_line_arguments.html). Unknown
// parameters in a section that has the node's name are INVALID_ARGUMENT; one
// for several nodes may mean others, and a note says so, as it does of what
// every node of ROS has. So are values that their settings do not take, and
// what is no such file. What is for other nodes is no matter, but a file that
// has nothing for this one is noted.
absl::StatusOr<RosParameters> ReadRosParameters(
    const std::string& path, absl::string_view node,
    const std::vector<config::Setting>& settings);
// The same of what is read already: `root` of the file at `path`.
absl::StatusOr<RosParameters> RosParametersOf(
    const yaml::YamlNode& root, const std::string& path, absl::string_view node,
    const std::vector<config::Setting>& settings);

}  // namespace treeline::bridge_app

#endif  // NAV_AGENT_APP_BRIDGE_ROS_PARAMETERS_H_
