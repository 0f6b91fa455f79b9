// The index that makes a folder of models one that web servers can hand out.
#ifndef SERVER_TOOLS_PUBLISH_H_
#define SERVER_TOOLS_PUBLISH_H_

#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "server/repository/model_index.h"
#include "server/repository/model_source.h"

namespace treeline::tools {

struct PublishOptions {
  // In front of <scene>/<version>/model.treeline in each url: "" where the
  // index will lie beside the scenes, else an address that ends with /.
  std::string base_url;
  // No progress bar.
  bool quiet = false;

  // INVALID_ARGUMENT
  absl::Status Validate() const;
};

// Hashes every model of `source`; sorts them by scene, older versions first.
// NOT_FOUND: it has none. INVALID_ARGUMENT: a scene.json that is none.
// CANCELLED.
absl::StatusOr<repository::ModelIndex> IndexModels(
    repository::ModelSource& source, const PublishOptions& options,
    const std::stop_token& stop);

}  // namespace treeline::tools

#endif  // SERVER_TOOLS_PUBLISH_H_
