// A folder that is there with all that belongs into it, or not at all.
#ifndef SERVER_TOOLS_OUTPUT_FOLDER_H_
#define SERVER_TOOLS_OUTPUT_FOLDER_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace treeline::tools {

// Removed with all that is in it when destroyed, unless it was kept. It has its
// name from the beginning, because models and lists name files in it.
class OutputFolder {
 public:
  // ALREADY_EXISTS: it is there and not empty. Else the system's reason.
  static absl::StatusOr<OutputFolder> Create(const std::string& path);
  OutputFolder(OutputFolder&& other) noexcept;
  OutputFolder& operator=(OutputFolder&&) = delete;
  ~OutputFolder();

  const std::string& path() const { return path_; }
  // What `name` is called from outside.
  std::string Path(const std::string& name) const;
  void Keep() { is_kept_ = true; }

 private:
  explicit OutputFolder(std::string path) : path_(std::move(path)) {}

  std::string path_;
  bool is_kept_ = false;
};

// Whether a file could be made at `path`, whose folder need not be there yet.
absl::Status CheckFolderCanBeMade(const std::string& path);

}  // namespace treeline::tools

#endif  // SERVER_TOOLS_OUTPUT_FOLDER_H_
