#include "server/tools/capture/json_text.h"

#include <cmath>
#include <exception>
#include <nlohmann/json.hpp>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"

namespace treeline::capture {
namespace {

constexpr uint64_t kMaxJsonBytes = 128u << 20;
constexpr int kMaxLevels = 32;
constexpr int kMaxSide_px = 16384;

// How deep brackets are nested outside of strings.
int LevelsOf(absl::string_view text) {
  int level = 0;
  int deepest = 0;
  bool in_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string && c == '\\') {
      ++i;
    } else if (c == '"') {
      in_string = !in_string;
    } else if (!in_string && (c == '{' || c == '[')) {
      deepest = std::max(deepest, ++level);
    } else if (!in_string && (c == '}' || c == ']')) {
      --level;
    }
  }
  return deepest;
}

absl::Status Expected(const std::string& where, const char* name,
                      absl::string_view what) {
  return absl::InvalidArgumentError(
      absl::StrCat(where, ": \"", name, "\" must be ", what));
}

absl::Status Missing(const std::string& where, const char* name) {
  return absl::InvalidArgumentError(
      absl::StrCat(where, ": has no \"", name, "\""));
}

}  // namespace

absl::StatusOr<Json> ParseJsonObject(absl::string_view text,
                                     const std::string& where) {
  if (LevelsOf(text) > kMaxLevels) {
    return absl::InvalidArgumentError(absl::StrCat(
        where, ": is nested more than ", kMaxLevels, " levels deep"));
  }
  try {
    Json json = Json::parse(text.begin(), text.end());
    if (json.is_object()) return json;
  } catch (const std::exception& error) {
    return absl::InvalidArgumentError(
        absl::StrCat(where, ": is no JSON: ", error.what()));
  }
  return absl::InvalidArgumentError(
      absl::StrCat(where, ": is JSON, but no object"));
}

absl::StatusOr<Json> ReadJsonObject(const std::string& path) {
  TL_ASSIGN_OR_RETURN(const std::string text,
                      base::ReadFile(path, kMaxJsonBytes));
  return ParseJsonObject(text, path);
}

absl::StatusOr<std::optional<double>> OptionalNumberOf(
    const Json& object, const char* name, const std::string& where) {
  const auto found = object.find(name);
  if (found == object.end() || found->is_null()) return std::nullopt;
  if (!found->is_number() || !std::isfinite(found->get<double>())) {
    return Expected(where, name, "a finite number");
  }
  return found->get<double>();
}

absl::StatusOr<double> NumberOf(const Json& object, const char* name,
                                const std::string& where) {
  TL_ASSIGN_OR_RETURN(const std::optional<double> number,
                      OptionalNumberOf(object, name, where));
  if (!number) return Missing(where, name);
  return *number;
}

absl::StatusOr<int> SideOf(const Json& object, const char* name,
                           const std::string& where) {
  TL_ASSIGN_OR_RETURN(const double number, NumberOf(object, name, where));
  if (!(number >= 1) || !(number <= kMaxSide_px) ||
      number != std::floor(number)) {
    return Expected(where, name,
                    absl::StrCat("a whole number from 1 to ", kMaxSide_px));
  }
  return static_cast<int>(number);
}

absl::Status NumbersOf(const Json& value, const char* name,
                       const std::string& where, std::span<double> numbers) {
  const std::string what =
      absl::StrCat("an array of ", numbers.size(), " finite numbers");
  if (!value.is_array() || value.size() != numbers.size()) {
    return Expected(where, name, what);
  }
  for (size_t i = 0; i < numbers.size(); ++i) {
    if (!value[i].is_number()) return Expected(where, name, what);
    numbers[i] = value[i].get<double>();
    if (!std::isfinite(numbers[i])) return Expected(where, name, what);
  }
  return absl::OkStatus();
}

absl::StatusOr<std::array<double, 16>> MatrixRowsOf(const Json& object,
                                                    const char* name,
                                                    const std::string& where) {
  const auto found = object.find(name);
  if (found == object.end()) return Missing(where, name);
  if (!found->is_array() || (found->size() != 3 && found->size() != 4)) {
    return Expected(where, name, "3 or 4 rows of 4 numbers");
  }
  std::array<double, 16> matrix{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
  for (size_t row = 0; row < found->size(); ++row) {
    TL_RETURN_IF_ERROR(NumbersOf((*found)[row], name, where,
                                 std::span(matrix).subspan(4 * row, 4)));
  }
  return matrix;
}

}  // namespace treeline::capture
