#include "common/config/config_flags.h"

#include <variant>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace treeline::config {
namespace {

std::string Help(const Setting& setting) {
  std::string help = setting.help;
  std::vector<std::string> notes;
  if (!setting.choices.empty()) {
    notes.push_back(absl::StrJoin(setting.choices, ", "));
  }
  if (setting.min <= setting.max) {
    notes.push_back(BoundsText(setting));
  }
  const auto* text = std::get_if<std::string>(&setting.default_value);
  const auto* list =
      std::get_if<std::vector<std::string>>(&setting.default_value);
  const bool is_flag = std::holds_alternative<bool>(setting.default_value);
  if (setting.required && text != nullptr && text->empty()) {
    notes.push_back("required");
  } else if (text != nullptr) {
    if (!text->empty()) notes.push_back(absl::StrCat("default ", *text));
  } else if (list != nullptr ? !list->empty() : !is_flag) {
    notes.push_back(absl::StrCat("default ", ToYaml(setting.default_value)));
  }
  if (setting.live) notes.push_back("SIGHUP");
  if (!notes.empty()) {
    absl::StrAppend(&help, " [", absl::StrJoin(notes, "; "), "]");
  }
  return help;
}

}  // namespace

ConfigFlags::ConfigFlags(CLI::App& app, const std::vector<Setting>& settings) {
  for (const Setting& setting : settings) {
    if (setting.secrecy == Secrecy::kSecret) continue;
    CLI::Option* option = nullptr;
    if (std::holds_alternative<bool>(setting.default_value)) {
      option = app.add_flag(FlagName(setting))
                   ->description(Help(setting))
                   ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    } else {
      option = app.add_option(FlagName(setting))
                   ->description(Help(setting))
                   ->type_name(ValueName(setting));
      if (std::holds_alternative<std::vector<std::string>>(
              setting.default_value)) {
        option->type_size(1)->expected(1, 1 << 10)->allow_extra_args(false);
      } else {
        option->type_size(1)->expected(1)->multi_option_policy(
            CLI::MultiOptionPolicy::TakeLast);
      }
    }
    flags_.emplace_back(setting, option);
  }
}

std::map<std::string, std::string> ConfigFlags::Given() const {
  std::map<std::string, std::string> given;
  for (const auto& [setting, option] : flags_) {
    if (option->count() == 0) continue;
    given[setting.name] =
        std::holds_alternative<std::vector<std::string>>(setting.default_value)
            ? absl::StrJoin(option->results(), ",")
            : option->results().back();
  }
  return given;
}

}  // namespace treeline::config
