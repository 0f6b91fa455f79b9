// One scene: its versions, the one that serves, and who waits for them.
#ifndef SERVER_REPOSITORY_SCENE_ENTRY_H_
#define SERVER_REPOSITORY_SCENE_ENTRY_H_

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/base/clock.h"
#include "server/repository/model_source.h"
#include "server/repository/model_version.h"
#include "server/repository/names.h"
#include "server/repository/repository_stats.h"
#include "server/repository/scene.h"
#include "server/repository/scene_json.h"
#include "server/repository/table_effects.h"

namespace treeline::repository {

// A version that is to be loaded.
struct LoadKey {
  std::string scene;
  std::string version;
};

// What the scenes of a table have in common.
struct SharedByScenes {
  std::deque<LoadKey> queue;
  // Numbers the uses of versions, in the order in which they were used.
  uint64_t uses = 0;
  // Another version, or another file of the same one, took over.
  uint64_t swaps = 0;
  // Of all scenes, also of those that are forgotten.
  LoadCounts counts;
};

// Not thread-safe. Never calls a callback and never destroys a model: both are
// left in the effects.
class SceneEntry {
 public:
  // `shared` outlives it.
  SceneEntry(std::string name, SharedByScenes& shared)
      : name_(std::move(name)), shared_(shared) {}
  SceneEntry(const SceneEntry&) = delete;
  SceneEntry& operator=(const SceneEntry&) = delete;

  // --- What the source has. A listing is applied by these three, in order.

  void UnlistAll();
  void List(const ModelRef& model, TableEffects& effects);
  void EndListing(const SourceListing& listing, base::MonotonicTime now,
                  TableEffects& effects);

  // Nothing is listed, in memory or on its way: it can be forgotten.
  bool empty() const { return versions_.empty(); }

  // --- What people ask for. See SceneTable.

  void Acquire(const std::string& version, AcquireDone done,
               base::MonotonicTime now, TableEffects& effects);
  void Load(const std::string& version, AcquireDone done,
            base::MonotonicTime now, TableEffects& effects);
  absl::Status Unload(const std::string& version, TableEffects& effects);
  void LoadIfItFits(base::MonotonicTime now);
  // Answers all who wait that the repository stops.
  void TurnAwayAll(TableEffects& effects);

  // --- Loads and memory.

  // A version whose load is queued or at work.
  ModelVersion& loading(const std::string& version) {
    return versions_.at(version);
  }
  // The load of `version` cannot even begin.
  void Refuse(const std::string& version, const absl::Status& failure,
              base::MonotonicTime now, TableEffects& effects);
  // The load at work of `model` has ended after `seconds`.
  void Finish(
      const ModelRef& model,
      absl::StatusOr<std::shared_ptr<const localizer::Localizer>> localizer,
      double seconds, base::MonotonicTime now, TableEffects& effects);
  // Those in memory.
  std::vector<ModelVersion*> Resident();
  // Takes one of those out to make room.
  void Evict(ModelVersion& version, TableEffects& effects);

  // --- What there is.

  const std::string& name() const { return name_; }
  SceneState state() const;
  SceneStatus status() const;
  SceneStats stats() const;
  // What answers a query without a version, or would once it is loaded.
  std::optional<ModelRef> Model() const;

 private:
  struct NewestFirst {
    bool operator()(const std::string& a, const std::string& b) const {
      return VersionIsOlder(b, a);
    }
  };
  // Until when somebody waits.
  enum class Until { kInMemory, kLoadHasEnded };
  struct Waiter {
    std::string version;  // "": whatever answers
    Until until = Until::kInMemory;
    AcquireDone done;
  };
  // nullopt: wait.
  using Answer = std::optional<SceneAnswer>;

  // The newest version that is listed and is, or may be, in memory; null if
  // there is none.
  ModelVersion* Target(base::MonotonicTime now);
  // What answers a query without a version at once; null if nothing does.
  const ModelVersion* Serving() const;
  ModelVersion* Serving();

  void Queue(ModelVersion& version, LoadPurpose purpose);
  // Lets the target take over if it is in memory, has it loaded if what serves
  // is, and answers those whom that helps.
  void Settle(base::MonotonicTime now, TableEffects& effects);
  // Forgets what is neither listed nor in use.
  void Tidy();
  void ApplyMetadata(const SourceListing& listing, TableEffects& effects);

  Answer Resolve(const Waiter& waiter, base::MonotonicTime now);
  Answer ResolveNamed(const Waiter& waiter, base::MonotonicTime now);
  Answer ResolveNewest(base::MonotonicTime now);
  // Answers `waiter`, or lets it wait.
  void Add(Waiter waiter, base::MonotonicTime now, TableEffects& effects);
  absl::Status FailureOf(const ModelVersion& version,
                         base::MonotonicTime now) const;
  std::shared_ptr<const Scene> Use(ModelVersion& version) {
    return version.Use(++shared_.uses);
  }
  void Install(ModelVersion& version, const ModelRef& model,
               std::shared_ptr<const localizer::Localizer> localizer,
               TableEffects& effects);
  void NoteFailure(ModelVersion& version, const absl::Status& failure,
                   base::MonotonicTime now, TableEffects& effects);
  static void Release(ModelVersion& version, TableEffects& effects);
  void Count(uint64_t LoadCounts::*what);
  uint64_t resident_bytes() const;

  const std::string name_;
  SharedByScenes& shared_;
  std::map<std::string, ModelVersion, NewestFirst> versions_;
  // The version that last took over; "" before the first.
  std::string serving_;
  SceneJson json_;
  std::vector<Waiter> waiters_;
  LoadCounts counts_;
};

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_SCENE_ENTRY_H_
