#include "common/config/config_file.h"

#include <yaml-cpp/yaml.h>

#include <exception>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/yaml/first_document.h"

namespace treeline::config {
namespace {

// Builds errors that start with the place.
class Place {
 public:
  explicit Place(absl::string_view file) : file_(file) {}

  absl::Status Error(int line, absl::string_view message) const {
    return absl::InvalidArgumentError(
        absl::StrCat(file_, ":", line, ": ", message));
  }
  absl::Status Error(const YAML::Mark& mark, absl::string_view message) const {
    return Error(LineOf(mark), message);
  }
  // yaml-cpp counts from 0, and has -1 for no place at all.
  static int LineOf(const YAML::Mark& mark) {
    return mark.line < 0 ? 1 : mark.line + 1;
  }

 private:
  const std::string file_;
};

std::string Shown(const std::string& text) {
  return absl::CHexEscape(text.substr(0, 100));
}

absl::Status UnknownKey(const std::string& key,
                        const std::vector<Setting>& settings) {
  const std::string nearest = NearestName(settings, key);
  return absl::InvalidArgumentError(absl::StrCat(
      "no setting is called '", Shown(key), "'",
      nearest.empty() ? "" : absl::StrCat("; did you mean '", nearest, "'?")));
}

absl::StatusOr<ConfigValue> ReadList(const Setting& setting,
                                     const YAML::Node& node) {
  std::vector<std::string> elements;
  for (const YAML::Node& element : node) {
    if (!element.IsScalar()) {
      return absl::InvalidArgumentError(
          absl::StrCat(setting.name, ": its elements must be texts"));
    }
    elements.push_back(element.Scalar());
  }
  ConfigValue value(std::move(elements));
  TL_RETURN_IF_ERROR(CheckValue(setting, value));
  return value;
}

absl::StatusOr<ConfigValue> ReadValue(const Setting& setting,
                                      const YAML::Node& node) {
  const bool is_list =
      std::holds_alternative<std::vector<std::string>>(setting.default_value);
  if (node.IsSequence() && is_list) return ReadList(setting, node);
  if (node.IsNull()) {
    return absl::InvalidArgumentError(
        absl::StrCat(setting.name, " has no value"));
  }
  if (!node.IsScalar()) {
    return absl::InvalidArgumentError(absl::StrCat(
        setting.name, " must be ",
        is_list ? "a sequence of texts" : "one value, not several"));
  }
  return ParseValue(setting, node.Scalar());
}

absl::StatusOr<std::map<std::string, FileValue>> ReadMap(
    const YAML::Node& root, const Place& place,
    const std::vector<Setting>& settings) {
  std::map<std::string, FileValue> values;
  if (root.IsNull()) return values;
  if (!root.IsMap()) {
    return place.Error(root.Mark(), "there must be lines of `name: value`");
  }
  for (const auto& entry : root) {
    const YAML::Mark mark = entry.first.Mark();
    if (!entry.first.IsScalar()) {
      return place.Error(mark, "the name of a setting must be a text");
    }
    const std::string& key = entry.first.Scalar();
    const Setting* setting = FindSetting(settings, key);
    if (setting == nullptr) {
      return place.Error(mark, UnknownKey(key, settings).message());
    }
    absl::StatusOr<ConfigValue> value = ReadValue(*setting, entry.second);
    // A sequence that begins on the next line is still this key's.
    if (!value.ok()) return place.Error(mark, value.status().message());
    const int line = Place::LineOf(mark);
    const auto [other, is_new] =
        values.insert({key, FileValue{*std::move(value), line}});
    if (!is_new) {
      return place.Error(mark, absl::StrCat(key,
                                            " stands there twice; also in "
                                            "line ",
                                            other->second.line));
    }
  }
  return values;
}

}  // namespace

absl::StatusOr<std::map<std::string, FileValue>> ParseConfigFile(
    absl::string_view text, absl::string_view name,
    const std::vector<Setting>& settings) {
  const Place place(name);
  if (text.size() > kMaxConfigFileBytes) {
    return place.Error(1, absl::StrCat("a configuration of more than ",
                                       kMaxConfigFileBytes, " bytes"));
  }
  // It would end the text for yaml-cpp, in silence.
  if (text.find('\0') != absl::string_view::npos) {
    return place.Error(1, "a zero byte: this is not a text");
  }
  try {
    const yaml::FirstDocument document =
        yaml::LoadFirstDocument(std::string(text));
    if (!document.node) return std::map<std::string, FileValue>();
    if (document.second) {
      return place.Error(*document.second,
                         "a second document; there may be one only");
    }
    return ReadMap(*document.node, place, settings);
  } catch (const YAML::Exception& error) {
    return place.Error(error.mark, absl::StrCat("not YAML: ", error.msg));
  } catch (const std::exception& error) {
    return place.Error(1, absl::StrCat("not YAML: ", error.what()));
  }
}

absl::StatusOr<std::map<std::string, FileValue>> ReadConfigFile(
    const std::string& path, const std::vector<Setting>& settings) {
  TL_ASSIGN_OR_RETURN(const std::string text,
                      base::ReadFile(path, kMaxConfigFileBytes));
  return ParseConfigFile(text, path, settings);
}

}  // namespace treeline::config
