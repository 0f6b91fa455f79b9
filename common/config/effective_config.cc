#include "common/config/effective_config.h"

#include <algorithm>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/base/status_macros.h"

namespace treeline::config {
namespace {

// How a value can be given, for whoever did not.
std::string HowToGive(const Setting& setting, absl::string_view prefix) {
  const std::string variable = EnvironmentName(prefix, setting);
  return setting.secrecy == Secrecy::kSecret
             ? absl::StrCat("'", setting.name, "' in the file, or ", variable)
             : absl::StrCat(FlagName(setting), ", '", setting.name,
                            "' in the file, or ", variable);
}

}  // namespace

std::map<std::string, std::string> EnvironmentWith(
    const char* const* environment, absl::string_view prefix) {
  std::map<std::string, std::string> variables;
  for (; environment != nullptr && *environment != nullptr; ++environment) {
    const absl::string_view entry(*environment);
    const size_t equals = entry.find('=');
    if (equals == absl::string_view::npos) continue;
    if (!absl::StartsWith(entry.substr(0, equals), prefix)) continue;
    variables[std::string(entry.substr(0, equals))] =
        std::string(entry.substr(equals + 1));
  }
  return variables;
}

absl::StatusOr<EffectiveConfig> ResolveConfig(
    const std::vector<Setting>& settings, const ConfigSources& sources) {
  std::map<std::string, FileValue> file;
  if (!sources.file.empty()) {
    TL_ASSIGN_OR_RETURN(file, ReadConfigFile(sources.file, settings));
  }
  EffectiveConfig config;
  for (const Setting& setting : settings) {
    EffectiveValue effective = {setting.default_value, "default"};
    if (const auto in = file.find(setting.name); in != file.end()) {
      effective = {in->second.value,
                   absl::StrCat(sources.file, ":", in->second.line)};
    }
    const std::string variable =
        EnvironmentName(sources.environment_prefix, setting);
    if (const auto in = sources.environment.find(variable);
        in != sources.environment.end()) {
      const std::string origin = absl::StrCat("environment ", variable);
      auto value = ParseValue(setting, in->second);
      if (!value.ok()) return base::Annotate(value.status(), origin);
      effective = {*std::move(value), origin};
    }
    if (const auto in = sources.flags.find(setting.name);
        in != sources.flags.end()) {
      const std::string origin = absl::StrCat("flag ", FlagName(setting));
      auto value = ParseValue(setting, in->second);
      if (!value.ok()) return base::Annotate(value.status(), origin);
      effective = {*std::move(value), origin};
    }
    if (setting.required && effective.value == ConfigValue(std::string())) {
      return absl::InvalidArgumentError(absl::StrCat(
          setting.name,
          " must be given: ", HowToGive(setting, sources.environment_prefix)));
    }
    config[setting.name] = std::move(effective);
  }
  return config;
}

std::vector<std::string> UnknownVariables(const std::vector<Setting>& settings,
                                          const ConfigSources& sources) {
  std::vector<std::string> unknown;
  for (const auto& [name, value] : sources.environment) {
    const std::string key = absl::AsciiStrToLower(
        absl::string_view(name).substr(sources.environment_prefix.size()));
    if (FindSetting(settings, key) != nullptr &&
        EnvironmentName(sources.environment_prefix,
                        *FindSetting(settings, key)) == name) {
      continue;
    }
    // The file's own name comes this way too.
    if (name == absl::StrCat(sources.environment_prefix, "CONFIG")) continue;
    const std::string nearest = NearestName(settings, key);
    const Setting* meant = FindSetting(settings, nearest);
    unknown.push_back(
        meant == nullptr
            ? name
            : absl::StrCat(name, " (did you mean ",
                           EnvironmentName(sources.environment_prefix, *meant),
                           "?)"));
  }
  return unknown;
}

std::string PrintConfig(const std::vector<Setting>& settings,
                        const EffectiveConfig& config) {
  std::string text;
  for (const Setting& setting : settings) {
    const EffectiveValue& effective = config.at(setting.name);
    absl::StrAppend(&text, setting.name, ": ",
                    ToYamlRedacted(setting, effective.value), "  # ",
                    // One line, whatever the file is called.
                    absl::Utf8SafeCHexEscape(effective.origin), "\n");
  }
  return text;
}

std::vector<std::string> ChangedSettings(const std::vector<Setting>& settings,
                                         const EffectiveConfig& before,
                                         const EffectiveConfig& after) {
  std::vector<std::string> changed;
  for (const Setting& setting : settings) {
    if (before.at(setting.name).value != after.at(setting.name).value) {
      changed.push_back(setting.name);
    }
  }
  return changed;
}

}  // namespace treeline::config
