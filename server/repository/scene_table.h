// Which versions there are, which are in memory, and who waits for them: the
// decisions of SceneRepository, without its threads.
#ifndef SERVER_REPOSITORY_SCENE_TABLE_H_
#define SERVER_REPOSITORY_SCENE_TABLE_H_

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "server/repository/model_source.h"
#include "server/repository/names.h"
#include "server/repository/repository_event.h"
#include "server/repository/repository_stats.h"
#include "server/repository/scene.h"

namespace treeline::repository {

using AcquireDone =
    std::function<void(absl::StatusOr<std::shared_ptr<const Scene>>)>;

// Not thread-safe: whoever has it locks. It never calls a callback and never
// destroys a model: that is left in Effects, for when the lock has been let go.
class SceneTable {
 public:
  struct Effects {
    // Let go; models are unmapped with them.
    std::vector<std::shared_ptr<const Scene>> released;
    std::vector<RepositoryEvent> events;
    std::vector<std::function<void()>> answers;

    bool empty() const {
      return released.empty() && events.empty() && answers.empty();
    }
  };

  // One model to load. Its bytes are set aside in the budget until Finish.
  struct Job {
    ModelRef model;
  };

  // 0: no budget.
  explicit SceneTable(uint64_t budget_bytes) : budget_bytes_(budget_bytes) {}

  // What the source has now. Queues loads of what is to take over from a
  // version that is in memory.
  void Apply(const SourceListing& listing, base::MonotonicTime now,
             Effects& effects);

  // Answers now, or when a load has ended. `name` and `version` are valid.
  void Acquire(const std::string& name, const std::string& version,
               AcquireDone done, base::MonotonicTime now, Effects& effects);
  // Loads a version, the newest if it is "", even if that failed before, and
  // answers when that has ended.
  void Load(const std::string& name, const std::string& version,
            AcquireDone done, base::MonotonicTime now, Effects& effects);
  // Lets go of a version, or of all of a scene.
  absl::Status Unload(const std::string& name, const std::string& version,
                      Effects& effects);
  // Queues the newest version of each scene, as far as they fit.
  void LoadWhatFits(base::MonotonicTime now);

  // The next load that memory allows; takes others out of memory for the first
  // in the queue. `resident_bytes` is what all models take that are not
  // destroyed yet. If nothing is returned and effects.released is not empty,
  // ask again when that has been destroyed; otherwise, when something changes.
  std::optional<Job> NextJob(uint64_t resident_bytes, base::MonotonicTime now,
                             Effects& effects);
  void Finish(
      const Job& job,
      absl::StatusOr<std::shared_ptr<const localizer::Localizer>> localizer,
      double seconds, base::MonotonicTime now, Effects& effects);
  // Neither queued nor running loads.
  bool has_queued() const { return !queue_.empty(); }
  bool is_settled() const { return queue_.empty() && running_ == 0; }

  // Answers all who wait that the repository stops.
  void TurnAwayAll(Effects& effects);

  std::vector<ModelRef> Models() const;
  std::vector<SceneStatus> List() const;
  absl::StatusOr<SceneStatus> Get(const std::string& name) const;
  // All but rescans and resident_bytes.
  RepositoryStats Stats() const;

 private:
  struct Version {
    ModelRef model;
    bool listed = true;
    // Queued or running.
    bool loading = false;
    bool running = false;
    // Only if nothing has to make room for it.
    bool if_fits = false;
    // Somebody asked for this very version: it stays when another takes over.
    bool named = false;
    // In memory.
    std::shared_ptr<const Scene> scene = {};
    ModelRef loaded = {};  // what `scene` was read from
    uint64_t last_use = 0;
    // Of the last load.
    absl::Status failure = {};
    int failures = 0;  // in a row
    base::MonotonicTime retry_at = {};
  };
  struct NewestFirst {
    bool operator()(const std::string& a, const std::string& b) const {
      return VersionIsOlder(b, a);
    }
  };
  using Versions = std::map<std::string, Version, NewestFirst>;
  struct Waiter {
    std::string version;
    // Waits for the end of a load even if the version is in memory.
    bool fresh = false;
    AcquireDone done;
  };
  struct Entry {
    std::string name;
    Versions versions;
    // The version that last took over; "" before the first.
    std::string serving;
    std::optional<std::string> json;
    // Of the last scene.json that was valid.
    std::shared_ptr<const SceneMetadata> metadata = {};
    absl::Status metadata_problem = {};
    std::vector<Waiter> waiters;
    LoadCounts counts;
  };
  struct Key {
    std::string scene;
    std::string version;
  };
  // nullopt: wait.
  using Answer = std::optional<absl::StatusOr<std::shared_ptr<const Scene>>>;

  static bool MayLoad(const Version& version, base::MonotonicTime now);
  // The newest version that is listed and is, or may be, in memory; null if
  // there is none.
  static Version* Target(Entry& entry, base::MonotonicTime now);
  // What answers a query without a version at once; null if nothing does.
  static const Version* Serving(const Entry& entry);
  static Version* Serving(Entry& entry) {
    return const_cast<Version*>(Serving(std::as_const(entry)));
  }
  static SceneState StateOf(const Version& version);
  static SceneState StateOf(const Entry& entry);
  static uint64_t BytesOf(const Entry& entry);
  static SceneStatus StatusOf(const Entry& entry);

  void ApplyModel(const ModelRef& model, Effects& effects);
  void ApplyMetadata(Entry& entry, const SourceListing& listing,
                     Effects& effects);
  // Forgets what is neither listed nor in use.
  static void Tidy(Entry& entry);

  Answer Resolve(Entry& entry, const Waiter& waiter, base::MonotonicTime now);
  Answer ResolveNamed(Entry& entry, const Waiter& waiter,
                      base::MonotonicTime now);
  Answer ResolveNewest(Entry& entry, base::MonotonicTime now);
  static absl::Status FailureOf(const Entry& entry, const Version& version,
                                base::MonotonicTime now);
  std::shared_ptr<const Scene> Use(Version& version);
  void StartLoad(Version& version);
  // Lets the target take over if it is in memory, has it loaded if what serves
  // is, and answers those whom that helps.
  void Settle(Entry& entry, base::MonotonicTime now, Effects& effects);
  void AnswerWaiters(Entry& entry, base::MonotonicTime now, Effects& effects);
  // Answers `waiter`, or lets it wait.
  void Add(Entry& entry, Waiter waiter, base::MonotonicTime now,
           Effects& effects);
  void Install(Entry& entry, Version& version, const Job& job,
               std::shared_ptr<const localizer::Localizer> localizer,
               Effects& effects);
  void NoteFailure(Entry& entry, Version& version, const absl::Status& failure,
                   base::MonotonicTime now, Effects& effects);
  void Release(Version& version, Effects& effects);

  bool Fits(uint64_t bytes, uint64_t resident_bytes) const {
    return resident_bytes + reserved_bytes_ + bytes <= budget_bytes_;
  }
  void MakeRoom(const ModelRef& model, uint64_t resident_bytes,
                Effects& effects);
  const uint64_t budget_bytes_;
  std::map<std::string, Entry> scenes_;
  std::deque<Key> queue_;
  uint64_t running_ = 0;
  // Of running loads.
  uint64_t reserved_bytes_ = 0;
  // Of what is in memory and has not been let go.
  uint64_t held_bytes_ = 0;
  uint64_t uses_ = 0;
  uint64_t swaps_ = 0;
  LoadCounts counts_;
  LoadTimes load_times_;
};

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_SCENE_TABLE_H_
