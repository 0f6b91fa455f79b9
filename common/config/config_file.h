// Settings from a YAML file.
#ifndef COMMON_CONFIG_CONFIG_FILE_H_
#define COMMON_CONFIG_CONFIG_FILE_H_

#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/config/setting.h"

namespace treeline::config {

// Files above this are not configurations.
inline constexpr size_t kMaxConfigFileBytes = size_t{1} << 20;

struct FileValue {
  ConfigValue value = false;
  // From 1.
  int line = 0;
};

// The settings that a YAML text states, by name: one map of names to scalars,
// or to sequences of scalars where the setting is a list. `name` is what errors
// call the file. An empty text states nothing. INVALID_ARGUMENT, with
// "NAME:LINE: " in front: not YAML, more than one document, a key that is not
// known (with the nearest one that is) or that stands there twice, a value of
// another type or out of bounds. Safe on any bytes.
absl::StatusOr<std::map<std::string, FileValue>> ParseConfigFile(
    absl::string_view text, absl::string_view name,
    const std::vector<Setting>& settings);

// The same of the file at `path`. NOT_FOUND, PERMISSION_DENIED and so on name
// it.
absl::StatusOr<std::map<std::string, FileValue>> ReadConfigFile(
    const std::string& path, const std::vector<Setting>& settings);

}  // namespace treeline::config

#endif  // COMMON_CONFIG_CONFIG_FILE_H_
