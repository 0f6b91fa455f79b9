#include "nav_agent/app/bridge/ros_parameters.h"

#include <algorithm>
#include <span>
#include <utility>
#include <variant>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "common/base/status_macros.h"

namespace treeline::bridge_app {
namespace {

constexpr char kParameters[] = "ros__parameters";
// Namespaces within each other, and parameters within each other.
constexpr int kMaxDepth = 16;

bool IsTruth(const config::Setting& setting) {
  return std::holds_alternative<bool>(setting.default_value);
}

// All of YAML's words for true and false; others as they are.
std::string TruthText(const std::string& scalar) {
  const std::string word = absl::AsciiStrToLower(scalar);
  for (const char* yes : {"true", "yes", "on", "y"}) {
    if (word == yes) return "true";
  }
  for (const char* no : {"false", "no", "off", "n"}) {
    if (word == no) return "false";
  }
  return scalar;
}

// What every node of ROS has, so that `ros2 param dump` writes it.
bool IsOfAnyNode(absl::string_view name) {
  return absl::StartsWith(name, "qos_overrides.") ||
         name == "start_type_description_service";
}

bool PartsMatch(std::span<const absl::string_view> pattern,
                std::span<const absl::string_view> name) {
  if (pattern.empty()) return name.empty();
  if (pattern[0] == "**") {
    return PartsMatch(pattern.subspan(1), name) ||
           (!name.empty() && PartsMatch(pattern, name.subspan(1)));
  }
  return !name.empty() && (pattern[0] == "*" || pattern[0] == name[0]) &&
         PartsMatch(pattern.subspan(1), name.subspan(1));
}

std::vector<absl::string_view> PartsOf(absl::string_view name) {
  return absl::StrSplit(name, '/', absl::SkipEmpty());
}

class ParameterReader {
 public:
  ParameterReader(const std::string& path, absl::string_view node,
                  const std::vector<config::Setting>& settings)
      : path_(path), node_(node), settings_(settings) {}

  // Sections within `names`, which are for `pattern`.
  absl::Status ReadNodes(const yaml::YamlNode& names,
                         const std::string& pattern, int depth) {
    if (!names.IsMap() || depth > kMaxDepth) {
      return names.Error(
          absl::StrCat("this is no parameter file of ROS 2: NODE, below it ",
                       kParameters, ", and below that NAME: VALUE"));
    }
    for (const std::string& key : names.Keys()) {
      TL_ASSIGN_OR_RETURN(const yaml::YamlNode below, names.Get(key));
      if (key != kParameters) {
        TL_RETURN_IF_ERROR(ReadNodes(
            below,
            absl::StrCat(pattern, absl::StartsWith(key, "/") ? "" : "/", key),
            depth + 1));
        continue;
      }
      sections_.push_back(pattern.empty() ? "/" : pattern);
      if (!IsMeantBy(pattern, node_)) {
        NoteNamesake(below, pattern);
        continue;
      }
      is_meant_ = true;
      is_for_several_ = absl::StrContains(pattern, "*");
      TL_RETURN_IF_ERROR(ReadParameters(below, "", 0));
    }
    return absl::OkStatus();
  }

  RosParameters Finish() {
    if (!is_meant_) {
      made_.notes.push_back(absl::StrCat(
          path_, ": nothing in it is for ", node_, "; there is ",
          sections_.empty() ? "nothing at all"
                            : absl::CHexEscape(absl::StrJoin(sections_, ", ")),
          " (`/**:` is for every node)"));
    }
    return std::move(made_);
  }

 private:
  // A node of the same name in another namespace is another node.
  void NoteNamesake(const yaml::YamlNode& section, const std::string& pattern) {
    const std::vector<absl::string_view> parts = PartsOf(pattern);
    const std::vector<absl::string_view> own = PartsOf(node_);
    if (parts.empty() || own.empty() || parts.back() != own.back()) return;
    made_.notes.push_back(absl::StrCat(
        section
            .Error(absl::StrCat(absl::CHexEscape(pattern),
                                " is not this node, ", node_, ": left out"))
            .message(),
        " (/**/", own.back(), " is it in any namespace)"));
  }

  absl::Status ReadParameters(const yaml::YamlNode& parameters,
                              const std::string& prefix, int depth) {
    if (!parameters.IsMap() || depth > kMaxDepth) {
      return parameters.Error(
          absl::StrCat(kParameters, " must have NAME: VALUE below it"));
    }
    for (const std::string& key : parameters.Keys()) {
      TL_ASSIGN_OR_RETURN(const yaml::YamlNode value, parameters.Get(key));
      const std::string name = absl::StrCat(prefix, key);
      if (value.IsMap()) {
        TL_RETURN_IF_ERROR(
            ReadParameters(value, absl::StrCat(name, "."), depth + 1));
      } else {
        TL_RETURN_IF_ERROR(Read(name, value));
      }
    }
    return absl::OkStatus();
  }

  absl::Status Read(const std::string& name, const yaml::YamlNode& value) {
    const config::Setting* setting = config::FindSetting(settings_, name);
    if (setting == nullptr) {
      const absl::Status unknown =
          value.Error(UnknownParameter(settings_, name).message());
      if (!is_for_several_ && !IsOfAnyNode(name)) return unknown;
      made_.notes.push_back(absl::StrCat(unknown.message(), " (left out)"));
      return absl::OkStatus();
    }
    TL_ASSIGN_OR_RETURN(std::string text, ParameterText(*setting, value));
    const absl::Status fits = config::ParseValue(*setting, text).status();
    if (!fits.ok()) return value.Error(fits.message());
    made_.values[name] = {.text = std::move(text),
                          .origin = absl::StrCat(path_, ":", value.line())};
    return absl::OkStatus();
  }

  const std::string& path_;
  const absl::string_view node_;
  const std::vector<config::Setting>& settings_;
  RosParameters made_;
  std::vector<std::string> sections_;
  bool is_meant_ = false;
  // Of the section that is read.
  bool is_for_several_ = false;
};

}  // namespace

absl::StatusOr<std::string> ParameterText(const config::Setting& setting,
                                          const yaml::YamlNode& value) {
  if (!value.IsSequence()) {
    TL_ASSIGN_OR_RETURN(const std::string scalar, value.AsText());
    return IsTruth(setting) ? TruthText(scalar) : scalar;
  }
  TL_ASSIGN_OR_RETURN(const std::vector<yaml::YamlNode> elements,
                      value.Elements());
  std::vector<std::string> texts;
  for (const yaml::YamlNode& element : elements) {
    TL_ASSIGN_OR_RETURN(texts.emplace_back(), element.AsText());
  }
  return absl::StrJoin(texts, ",");
}

absl::Status UnknownParameter(const std::vector<config::Setting>& settings,
                              absl::string_view name) {
  const std::string nearest = config::NearestName(settings, name);
  return absl::InvalidArgumentError(absl::StrCat(
      "there is no parameter '", absl::CHexEscape(name), "'",
      nearest.empty() ? "; `treeline-agent bridge --print-config` shows all"
                      : absl::StrCat("; did you mean '", nearest, "'?")));
}

bool IsMeantBy(absl::string_view pattern, absl::string_view node) {
  std::vector<absl::string_view> parts = PartsOf(pattern);
  // Several in a row say no more than one, but each doubles what is tried.
  parts.erase(std::unique(parts.begin(), parts.end(),
                          [](absl::string_view x, absl::string_view y) {
                            return x == "**" && y == "**";
                          }),
              parts.end());
  return PartsMatch(parts, PartsOf(node));
}

absl::StatusOr<RosParameters> RosParametersOf(
    const yaml::YamlNode& root, const std::string& path, absl::string_view node,
    const std::vector<config::Setting>& settings) {
  ParameterReader reader(path, node, settings);
  TL_RETURN_IF_ERROR(reader.ReadNodes(root, "", 0));
  return reader.Finish();
}

absl::StatusOr<RosParameters> ReadRosParameters(
    const std::string& path, absl::string_view node,
    const std::vector<config::Setting>& settings) {
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode root, yaml::YamlNode::Read(path));
  return RosParametersOf(root, path, node, settings);
}

}  // namespace treeline::bridge_app
