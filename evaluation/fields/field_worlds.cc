#include "evaluation/fields/field_worlds.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/folder.h"
#include "simulation/worlds/world.h"

namespace treeline::fields {
namespace {

// Numbers in names count as such.
bool IsBefore(const std::string& a, const std::string& b) {
  size_t i = 0;
  size_t j = 0;
  const auto digits = [](const std::string& text, size_t from) {
    size_t to = from;
    while (to < text.size() &&
           absl::ascii_isdigit(static_cast<unsigned char>(text[to]))) {
      ++to;
    }
    return text.substr(from, to - from);
  };
  while (i < a.size() && j < b.size()) {
    const std::string left = digits(a, i);
    const std::string right = digits(b, j);
    if (!left.empty() && !right.empty()) {
      if (left.size() != right.size()) return left.size() < right.size();
      if (left != right) return left < right;
      i += left.size();
      j += right.size();
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
    }
  }
  return a.size() - i < b.size() - j;
}

}  // namespace

absl::StatusOr<std::vector<std::string>> WorldsCalled(const std::string& name) {
  std::error_code error;
  if (!std::filesystem::is_directory(name, error)) {
    return std::vector<std::string>{name};
  }
  std::vector<std::string> worlds;
  for (const std::string& file : base::SortedNamesIn(name)) {
    if (worlds::IsGazeboWorld(file) || absl::EndsWith(file, ".yaml")) {
      worlds.push_back(absl::StrCat(name, "/", file));
    }
  }
  if (worlds.empty()) {
    return absl::NotFoundError(absl::StrCat(
        "there is no file of a world (.world, .sdf, .yaml) in ", name));
  }
  std::ranges::sort(worlds, IsBefore);
  return worlds;
}

}  // namespace treeline::fields
