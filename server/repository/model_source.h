// Where models come from: a folder, or a web server.
#ifndef SERVER_REPOSITORY_MODEL_SOURCE_H_
#define SERVER_REPOSITORY_MODEL_SOURCE_H_

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace treeline::repository {

// One version of one scene's model, not read yet.
struct ModelRef {
  std::string scene;
  std::string version;
  uint64_t bytes = 0;
  // Another one means another file under the same name: the time of its last
  // change and its size, or its digest.
  std::string fingerprint;
  // Empty where the source cannot say. Otherwise: another fingerprint with the
  // same id means that the very file was written over, and another id that
  // another file was put in its place.
  std::string file_id = {};
  // What it takes in memory; 0: not known before its file is looked into.
  uint64_t memory_bytes = 0;

  // What is set aside for it: what is known of it, but no less than its file.
  uint64_t reserved_bytes() const { return std::max(bytes, memory_bytes); }
};

// What a source has at one moment.
struct SourceListing {
  std::vector<ModelRef> models;
  // Of the scenes that have one: the text of their scene.json.
  std::map<std::string, std::string> scene_json;
  // Of the scenes that have one which could not be read: why.
  std::map<std::string, absl::Status> scene_json_errors = {};
};

// Thread-safe.
class ModelSource {
 public:
  virtual ~ModelSource() = default;

  // Every valid name (see names.h) that holds a model now. NOT_FOUND,
  // PERMISSION_DENIED, UNAVAILABLE name the source and the reason.
  virtual absl::StatusOr<SourceListing> List() = 0;

  // The path of the model's file if it is on this machine now; NOT_FOUND if it
  // is not. Does not wait for a network.
  virtual absl::StatusOr<std::string> LocalPath(const ModelRef& model) = 0;

  // The path of the model's file on this machine; gets it first if it must.
  // Blocks. DATA_LOSS: what came is not what was promised. CANCELLED.
  virtual absl::StatusOr<std::string> Fetch(const ModelRef& model,
                                            const std::stop_token& stop) = 0;

  // While what is returned lives, the source does not delete the model's file
  // on this machine to make room for others. Null where it never does.
  virtual std::shared_ptr<const void> Keep(const ModelRef& /*model*/) {
    return nullptr;
  }
};

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_MODEL_SOURCE_H_
