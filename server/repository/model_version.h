// One version of a scene: what the source has of it, what is in memory of it,
// and how its load stands.
#ifndef SERVER_REPOSITORY_MODEL_VERSION_H_
#define SERVER_REPOSITORY_MODEL_VERSION_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "absl/status/status.h"
#include "common/base/clock.h"
#include "server/repository/model_source.h"
#include "server/repository/scene.h"
#include "server/repository/scene_metadata.h"

namespace treeline::repository {

enum class LoadPurpose {
  kWanted,    // others may have to make room
  kIfItFits,  // dropped if they would have to
};

// Not thread-safe. Never destroys a model: what goes out of memory is returned.
class ModelVersion {
 public:
  // Listed, and never loaded.
  explicit ModelVersion(ModelRef model) : model_(std::move(model)) {}

  // --- What the source has.

  enum class FileChange {
    kNone,
    kReplaced,     // another file under the name
    kOverwritten,  // the same file with other bytes
  };
  // The source has this now. Of another file nothing is known to be wrong.
  FileChange List(const ModelRef& model);
  void Unlist() { is_listed_ = false; }
  bool is_listed() const { return is_listed_; }
  // As it was last listed.
  const ModelRef& model() const { return model_; }

  // --- What is in memory.

  bool is_resident() const { return resident_.has_value(); }
  // The following three: only while it is resident.
  const std::shared_ptr<const Scene>& scene() const { return resident_->scene; }
  const ModelRef& loaded() const { return resident_->model; }
  uint64_t last_use() const { return resident_->last_use; }
  // 0 if it is not resident.
  uint64_t resident_bytes() const {
    return resident_ ? resident_->model.reserved_bytes() : 0;
  }
  // Whether a query, or whoever else got it, has this scene or its model.
  bool IsInUse() const;
  // The scene; `use` counts on.
  std::shared_ptr<const Scene> Use(uint64_t use);
  // `model` is what `scene` was read from. Returns what it takes the place of,
  // or null.
  std::shared_ptr<const Scene> Install(std::shared_ptr<const Scene> scene,
                                       const ModelRef& model, uint64_t use);
  // Puts other metadata to the model in memory; returns the scene without it.
  std::shared_ptr<const Scene> SetMetadata(
      std::shared_ptr<const SceneMetadata> metadata);
  // Null if it was not resident.
  std::shared_ptr<const Scene> Release();

  // Somebody asked for this very version: it stays when another takes over,
  // until it is released.
  void SetNamed() { is_named_ = true; }
  bool is_named() const { return is_named_; }

  // --- How its load stands.

  // Queued or at work.
  bool is_loading() const;
  bool has_failed() const { return failure() != nullptr; }
  // Of the last load; null if it did not fail, or another is on its way.
  const absl::Status* failure() const;
  // When what failed for now may be tried again.
  base::MonotonicTime retry_at() const;
  // Whether a query may have it loaded: it did not fail, or failed for now and
  // long enough ago.
  bool MayLoad(base::MonotonicTime now) const;
  // Whether it has been put into the queue; false: it was there, or at work.
  bool Queue(LoadPurpose purpose);
  // Whatever it was queued for: somebody waits for it now.
  void Want();
  // Of the queued load.
  LoadPurpose purpose() const;
  void Begin();  // queued -> at work
  // At work -> queued: the model takes more memory than was set aside for it.
  // Nothing is known of another file than `model`, which may be listed since.
  void Postpone(const ModelRef& model, uint64_t memory_bytes);
  // Queued -> not loading.
  void Drop();
  // At work -> not loading; returns what the load was for.
  LoadPurpose End();
  // The last load failed. Each further failure in a row doubles the time until
  // it is tried again.
  void Fail(const absl::Status& failure, base::MonotonicTime now);

  SceneState state() const;
  VersionStatus status() const;

 private:
  struct Resident {
    std::shared_ptr<const Scene> scene;
    ModelRef model;  // what it was read from
    uint64_t last_use = 0;
  };
  struct NotLoading {};
  struct Failed {
    absl::Status failure;
    base::MonotonicTime retry_at;
  };
  struct Queued {
    LoadPurpose purpose;
  };
  struct AtWork {
    LoadPurpose purpose;
  };

  ModelRef model_;
  bool is_listed_ = true;
  bool is_named_ = false;
  std::optional<Resident> resident_;
  std::variant<NotLoading, Failed, Queued, AtWork> load_;
  int failures_ = 0;  // in a row
};

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_MODEL_VERSION_H_
