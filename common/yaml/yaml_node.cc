#include "common/yaml/yaml_node.h"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <exception>
#include <set>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/base/file.h"
#include "common/base/nearest_name.h"
#include "common/base/status_macros.h"
#include "common/yaml/first_document.h"

namespace treeline::yaml {
namespace {

int LineOf(const YAML::Mark& mark) {
  // yaml-cpp counts from 0, and has -1 for no place at all.
  return mark.line < 0 ? 1 : mark.line + 1;
}

absl::Status ErrorAt(absl::string_view file, int line,
                     absl::string_view message) {
  return absl::InvalidArgumentError(
      absl::StrCat(file, ":", line, ": ", message));
}

std::string Shown(absl::string_view text) {
  return absl::CHexEscape(text.substr(0, 100));
}

}  // namespace

struct YamlNode::Impl {
  std::shared_ptr<const std::string> file;
  YAML::Node node;
  // What the file calls this value: "size" or "size[2]"; empty for all of it.
  std::string name;

  // The value of `key`; undefined if there is none. Does not touch the tree,
  // as operator[] of yaml-cpp does.
  YAML::Node Find(absl::string_view key) const {
    if (node.IsMap()) {
      for (const auto& entry : node) {
        if (entry.first.IsScalar() && entry.first.Scalar() == key) {
          return entry.second;
        }
      }
    }
    return YAML::Node(YAML::NodeType::Undefined);
  }
};

YamlNode::YamlNode(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}

absl::StatusOr<YamlNode> YamlNode::Parse(absl::string_view text,
                                         absl::string_view name) {
  if (text.size() > kMaxBytes) {
    return ErrorAt(name, 1,
                   absl::StrCat("more than ", kMaxBytes, " bytes of YAML"));
  }
  // It would end the text for yaml-cpp, in silence.
  if (text.find('\0') != absl::string_view::npos) {
    return ErrorAt(name, 1, "a zero byte: this is not a text");
  }
  try {
    const FirstDocument document = LoadFirstDocument(std::string(text));
    if (!document.node) return ErrorAt(name, 1, "there is nothing in it");
    if (document.second) {
      return ErrorAt(name, LineOf(*document.second),
                     "a second document; there may be one only");
    }
    return YamlNode(std::make_shared<const Impl>(
        Impl{.file = std::make_shared<const std::string>(name),
             .node = *document.node,
             .name = ""}));
  } catch (const YAML::Exception& error) {
    return ErrorAt(name, LineOf(error.mark),
                   absl::StrCat("not YAML: ", error.msg));
  } catch (const std::exception& error) {
    return ErrorAt(name, 1, absl::StrCat("not YAML: ", error.what()));
  }
}

absl::StatusOr<YamlNode> YamlNode::Read(const std::string& path) {
  TL_ASSIGN_OR_RETURN(const std::string text, base::ReadFile(path, kMaxBytes));
  return Parse(text, path);
}

absl::Status YamlNode::Error(absl::string_view message) const {
  return ErrorAt(*impl_->file, line(), message);
}

int YamlNode::line() const { return LineOf(impl_->node.Mark()); }

absl::Status YamlNode::CheckKeys(
    std::initializer_list<absl::string_view> known) const {
  if (!impl_->node.IsMap()) {
    return Error(absl::StrCat(
        impl_->name.empty() ? "the file" : absl::StrCat("'", impl_->name, "'"),
        " must hold names and values: ", absl::StrJoin(known, ", ")));
  }
  std::set<std::string> seen;
  for (const auto& entry : impl_->node) {
    const int line = LineOf(entry.first.Mark());
    if (!entry.first.IsScalar()) {
      return ErrorAt(*impl_->file, line, "a name must be a text");
    }
    const std::string& key = entry.first.Scalar();
    if (!seen.insert(key).second) {
      return ErrorAt(*impl_->file, line,
                     absl::StrCat("'", Shown(key), "' stands there twice"));
    }
    bool is_known = false;
    for (const absl::string_view name : known) is_known |= name == key;
    if (is_known) continue;
    const std::string nearest =
        base::NearestName(key, std::span(known.begin(), known.size()));
    return ErrorAt(
        *impl_->file, line,
        absl::StrCat(
            "unknown key '", Shown(key), "'",
            nearest.empty()
                ? absl::StrCat("; there are ", absl::StrJoin(known, ", "))
                : absl::StrCat("; did you mean '", nearest, "'?")));
  }
  return absl::OkStatus();
}

std::vector<std::string> YamlNode::Keys() const {
  std::vector<std::string> keys;
  if (!impl_->node.IsMap()) return keys;
  for (const auto& entry : impl_->node) {
    if (entry.first.IsScalar()) keys.push_back(entry.first.Scalar());
  }
  return keys;
}

bool YamlNode::Has(absl::string_view key) const {
  return impl_->Find(key).IsDefined();
}

absl::StatusOr<YamlNode> YamlNode::Get(absl::string_view key) const {
  const YAML::Node value = impl_->Find(key);
  if (!value.IsDefined()) {
    return Error(absl::StrCat(
        "there is no '", key, "'",
        impl_->name.empty() ? "" : absl::StrCat(" in '", impl_->name, "'")));
  }
  return YamlNode(std::make_shared<const Impl>(
      Impl{.file = impl_->file, .node = value, .name = std::string(key)}));
}

absl::StatusOr<double> YamlNode::Number(absl::string_view key, double min,
                                        double max) const {
  TL_ASSIGN_OR_RETURN(const YamlNode value, Get(key));
  return value.AsNumber(min, max);
}

absl::StatusOr<int64_t> YamlNode::Integer(absl::string_view key, int64_t min,
                                          int64_t max) const {
  TL_ASSIGN_OR_RETURN(const YamlNode value, Get(key));
  TL_ASSIGN_OR_RETURN(const std::string text, value.AsText());
  int64_t number = 0;
  if (!absl::SimpleAtoi(text, &number)) {
    return value.Error(
        absl::StrCat(key, ": '", Shown(text), "' is not a whole number"));
  }
  if (number < min || number > max) {
    return value.Error(
        absl::StrCat(key, " is ", number, "; it must be ", min, "..", max));
  }
  return number;
}

absl::StatusOr<std::string> YamlNode::Text(absl::string_view key) const {
  TL_ASSIGN_OR_RETURN(const YamlNode value, Get(key));
  return value.AsText();
}

absl::StatusOr<bool> YamlNode::Boolean(absl::string_view key) const {
  TL_ASSIGN_OR_RETURN(const int chosen, Choice(key, {"false", "true"}));
  return chosen == 1;
}

absl::StatusOr<int> YamlNode::Choice(
    absl::string_view key,
    std::initializer_list<absl::string_view> choices) const {
  TL_ASSIGN_OR_RETURN(const YamlNode value, Get(key));
  TL_ASSIGN_OR_RETURN(const std::string text, value.AsText());
  int index = 0;
  for (const absl::string_view choice : choices) {
    if (choice == text) return index;
    ++index;
  }
  return value.Error(absl::StrCat(key, " is '", Shown(text),
                                  "'; it must be one of ",
                                  absl::StrJoin(choices, ", ")));
}

absl::StatusOr<std::vector<double>> YamlNode::Numbers(absl::string_view key,
                                                      size_t count, double min,
                                                      double max) const {
  TL_ASSIGN_OR_RETURN(const YamlNode value, Get(key));
  return value.AsNumbers(count, min, max);
}

absl::StatusOr<std::vector<YamlNode>> YamlNode::Items(
    absl::string_view key) const {
  if (!Has(key)) return std::vector<YamlNode>();
  TL_ASSIGN_OR_RETURN(const YamlNode value, Get(key));
  return value.Elements();
}

absl::StatusOr<double> YamlNode::NumberOr(absl::string_view key,
                                          double otherwise, double min,
                                          double max) const {
  if (!Has(key)) return otherwise;
  return Number(key, min, max);
}

absl::StatusOr<int64_t> YamlNode::IntegerOr(absl::string_view key,
                                            int64_t otherwise, int64_t min,
                                            int64_t max) const {
  if (!Has(key)) return otherwise;
  return Integer(key, min, max);
}

absl::StatusOr<std::string> YamlNode::TextOr(
    absl::string_view key, absl::string_view otherwise) const {
  if (!Has(key)) return std::string(otherwise);
  return Text(key);
}

absl::StatusOr<bool> YamlNode::BooleanOr(absl::string_view key,
                                         bool otherwise) const {
  if (!Has(key)) return otherwise;
  return Boolean(key);
}

bool YamlNode::IsMap() const { return impl_->node.IsMap(); }
bool YamlNode::IsSequence() const { return impl_->node.IsSequence(); }

absl::StatusOr<std::vector<YamlNode>> YamlNode::Elements() const {
  if (!impl_->node.IsSequence()) {
    return Error(absl::StrCat("'", impl_->name, "' must be a sequence"));
  }
  std::vector<YamlNode> elements;
  for (const YAML::Node& element : impl_->node) {
    elements.push_back(YamlNode(std::make_shared<const Impl>(
        Impl{.file = impl_->file,
             .node = element,
             .name = absl::StrCat(impl_->name, "[", elements.size(), "]")})));
  }
  return elements;
}

absl::StatusOr<std::vector<double>> YamlNode::AsNumbers(size_t count,
                                                        double min,
                                                        double max) const {
  if (!impl_->node.IsSequence() || impl_->node.size() != count) {
    return Error(absl::StrCat("'", impl_->name, "' must be a sequence of ",
                              count, " numbers"));
  }
  TL_ASSIGN_OR_RETURN(const std::vector<YamlNode> elements, Elements());
  std::vector<double> numbers;
  for (const YamlNode& element : elements) {
    TL_ASSIGN_OR_RETURN(const double number, element.AsNumber(min, max));
    numbers.push_back(number);
  }
  return numbers;
}

absl::StatusOr<double> YamlNode::AsNumber(double min, double max) const {
  TL_ASSIGN_OR_RETURN(const std::string text, AsText());
  double number = 0;
  if (!absl::SimpleAtod(text, &number) || !std::isfinite(number)) {
    return Error(
        absl::StrCat(impl_->name, ": '", Shown(text), "' is not a number"));
  }
  if (number < min || number > max) {
    return Error(absl::StrCat(impl_->name, " is ", number, "; it must be ", min,
                              "..", max));
  }
  return number;
}

absl::StatusOr<std::string> YamlNode::AsText() const {
  if (!impl_->node.IsScalar()) {
    return Error(absl::StrCat("'", impl_->name, "' must be one value"));
  }
  return impl_->node.Scalar();
}

}  // namespace treeline::yaml
