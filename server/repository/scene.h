// A loaded scene, and what is known of scenes that are not loaded.
#ifndef SERVER_REPOSITORY_SCENE_H_
#define SERVER_REPOSITORY_SCENE_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/camera/rgbd_calibration.h"
#include "server/core/localizer/localizer.h"
#include "server/repository/scene_metadata.h"

namespace treeline::repository {

// One loaded version of one scene. Whoever holds it can go on using it when
// the repository has moved on to another version; its memory counts against
// the budget until then. Immutable.
struct Scene {
  std::string name;
  std::string version;
  std::shared_ptr<const localizer::Localizer> localizer;
  // Of its scene.json; null if there is none, or it is not valid.
  std::shared_ptr<const SceneMetadata> metadata = {};
};

// What a query without its own calibration is taken with: the model's, with the
// colour camera of scene.json if that gives one.
camera::RgbdCalibration QueryCalibration(const Scene& scene);

// Whether that is not the model's.
bool HasOwnCamera(const Scene& scene);

enum class SceneState { kUnloaded, kLoading, kReady, kFailed };
inline constexpr size_t kSceneStates = 4;

struct VersionStatus {
  std::string version;
  // kReady also while its file, which has been replaced, is loaded anew.
  SceneState state = SceneState::kUnloaded;
  // With kFailed: why. With kReady: why the file that replaced the loaded one
  // was refused; mostly OK.
  absl::Status failure;
  // Of the loaded model; 0 if none is.
  uint64_t resident_bytes = 0;
  // Whether the source has it. If not, it serves from memory until it is
  // replaced, evicted or unloaded.
  bool listed = true;
};

struct SceneStatus {
  std::string name;
  // kReady if any version is; otherwise the state of the newest.
  SceneState state = SceneState::kUnloaded;
  absl::Status failure = {};
  // What answers a query that names no version at once; null if such a query
  // has to wait for a version to be loaded.
  std::shared_ptr<const Scene> serving = {};
  // The newest first.
  std::vector<VersionStatus> versions = {};
  // Null if there is no valid scene.json.
  std::shared_ptr<const SceneMetadata> metadata = {};
  // What is wrong with scene.json; it never stops the scene. OK: nothing.
  absl::Status metadata_problem = {};
  // Of all loaded versions.
  uint64_t resident_bytes = 0;
};

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_SCENE_H_
