// Models in a folder of this machine.
#ifndef SERVER_REPOSITORY_FOLDER_SOURCE_H_
#define SERVER_REPOSITORY_FOLDER_SOURCE_H_

#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/repository/model_source.h"

namespace treeline::repository {

// ROOT/<scene>/<version>/model.treeline and ROOT/<scene>/scene.json. Entries
// whose names are not valid (see names.h), such as ".2.tmp", and folders
// without a model file are passed over; so is a scene's folder that cannot be
// read. Links are followed. Thread-safe.
class FolderSource final : public ModelSource {
 public:
  // Nothing is read yet.
  explicit FolderSource(std::string root);

  // NOT_FOUND, PERMISSION_DENIED and so on if the root cannot be read.
  absl::StatusOr<SourceListing> List() override;
  // The file where it lies, for both. NOT_FOUND if it has gone.
  absl::StatusOr<std::string> LocalPath(const ModelRef& model) override;
  absl::StatusOr<std::string> Fetch(const ModelRef& model,
                                    const std::stop_token& stop) override;

 private:
  const std::string root_;
};

// Files of models (*.treeline) below `root` that no source lists, relative to
// it: not named <scene>/<version>/model.treeline, or with names that are not
// valid. Hidden ones, which are on their way, and deeper ones are not looked
// at. At most `limit`, in order of their names.
std::vector<std::string> MisplacedModels(const std::string& root, size_t limit);

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_FOLDER_SOURCE_H_
