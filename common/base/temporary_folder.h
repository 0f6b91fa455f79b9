// A folder for what is needed for a while.
#ifndef COMMON_BASE_TEMPORARY_FOLDER_H_
#define COMMON_BASE_TEMPORARY_FOLDER_H_

#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"

namespace treeline::base {

// In the system's folder for such (TMPDIR); removed with all that is in it.
class TemporaryFolder {
 public:
  // prefix: what its name begins with. UNAVAILABLE.
  static absl::StatusOr<TemporaryFolder> Make(absl::string_view prefix) {
    std::error_code error;
    const auto parent = std::filesystem::temp_directory_path(error);
    std::string path = absl::StrCat(parent.string(), "/", prefix, "-XXXXXX");
    if (error || mkdtemp(path.data()) == nullptr) {
      return absl::UnavailableError(
          absl::StrCat(path, ": no temporary folder can be made there"));
    }
    return TemporaryFolder(std::move(path));
  }
  TemporaryFolder(TemporaryFolder&& other) noexcept
      : path_(std::exchange(other.path_, {})) {}
  TemporaryFolder& operator=(TemporaryFolder&&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }

  const std::string& path() const { return path_; }

 private:
  explicit TemporaryFolder(std::string path) : path_(std::move(path)) {}

  std::string path_;
};

}  // namespace treeline::base

#endif  // COMMON_BASE_TEMPORARY_FOLDER_H_
