#include "server/gateway/gpp_json_field.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/connect_rpc/connect_error.h"

namespace treeline::gateway {

absl::Status JsonField::Wrong(absl::string_view problem) const {
  return connect_rpc::InvalidRequest(path_.empty()
                                         ? std::string(problem)
                                         : absl::StrCat(path_, ": ", problem));
}

absl::StatusOr<std::optional<JsonField>> JsonField::Find(
    const char* name) const {
  if (!value_->is_object()) return Wrong("must be an object");
  const auto found = value_->find(name);
  if (found == value_->end() || found->is_null()) return std::nullopt;
  return JsonField(*found, path_.empty() ? std::string(name)
                                         : absl::StrCat(path_, ".", name));
}

absl::StatusOr<JsonField> JsonField::Get(const char* name) const {
  TL_ASSIGN_OR_RETURN(std::optional<JsonField> field, Find(name));
  if (!field.has_value()) return Wrong(absl::StrCat(name, " is missing"));
  return *std::move(field);
}

absl::StatusOr<std::vector<JsonField>> JsonField::Elements() const {
  if (!value_->is_array()) return Wrong("must be an array");
  std::vector<JsonField> elements;
  for (const nlohmann::json& element : *value_) {
    elements.emplace_back(element,
                          absl::StrCat(path_, "[", elements.size(), "]"));
  }
  return elements;
}

absl::StatusOr<std::vector<JsonField>> JsonField::FindElements(
    const char* name) const {
  TL_ASSIGN_OR_RETURN(const std::optional<JsonField> field, Find(name));
  if (!field.has_value()) return std::vector<JsonField>{};
  return field->Elements();
}

absl::StatusOr<absl::string_view> JsonField::AsString() const {
  if (!value_->is_string()) return Wrong("must be a string");
  return absl::string_view(value_->get_ref<const std::string&>());
}

absl::StatusOr<double> JsonField::AsNumber() const {
  if (!value_->is_number()) return Wrong("must be a number");
  const auto number = value_->get<double>();
  if (!std::isfinite(number)) return Wrong("must be finite");
  return number;
}

absl::StatusOr<std::vector<double>> JsonField::AsNumbers() const {
  TL_ASSIGN_OR_RETURN(const std::vector<JsonField> elements, Elements());
  std::vector<double> numbers;
  for (const JsonField& element : elements) {
    TL_ASSIGN_OR_RETURN(const double number, element.AsNumber());
    numbers.push_back(number);
  }
  return numbers;
}

absl::StatusOr<double> JsonField::GetNumber(const char* name) const {
  TL_ASSIGN_OR_RETURN(const JsonField field, Get(name));
  return field.AsNumber();
}

absl::StatusOr<double> JsonField::NumberOr(const char* name,
                                           double otherwise) const {
  TL_ASSIGN_OR_RETURN(const std::optional<JsonField> field, Find(name));
  return field.has_value() ? field->AsNumber() : otherwise;
}

}  // namespace treeline::gateway
