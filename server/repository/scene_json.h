// What is known of a scene beside its models: its scene.json as it changes.
#ifndef SERVER_REPOSITORY_SCENE_JSON_H_
#define SERVER_REPOSITORY_SCENE_JSON_H_

#include <memory>
#include <string>
#include <variant>

#include "absl/status/status.h"
#include "server/repository/model_source.h"
#include "server/repository/scene_metadata.h"

namespace treeline::repository {

// A scene.json that is not valid, or cannot be read, never stops its scene: it
// is a problem to be told, and the last valid one goes on.
class SceneJson {
 public:
  // Its file, as a source has it.
  struct NoFile {
    bool operator==(const NoFile&) const = default;
  };
  struct Text {
    std::string json;
    bool operator==(const Text&) const = default;
  };
  struct Unreadable {
    absl::StatusCode code;
    bool operator==(const Unreadable&) const = default;
  };
  using File = std::variant<NoFile, Text, Unreadable>;
  static File Of(const std::string& scene, const SourceListing& listing);

  struct Change {
    bool of_metadata = false;
    bool is_problem = false;  // a new one: see problem()
  };
  Change Apply(const File& file);

  // Of the last valid file; null if there is no file now, or was no valid one.
  const std::shared_ptr<const SceneMetadata>& metadata() const {
    return metadata_;
  }
  // What is wrong with the file as it is now.
  const absl::Status& problem() const { return problem_; }

 private:
  Change ApplyText(const std::string& json);

  File file_;
  std::shared_ptr<const SceneMetadata> metadata_;
  absl::Status problem_;
};

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_SCENE_JSON_H_
