#include "common/config/setting.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "common/base/nearest_name.h"
#include "common/base/status_macros.h"

namespace treeline::config {
namespace {

// The digits that read back as the same number, and no more.
std::string Shortest(double value) {
  // Not 1e+05.
  if (std::abs(value) < 1e15 && value == std::trunc(value)) {
    return absl::StrCat(static_cast<int64_t>(value));
  }
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof(buffer), value).ptr;
  return std::string(buffer, end);
}

absl::Status WrongType(const Setting& setting, absl::string_view text,
                       absl::string_view what) {
  // A secret does not reach the log by being mistyped.
  const std::string shown =
      setting.secrecy == Secrecy::kPublic
          ? absl::StrCat("'", absl::CHexEscape(text.substr(0, 100)), "'")
          : std::string("its value");
  return absl::InvalidArgumentError(
      absl::StrCat(setting.name, ": ", shown, " is not ", what));
}

absl::StatusOr<ConfigValue> ParseList(absl::string_view text) {
  std::vector<std::string> parts;
  if (!absl::StripAsciiWhitespace(text).empty()) {
    for (const absl::string_view part : absl::StrSplit(text, ',')) {
      parts.emplace_back(absl::StripAsciiWhitespace(part));
    }
  }
  return ConfigValue(std::move(parts));
}

absl::StatusOr<ConfigValue> ParseOfType(const Setting& setting,
                                        absl::string_view text) {
  switch (setting.default_value.index()) {
    case 0:
      if (text == "true") return ConfigValue(true);
      if (text == "false") return ConfigValue(false);
      return WrongType(setting, text, "true or false");
    case 1: {
      int64_t number = 0;
      if (!absl::SimpleAtoi(text, &number)) {
        return WrongType(setting, text, "a whole number");
      }
      return ConfigValue(number);
    }
    case 2: {
      double number = 0;
      if (!absl::SimpleAtod(text, &number) || !std::isfinite(number)) {
        return WrongType(setting, text, "a number");
      }
      return ConfigValue(number);
    }
    case 3:
      return ConfigValue(std::string(text));
    default:
      return ParseList(text);
  }
}

absl::Status CheckBounds(const Setting& setting, double value,
                         const std::string& text) {
  if (setting.min > setting.max) return absl::OkStatus();
  if (value >= setting.min && value <= setting.max) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(
      setting.name, " is ", text, "; it must be ", BoundsText(setting)));
}

absl::Status CheckText(const Setting& setting, const std::string& text) {
  if (setting.required && text.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(setting.name, " is empty; it must be given"));
  }
  if (text.find('\0') != std::string::npos) {
    return absl::InvalidArgumentError(
        absl::StrCat(setting.name, " has a zero byte in it"));
  }
  if (setting.choices.empty() ||
      std::find(setting.choices.begin(), setting.choices.end(), text) !=
          setting.choices.end()) {
    return absl::OkStatus();
  }
  return WrongType(
      setting, text,
      absl::StrCat("one of ", absl::StrJoin(setting.choices, ", ")));
}

std::string YamlText(const std::string& text) {
  // YAML knows these escapes too, but \xNN as a code point: bytes of UTF-8
  // stay.
  return absl::StrCat(
      "\"", absl::StrReplaceAll(absl::Utf8SafeCHexEscape(text), {{"\\'", "'"}}),
      "\"");
}

}  // namespace

std::string FlagName(const Setting& setting) {
  return absl::StrCat("--", absl::StrReplaceAll(setting.name, {{"_", "-"}}));
}

std::string EnvironmentName(absl::string_view prefix, const Setting& setting) {
  return absl::StrCat(prefix, absl::AsciiStrToUpper(setting.name));
}

std::string ValueName(const Setting& setting) {
  if (!setting.value_name.empty()) return setting.value_name;
  static constexpr const char* kByType[] = {"BOOL", "INT", "NUMBER", "TEXT",
                                            "TEXT,..."};
  return kByType[setting.default_value.index()];
}

std::string BoundsText(const Setting& setting) {
  if (setting.min > setting.max) return "";
  return absl::StrCat(Shortest(setting.min), "..", Shortest(setting.max));
}

absl::StatusOr<ConfigValue> ParseValue(const Setting& setting,
                                       absl::string_view text) {
  TL_ASSIGN_OR_RETURN(ConfigValue value, ParseOfType(setting, text));
  TL_RETURN_IF_ERROR(CheckValue(setting, value));
  return value;
}

absl::Status CheckValue(const Setting& setting, const ConfigValue& value) {
  if (value.index() != setting.default_value.index()) {
    return absl::InvalidArgumentError(
        absl::StrCat(setting.name, " has a value of another type"));
  }
  if (const auto* whole = std::get_if<int64_t>(&value)) {
    TL_RETURN_IF_ERROR(CheckBounds(setting, static_cast<double>(*whole),
                                   absl::StrCat(*whole)));
  } else if (const auto* number = std::get_if<double>(&value)) {
    TL_RETURN_IF_ERROR(CheckBounds(setting, *number, Shortest(*number)));
  } else if (const auto* text = std::get_if<std::string>(&value)) {
    TL_RETURN_IF_ERROR(CheckText(setting, *text));
  } else if (const auto* list = std::get_if<std::vector<std::string>>(&value)) {
    for (const std::string& element : *list) {
      if (element.empty()) {
        return absl::InvalidArgumentError(
            absl::StrCat(setting.name, " has an empty element"));
      }
      TL_RETURN_IF_ERROR(CheckText(setting, element));
    }
  }
  if (!setting.check) return absl::OkStatus();
  return base::Annotate(setting.check(value), setting.name);
}

std::string ToYaml(const ConfigValue& value) {
  if (const bool* truth = std::get_if<bool>(&value)) {
    return *truth ? "true" : "false";
  }
  if (const auto* whole = std::get_if<int64_t>(&value)) {
    return absl::StrCat(*whole);
  }
  if (const auto* number = std::get_if<double>(&value)) {
    return Shortest(*number);
  }
  if (const auto* text = std::get_if<std::string>(&value)) {
    return YamlText(*text);
  }
  const auto& list = std::get<std::vector<std::string>>(value);
  return absl::StrCat("[",
                      absl::StrJoin(list, ", ",
                                    [](std::string* out, const std::string& s) {
                                      absl::StrAppend(out, YamlText(s));
                                    }),
                      "]");
}

std::string ToYamlRedacted(const Setting& setting, const ConfigValue& value) {
  switch (setting.secrecy) {
    case Secrecy::kPublic:
      break;
    case Secrecy::kAddress:
      if (const auto* text = std::get_if<std::string>(&value)) {
        return ToYaml(RedactAddress(*text));
      }
      break;
    case Secrecy::kSecret:
      return value == setting.default_value ? ToYaml(value) : "\"***\"";
  }
  return ToYaml(value);
}

std::string RedactAddress(absl::string_view address) {
  const size_t scheme = address.find("://");
  if (scheme == absl::string_view::npos) return std::string(address);
  const absl::string_view rest = address.substr(scheme + 3);
  const size_t path = std::min(rest.find('/'), rest.size());
  // The last @ before the path: a password may hold one too.
  const size_t at = rest.substr(0, path).rfind('@');
  std::string shown(address.substr(0, scheme + 3));
  if (at != absl::string_view::npos) shown.append("***");
  const absl::string_view visible =
      rest.substr(at == absl::string_view::npos ? 0 : at);
  const size_t query = visible.find_first_of("?#");
  absl::StrAppend(&shown, visible.substr(0, query));
  if (query != absl::string_view::npos) {
    absl::StrAppend(&shown, visible.substr(query, 1), "***");
  }
  return shown;
}

const Setting* FindSetting(const std::vector<Setting>& settings,
                           absl::string_view name) {
  for (const Setting& setting : settings) {
    if (setting.name == name) return &setting;
  }
  return nullptr;
}

std::string NearestName(const std::vector<Setting>& settings,
                        absl::string_view unknown) {
  std::vector<absl::string_view> names;
  names.reserve(settings.size());
  for (const Setting& setting : settings) names.push_back(setting.name);
  return base::NearestName(unknown, names);
}

}  // namespace treeline::config
