// Parameter files of ROS 2, as arbitrary bytes: no crash, and what is accepted
// are values that their settings take.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "absl/strings/string_view.h"
#include "common/config/setting.h"
#include "common/yaml/yaml_node.h"
#include "nav_agent/app/bridge/bridge_config.h"
#include "nav_agent/app/bridge/ros_parameters.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace treeline;  // NOLINT(google-build-using-namespace)
  const auto file = yaml::YamlNode::Parse(
      absl::string_view(reinterpret_cast<const char*>(data), size), "fuzz");
  if (!file.ok()) return 0;
  const std::vector<config::Setting>& settings =
      bridge_app::BridgeConfigTable().settings();
  const auto read =
      bridge_app::RosParametersOf(*file, "fuzz", "/robot1/treeline", settings);
  if (!read.ok()) return 0;
  for (const auto& [name, parameter] : read->values) {
    const config::Setting* setting = config::FindSetting(settings, name);
    if (setting == nullptr ||
        !config::ParseValue(*setting, parameter.text).ok()) {
      std::abort();
    }
  }
  return 0;
}
