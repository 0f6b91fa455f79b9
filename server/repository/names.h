// Names of scenes and of their versions.
#ifndef SERVER_REPOSITORY_NAMES_H_
#define SERVER_REPOSITORY_NAMES_H_

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace treeline::repository {

inline constexpr size_t kLongestName = 128;

// Whether `name` is 1 to 128 of A-Z a-z 0-9 . _ - without a dot in front: it is
// safe as the name of a folder, and in a log line.
bool IsValidName(absl::string_view name);

// INVALID_ARGUMENT starting with `field` unless IsValidName(name).
absl::Status CheckName(absl::string_view field, absl::string_view name);

// Whether version a is older than b. Versions of digits alone are older than
// all others and compare as numbers of any length ("9" < "10"); the others
// compare byte by byte ("2026-01-31" < "2026-02-01"). Numbers that are equal
// ("7" and "07") compare byte by byte too, so that the order is total.
bool VersionIsOlder(absl::string_view a, absl::string_view b);

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_NAMES_H_
