// The scenes of a source, loaded when they are needed.
#ifndef SERVER_REPOSITORY_SCENE_REPOSITORY_H_
#define SERVER_REPOSITORY_SCENE_REPOSITORY_H_

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "server/repository/model_source.h"
#include "server/repository/repository_event.h"
#include "server/repository/repository_stats.h"
#include "server/repository/scene.h"
#include "server/repository/scene_table.h"

namespace treeline::repository {

// Opens the model file at a path.
using LocalizerOpener =
    std::function<absl::StatusOr<std::unique_ptr<localizer::Localizer>>(
        const std::string& model_path)>;

// What the model file at a path takes in memory when it is open; errors are
// those that its opening gives.
using MemoryReader =
    std::function<absl::StatusOr<uint64_t>(const std::string& model_path)>;

struct RepositoryOptions {
  // Of all models in memory. 0: none.
  uint64_t memory_budget_bytes = 0;
  // What each counts with; null: its file's size.
  MemoryReader read_memory_bytes = {};
  // How often the source is looked at; 0: only when Rescan or Load is called.
  std::chrono::milliseconds poll_interval{0};
  // Models loaded at a time, 1..64.
  int loader_threads = 2;
  // Load the newest version of every scene, as far as the budget goes, rather
  // than each with its first query.
  bool load_all_at_start = false;
  // Called for each event, without a lock, from the thread that brought it
  // about, at times before Open has returned; must not block. May be null.
  RepositoryEventHandler on_event = {};

  absl::Status Validate() const;
};

// Each scene answers with its newest version that can be loaded. A version is
// loaded when it is first asked for, and goes out of memory when the budget
// needs it for another, the longest unused first. When the source has a newer
// version of a scene that is in memory, or the file of the one in memory is
// replaced, that is loaded beside it and takes over once it is READY; if it
// cannot be loaded it is FAILED, and the old one goes on. Thread-safe.
//
// Callbacks are called exactly once and without a lock; they may call the
// repository, but nothing that blocks.
class SceneRepository {
 public:
  using StatusDone = std::function<void(absl::StatusOr<SceneStatus>)>;

  // Looks at the source and starts the threads; does not wait for loads. An
  // error of the options, or of the source: it cannot be listed. A source
  // without models is none. `clock` must outlive the repository.
  static absl::StatusOr<std::unique_ptr<SceneRepository>> Open(
      std::unique_ptr<ModelSource> source, LocalizerOpener opener,
      const RepositoryOptions& options, const base::Clock& clock);
  // Stop().
  ~SceneRepository();

  // The scene to answer a query with; version "" means the newest. Calls back
  // before it returns if the scene is in memory or there is no hope; otherwise
  // from another thread, when it is loaded. All who wait for a version share
  // one load. Errors, with their reasons:
  //   INVALID_ARGUMENT     SCENE_NAME_INVALID
  //   NOT_FOUND            SCENE_NOT_FOUND, VERSION_NOT_FOUND
  //   DATA_LOSS            MODEL_CORRUPT
  //   FAILED_PRECONDITION  MODEL_TOO_NEW, SCENE_LOAD_FAILED
  //   RESOURCE_EXHAUSTED   MEMORY_BUDGET: the model alone is larger
  //   UNAVAILABLE          SCENE_LOAD_FAILED with a time to retry: the model
  //                        cannot be had now; SCENE_NOT_LOADED: stopping
  void AcquireAsync(const std::string& name, const std::string& version,
                    AcquireDone done);
  // The same, for tools and tests: waits. CANCELLED: `stop` was requested.
  absl::StatusOr<std::shared_ptr<const Scene>> Acquire(
      const std::string& name, const std::string& version,
      const std::stop_token& stop = {});

  // Looks at the source, loads a version (the newest if it is "") even if that
  // failed before, and calls back, from another thread, when it is READY or
  // failed. Errors as of AcquireAsync, or the source's.
  void Load(const std::string& name, const std::string& version,
            StatusDone done);
  // Lets go of a version, or of all of a scene: it goes out of memory when the
  // last query that uses it has ended. Loads at work are left alone; the next
  // query loads it again. INVALID_ARGUMENT, NOT_FOUND.
  absl::StatusOr<SceneStatus> Unload(const std::string& name,
                                     const std::string& version);

  // Looks at the source now. On error all stays as it was.
  absl::Status Rescan();

  // Returns when no load is queued or at work. CANCELLED: `stop` was requested.
  absl::Status WaitForLoads(const std::stop_token& stop = {});

  // Of each scene that the source has: the version that answers queries which
  // name none, or would once it is loaded.
  std::vector<ModelRef> Models() const;
  // Where the source has a model on this machine: ModelSource::LocalPath.
  absl::StatusOr<std::string> LocalPath(const ModelRef& model) const {
    return source_->LocalPath(model);
  }
  // All scenes by name.
  std::vector<SceneStatus> List() const;
  // INVALID_ARGUMENT, NOT_FOUND.
  absl::StatusOr<SceneStatus> Get(const std::string& name) const;
  RepositoryStats Stats() const;

  // Answers all who wait with UNAVAILABLE, waits for loads at work, and for
  // callbacks to return; none is called from another thread after that. Not
  // from a callback.
  void Stop();

 private:
  // Shared with every model handed out, which may outlive the repository.
  struct Shared {
    absl::Mutex mutex;
    absl::CondVar changed;
    // Of all models not destroyed yet.
    uint64_t resident_bytes ABSL_GUARDED_BY(mutex) = 0;
  };

  SceneRepository(std::unique_ptr<ModelSource> source, LocalizerOpener opener,
                  const RepositoryOptions& options, const base::Clock& clock);
  void StartThreads();

  // What a loader does: tasks first, then loads.
  void RunLoader(const std::stop_token& stop);
  void RunJob(const SceneTable::Job& job, const std::stop_token& stop);
  // nullopt: it takes more memory than was set aside, and is loaded later.
  std::optional<absl::StatusOr<std::unique_ptr<localizer::Localizer>>>
  OpenModel(const SceneTable::Job& job, const std::stop_token& stop);
  void RunPoll(const std::stop_token& stop);
  void LoadNow(const std::string& name, const std::string& version,
               StatusDone done);
  bool IsStopping() const;
  // What the table left to do; to be called without the lock.
  void Carry(SceneTable::Effects& effects) const;
  // Wakes who waits for changes.
  void Wake() ABSL_EXCLUSIVE_LOCKS_REQUIRED(shared_->mutex) {
    shared_->changed.SignalAll();
  }

  const std::unique_ptr<ModelSource> source_;
  const LocalizerOpener opener_;
  const RepositoryOptions options_;
  const base::Clock& clock_;
  const std::shared_ptr<Shared> shared_;

  SceneTable table_ ABSL_GUARDED_BY(shared_->mutex);
  std::deque<std::function<void()>> tasks_ ABSL_GUARDED_BY(shared_->mutex);
  bool stopping_ ABSL_GUARDED_BY(shared_->mutex) = false;
  // Listings are numbered as they begin; one that began before the last that
  // was applied is out of date.
  uint64_t listings_ ABSL_GUARDED_BY(shared_->mutex) = 0;
  uint64_t applied_listing_ ABSL_GUARDED_BY(shared_->mutex) = 0;
  uint64_t rescans_ ABSL_GUARDED_BY(shared_->mutex) = 0;
  absl::Status last_rescan_ ABSL_GUARDED_BY(shared_->mutex);
  uint64_t rescan_failures_ ABSL_GUARDED_BY(shared_->mutex) = 0;

  // Last, so that they end first.
  std::vector<std::jthread> threads_;
};

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_SCENE_REPOSITORY_H_
