// The scenes of a folder, loaded.
#ifndef SERVER_REPOSITORY_SCENE_REPOSITORY_H_
#define SERVER_REPOSITORY_SCENE_REPOSITORY_H_

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "server/core/localizer/localizer.h"
#include "server/repository/names.h"

namespace treeline {

// One loaded version of one scene. Whoever holds it can go on using it when
// the repository has moved on to another version.
struct Scene {
  std::string name;
  std::string version;
  std::unique_ptr<const Localizer> localizer;
};

enum class SceneState { kUnloaded, kLoading, kReady, kFailed };

struct VersionStatus {
  std::string version;
  SceneState state = SceneState::kUnloaded;
  // With kFailed: what the opener said.
  absl::Status failure;
};

struct SceneStatus {
  std::string name;
  // kReady if any version is; otherwise the state of the newest.
  SceneState state = SceneState::kUnloaded;
  absl::Status failure;
  // The newest version that is ready; null if none is.
  std::shared_ptr<const Scene> serving;
  // The newest first.
  std::vector<VersionStatus> versions;
};

// Opens the model file at a path.
using LocalizerOpener =
    std::function<absl::StatusOr<std::unique_ptr<Localizer>>(
        const std::string& model_path)>;

// ROOT/<scene>/<version>/model.treeline, every version of every scene. A
// version that cannot be loaded is FAILED with its reason and keeps none of the
// others from serving. Entries of ROOT whose names are not valid (see names.h)
// or that hold no model file are not scenes. Thread-safe.
class SceneRepository {
 public:
  // Finds and loads all. NOT_FOUND, PERMISSION_DENIED and so on if `root`
  // cannot be read; models that fail are no error. An empty root is none
  // either.
  static absl::StatusOr<std::unique_ptr<SceneRepository>> Open(
      const std::string& root, LocalizerOpener opener);

  // The scene to answer a query with; version "" means the newest that is
  // ready. INVALID_ARGUMENT: not a name. NOT_FOUND: no such scene or version.
  // DATA_LOSS: its file is corrupt. FAILED_PRECONDITION: it is not loaded, or
  // failed for another reason.
  absl::StatusOr<std::shared_ptr<const Scene>> Acquire(
      const std::string& name, const std::string& version) const;

  // TEMPORARY
  void AcquireAsync(
      const std::string& name, const std::string& version,
      std::function<void(absl::StatusOr<std::shared_ptr<const Scene>>)> done) {
    done(Acquire(name, version));
  }
  // All scenes by name.
  std::vector<SceneStatus> List() const;
  // INVALID_ARGUMENT: not a name. NOT_FOUND: no such scene.
  absl::StatusOr<SceneStatus> Get(const std::string& name) const;

 private:
  struct Version {
    std::string model_path;
    SceneState state = SceneState::kUnloaded;
    absl::Status failure;
    std::shared_ptr<const Scene> scene;  // with kReady
  };
  struct NewestFirst {
    bool operator()(const std::string& a, const std::string& b) const {
      return VersionIsOlder(b, a);
    }
  };
  using Versions = std::map<std::string, Version, NewestFirst>;
  struct VersionKey {
    std::string scene;
    std::string version;
  };

  explicit SceneRepository(LocalizerOpener opener)
      : opener_(std::move(opener)) {}

  // Adds what lies in `root` as kUnloaded; returns what was added.
  absl::StatusOr<std::vector<VersionKey>> Scan(const std::string& root);
  // Opens one version, without holding the lock meanwhile.
  void Load(const VersionKey& key);

  static SceneStatus StatusOf(const std::string& name,
                              const Versions& versions);

  const LocalizerOpener opener_;
  mutable absl::Mutex mutex_;
  std::map<std::string, Versions> scenes_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline

#endif  // SERVER_REPOSITORY_SCENE_REPOSITORY_H_
