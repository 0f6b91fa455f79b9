#include "nav_agent/app/bridge/ros_arguments.h"

#include <algorithm>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/yaml/yaml_node.h"
#include "nav_agent/app/bridge/bridge_config.h"
#include "nav_agent/app/bridge/ros_parameters.h"

namespace treeline::bridge_app {
namespace {

constexpr char kBegin[] = "--ros-args";

absl::Status NotKnown(const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat(
      "--ros-args: ", what,
      " is not understood; -r FROM:=TO, -r __ns:=NAME, -r __node:=NAME, "
      "-p NAME:=VALUE, --params-file FILE and --log-level LEVEL are"));
}

absl::StatusOr<std::pair<std::string, std::string>> Sides(
    const std::string& rule) {
  const size_t at = rule.find(":=");
  if (at == std::string::npos || at == 0) return NotKnown(rule);
  std::string from = rule.substr(0, at);
  // "node:from": of a node's own; there is one here.
  const size_t node = from.find(':');
  if (node != std::string::npos) from = from.substr(node + 1);
  return std::pair(std::move(from), rule.substr(at + 2));
}

absl::StatusOr<std::vector<std::string>> Remapped(const std::string& rule) {
  TL_ASSIGN_OR_RETURN(const auto sides, Sides(rule));
  const auto& [from, to] = sides;
  if (from == "__ns") return std::vector<std::string>{"--namespace", to};
  if (from == "__node" || from == "__name") {
    return std::vector<std::string>{"--node-name", to};
  }
  return std::vector<std::string>{"--remap", absl::StrCat(from, ":=", to)};
}

// A value is YAML: quotes and the brackets of a list are not part of it.
absl::StatusOr<std::vector<std::string>> Parameter(const std::string& rule) {
  TL_ASSIGN_OR_RETURN(const auto sides, Sides(rule));
  const auto& settings = BridgeConfigTable().settings();
  const config::Setting* setting = config::FindSetting(settings, sides.first);
  if (setting == nullptr) {
    return base::Annotate(UnknownParameter(settings, sides.first),
                          "--ros-args");
  }
  TL_ASSIGN_OR_RETURN(
      const yaml::YamlNode line,
      yaml::YamlNode::Parse(absl::StrCat("value: ", sides.second),
                            "--ros-args: -p " + rule));
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode value, line.Get("value"));
  TL_ASSIGN_OR_RETURN(const std::string text, ParameterText(*setting, value));
  return std::vector<std::string>{
      absl::StrCat(config::FlagName(*setting), "=", text)};
}

// The flags for one argument of ROS, and its value if it has one.
absl::StatusOr<std::vector<std::string>> FlagsOf(const std::string& name,
                                                 const std::string& value) {
  if (name == "-r" || name == "--remap") return Remapped(value);
  if (name == "-p" || name == "--param") return Parameter(value);
  if (name == "--log-level") {
    return std::vector<std::string>{"--log-level",
                                    absl::AsciiStrToLower(value)};
  }
  if (name == "--params-file") {
    return std::vector<std::string>{"--params-file", value};
  }
  return NotKnown(name);
}

bool HasNoValue(const std::string& argument) {
  return absl::StartsWith(argument, "--enable-") ||
         absl::StartsWith(argument, "--disable-");
}

}  // namespace

absl::StatusOr<std::vector<std::string>> WithoutRosArguments(
    const std::vector<std::string>& arguments) {
  if (std::ranges::find(arguments, kBegin) == arguments.end()) return arguments;
  if (arguments.size() < 2 || arguments[1] != "bridge") {
    return absl::InvalidArgumentError(
        "--ros-args is for `bridge`; of `run --ros2 FILE` and `map --live "
        "--ros2 FILE`, namespace, node_name, remap and use_sim_time stand in "
        "the file (docs/reference/ros2-robot.md)");
  }
  std::vector<std::string> made;
  bool is_ros = false;
  for (size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    if (argument == kBegin || (is_ros && argument == "--")) {
      is_ros = argument == kBegin;
      continue;
    }
    if (!is_ros) {
      made.push_back(argument);
      continue;
    }
    // What becomes of ROS's own log is no matter here.
    if (HasNoValue(argument)) continue;
    if (i + 1 >= arguments.size()) {
      return absl::InvalidArgumentError(
          absl::StrCat("--ros-args: ", argument, " lacks its value"));
    }
    TL_ASSIGN_OR_RETURN(const std::vector<std::string> flags,
                        FlagsOf(argument, arguments[++i]));
    made.insert(made.end(), flags.begin(), flags.end());
  }
  return made;
}

}  // namespace treeline::bridge_app
