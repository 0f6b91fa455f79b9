// JSON that somebody sent: never trusted to have what it should.
//
// Every error is INVALID_ARGUMENT, names `where` (a file, or a file and an
// entry of it) and says what was expected there.
#ifndef SERVER_TOOLS_CAPTURE_JSON_TEXT_H_
#define SERVER_TOOLS_CAPTURE_JSON_TEXT_H_

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::capture {

using Json = nlohmann::json;

// An object of at most 32 levels.
absl::StatusOr<Json> ParseJsonObject(absl::string_view text,
                                     const std::string& where);
absl::StatusOr<Json> ReadJsonObject(const std::string& path);

// A finite number. The second: nullopt if there is none of that name.
absl::StatusOr<double> NumberOf(const Json& object, const char* name,
                                const std::string& where);
absl::StatusOr<std::optional<double>> OptionalNumberOf(
    const Json& object, const char* name, const std::string& where);
// A whole number from 1 to 16384: the side of a picture.
absl::StatusOr<int> SideOf(const Json& object, const char* name,
                           const std::string& where);

// An array of that many finite numbers.
absl::Status NumbersOf(const Json& value, const char* name,
                       const std::string& where, std::span<double> numbers);

// A 4 x 4 matrix as rows of rows, or 3 x 4: the last row is 0 0 0 1 then.
absl::StatusOr<std::array<double, 16>> MatrixRowsOf(const Json& object,
                                                    const char* name,
                                                    const std::string& where);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_JSON_TEXT_H_
