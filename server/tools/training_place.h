// Where a scene's frames come from and its model goes to.
#ifndef SERVER_TOOLS_TRAINING_PLACE_H_
#define SERVER_TOOLS_TRAINING_PLACE_H_

#include <string>

#include "absl/status/statusor.h"

namespace treeline::tools {

// What the map bundle in `folder` calls its scene
// (docs/reference/map-bundle.md). NOT_FOUND if no complete bundle is there,
// INVALID_ARGUMENT with file and line if its bundle.yaml names none.
absl::StatusOr<std::string> SceneOfMapBundle(const std::string& folder);

// REPOSITORY/SCENE/VERSION/model.treeline, one version above all that are
// there, so that servers choose it. Its folder is made. INVALID_ARGUMENT if
// there is no name.
absl::StatusOr<std::string> NextModelPath(const std::string& repository,
                                          const std::string& scene);

// Removes the folders that NextModelPath made, where no model came to lie there
// after all.
void RemoveEmptyVersion(const std::string& model_path);

}  // namespace treeline::tools

#endif  // SERVER_TOOLS_TRAINING_PLACE_H_
