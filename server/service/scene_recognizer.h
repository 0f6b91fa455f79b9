// Which scenes look like a frame: the index of all that the repository has.
#ifndef SERVER_SERVICE_SCENE_RECOGNIZER_H_
#define SERVER_SERVICE_SCENE_RECOGNIZER_H_

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/statusor.h"
#include "common/image/frame.h"
#include "server/core/recognition/scene_index.h"
#include "server/repository/scene_repository.h"

namespace treeline::service {

// Reads the descriptor of each model when the model comes, loaded or not, from
// construction to destruction; looks for new ones once a second. Scenes whose
// model has no descriptor, or is not on this machine yet, are not recognized.
// Thread-safe.
class SceneRecognizer {
 public:
  using DescriptorReader =
      std::function<absl::StatusOr<recognition::SceneDescriptor>(
          const std::string& model_path)>;

  // The models that are there now are known when it returns. `repository` must
  // outlive this.
  explicit SceneRecognizer(
      const repository::SceneRepository& repository,
      DescriptorReader read = &recognition::ReadSceneDescriptor);

  // Scenes like the frame, the most alike first: of `candidates`, or of all if
  // there are none. Candidates that are not recognized come last, with
  // similarity 0.
  std::vector<recognition::SceneScore> Rank(
      const image::Frame& frame, std::span<const std::string> candidates) const;

 private:
  void Update();

  const repository::SceneRepository& repository_;
  const DescriptorReader read_;
  recognition::SceneIndex index_;
  // Scene to the fingerprint of what was read of it; of the thread.
  std::map<std::string, std::string> known_;
  std::jthread thread_;
};

}  // namespace treeline::service

#endif  // SERVER_SERVICE_SCENE_RECOGNIZER_H_
