#include "server/tools/output_folder.h"

#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"

namespace treeline::tools {
namespace {

namespace fs = std::filesystem;

}  // namespace

absl::StatusOr<OutputFolder> OutputFolder::Create(const std::string& path) {
  std::string trimmed = path;
  while (trimmed.size() > 1 && trimmed.back() == '/') trimmed.pop_back();
  std::error_code error;
  const fs::file_status status = fs::status(trimmed, error);
  if (status.type() != fs::file_type::not_found &&
      !(fs::is_directory(status) && fs::is_empty(trimmed, error) && !error)) {
    return absl::AlreadyExistsError(
        absl::StrCat(trimmed,
                     " is there already; remove it, or choose another folder "
                     "with --output"));
  }
  fs::create_directories(trimmed, error);
  if (error) {
    return absl::ErrnoToStatus(error.value(),
                               absl::StrCat("creating folder ", trimmed));
  }
  return OutputFolder(std::move(trimmed));
}

OutputFolder::OutputFolder(OutputFolder&& other) noexcept
    : path_(std::exchange(other.path_, "")), is_kept_(other.is_kept_) {}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  if (!path_.empty() && !is_kept_) fs::remove_all(path_, ignored);
}

std::string OutputFolder::Path(const std::string& name) const {
  return absl::StrCat(path_, "/", name);
}

absl::Status CheckFolderCanBeMade(const std::string& path) {
  fs::path at = path.empty() ? "." : path;
  std::error_code error;
  while (!fs::exists(at, error) && at.has_parent_path() &&
         at.parent_path() != at) {
    at = at.parent_path();
  }
  if (!fs::exists(at, error)) at = ".";
  if (!fs::is_directory(at, error)) {
    return absl::FailedPreconditionError(
        absl::StrCat(path, ": ", at.string(), " is no folder"));
  }
  if (access(at.c_str(), W_OK | X_OK) == 0) return absl::OkStatus();
  return absl::ErrnoToStatus(errno,
                             absl::StrCat("writing below ", at.string()));
}

}  // namespace treeline::tools
