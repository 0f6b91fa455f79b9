// What is in force: defaults, below a file, below the environment, below flags.
#ifndef COMMON_CONFIG_EFFECTIVE_CONFIG_H_
#define COMMON_CONFIG_EFFECTIVE_CONFIG_H_

#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/config/config_file.h"
#include "common/config/setting.h"

namespace treeline::config {

struct EffectiveValue {
  ConfigValue value = false;
  // "default", "FILE:LINE", "environment NAME" or "flag --NAME".
  std::string origin = {};
};

// Every setting by its name.
using EffectiveConfig = std::map<std::string, EffectiveValue>;

// Where values come from, the weakest first.
struct ConfigSources {
  // Read anew by each ResolveConfig; empty: none.
  std::string file = {};
  // Variables by their whole name, and what ours start with.
  std::map<std::string, std::string> environment = {};
  std::string environment_prefix = {};
  // Texts of flags by the setting's name.
  std::map<std::string, std::string> flags = {};
};

// The variables of a process that start with `prefix`: EnvironmentWith(environ,
// "TREELINE_SERVER_").
std::map<std::string, std::string> EnvironmentWith(
    const char* const* environment, absl::string_view prefix);

// INVALID_ARGUMENT names the place of what is wrong: "site.yaml:3: queue ...",
// "environment TREELINE_SERVER_QUEUE: ...", "flag --queue: ...", or says that a
// required setting is missing. Errors of the file as ReadConfigFile.
absl::StatusOr<EffectiveConfig> ResolveConfig(
    const std::vector<Setting>& settings, const ConfigSources& sources);

// Variables with our prefix that no setting is behind, each with the setting
// that was probably meant: for a warning. They are no error, because Kubernetes
// makes variables of such names by itself for a service called treeline-server.
std::vector<std::string> UnknownVariables(const std::vector<Setting>& settings,
                                          const ConfigSources& sources);

// A YAML file with the same values, each with where it comes from as a comment.
// Without secrets: where there are any, reading it back does not give them.
std::string PrintConfig(const std::vector<Setting>& settings,
                        const EffectiveConfig& config);

// Names of the settings whose values differ, in the order of `settings`.
std::vector<std::string> ChangedSettings(const std::vector<Setting>& settings,
                                         const EffectiveConfig& before,
                                         const EffectiveConfig& after);

}  // namespace treeline::config

#endif  // COMMON_CONFIG_EFFECTIVE_CONFIG_H_
