#include "common/base/installed_file.h"

#include <filesystem>
#include <system_error>
#include <vector>

namespace treeline::base {

namespace fs = std::filesystem;

std::string FindInstalledFile(const std::string& name,
                              const std::string& source_place) {
  std::error_code error;
  std::vector<fs::path> places;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (!error) {
    places.push_back(program.parent_path().parent_path() / "share/treeline" /
                     name);
  }
  places.emplace_back(source_place);
  for (const fs::path& place : places) {
    if (fs::is_regular_file(place, error)) return place.string();
  }
  return "";
}

}  // namespace treeline::base
