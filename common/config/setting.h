// One setting of a program: its name, type, bounds, and what may be done to it.
#ifndef COMMON_CONFIG_SETTING_H_
#define COMMON_CONFIG_SETTING_H_

#include <cstdint>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::config {

using ConfigValue =
    std::variant<bool, int64_t, double, std::string, std::vector<std::string>>;

// What of a value may be shown.
enum class Secrecy {
  kPublic,
  // An address that may hold user, password or a signed query: those are
  // hidden.
  kAddress,
  // Nothing; and it has no command-line flag, since every user of the machine
  // can read those.
  kSecret
};

struct Setting {
  // snake_case: the key in files. --snake-case is its flag, PREFIX_SNAKE_CASE
  // its environment variable.
  std::string name = {};
  // What the help calls its value: "DIR", "HOST:PORT". Empty: by its type.
  std::string value_name = {};
  // One sentence without its final dot.
  std::string help = {};
  // Also states the type.
  ConfigValue default_value = false;
  // Bounds of a number, both included; min > max: none.
  double min = 1;
  double max = 0;
  // The only texts allowed; none: any.
  std::vector<std::string> choices = {};
  // What else must hold; OK or INVALID_ARGUMENT, whose message follows "NAME:
  // ".
  std::function<absl::Status(const ConfigValue&)> check = {};
  // Whether it must be given a value that is not empty.
  bool required = false;
  // Whether a change takes effect without a restart.
  bool live = false;
  Secrecy secrecy = Secrecy::kPublic;
};

// "--max-message-mib".
std::string FlagName(const Setting& setting);
// "TREELINE_SERVER_MAX_MESSAGE_MIB" with the prefix "TREELINE_SERVER_".
std::string EnvironmentName(absl::string_view prefix, const Setting& setting);
// "BOOL", "INT", "NUMBER", "TEXT", "TEXT,...", or setting.value_name.
std::string ValueName(const Setting& setting);
// "1..100000"; empty: none.
std::string BoundsText(const Setting& setting);

// The value that `text` states, of the setting's type and within its bounds.
// A list is separated by commas; an empty text is the empty list. Truth is
// `true` or `false`. INVALID_ARGUMENT: "queue: 'many' is not a whole number".
absl::StatusOr<ConfigValue> ParseValue(const Setting& setting,
                                       absl::string_view text);

// Bounds, choices and check. INVALID_ARGUMENT: "queue is 0; it must be
// 1..100000". A value of another type is INVALID_ARGUMENT too.
absl::Status CheckValue(const Setting& setting, const ConfigValue& value);

// As YAML in one line, quoted where YAML would read something else.
std::string ToYaml(const ConfigValue& value);
// The same, without what is secret in it.
std::string ToYamlRedacted(const Setting& setting, const ConfigValue& value);
// "https://user:secret@host/path?signature" -> "https://***@host/path?***".
std::string RedactAddress(absl::string_view address);

// The setting of this name; null if there is none.
const Setting* FindSetting(const std::vector<Setting>& settings,
                           absl::string_view name);
// The name that `unknown` was probably meant to be; empty if none is near.
std::string NearestName(const std::vector<Setting>& settings,
                        absl::string_view unknown);

}  // namespace treeline::config

#endif  // COMMON_CONFIG_SETTING_H_
