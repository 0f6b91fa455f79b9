// A value in a JSON document that knows its path, for messages that name it.
#ifndef SERVER_GATEWAY_GPP_JSON_FIELD_H_
#define SERVER_GATEWAY_GPP_JSON_FIELD_H_

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::gateway {

// Refers to a document that must outlive it.
class JsonField {
 public:
  JsonField(const nlohmann::json& value, std::string path)
      : value_(&value), path_(std::move(path)) {}

  const std::string& path() const { return path_; }

  // INVALID_ARGUMENT naming this field.
  absl::Status Wrong(absl::string_view problem) const;

  // A field of this object; null counts as absent. INVALID_ARGUMENT: this is
  // no object.
  absl::StatusOr<std::optional<JsonField>> Find(const char* name) const;
  // The same for one that must be there.
  absl::StatusOr<JsonField> Get(const char* name) const;
  // The elements of this array.
  absl::StatusOr<std::vector<JsonField>> Elements() const;
  // The elements of the array of this name; none if it is absent.
  absl::StatusOr<std::vector<JsonField>> FindElements(const char* name) const;

  // Refers to the document.
  absl::StatusOr<absl::string_view> AsString() const;
  // Finite.
  absl::StatusOr<double> AsNumber() const;
  absl::StatusOr<std::vector<double>> AsNumbers() const;
  bool IsTrue() const { return value_->is_boolean() && value_->get<bool>(); }

  // Field of this name, as a number.
  absl::StatusOr<double> GetNumber(const char* name) const;
  // `otherwise` if it is absent.
  absl::StatusOr<double> NumberOr(const char* name, double otherwise) const;

 private:
  const nlohmann::json* value_;
  std::string path_;
};

}  // namespace treeline::gateway

#endif  // SERVER_GATEWAY_GPP_JSON_FIELD_H_
