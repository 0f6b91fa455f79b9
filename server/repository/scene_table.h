// Which versions there are, which are in memory, and who waits for them: the
// decisions of SceneRepository, without its threads.
#ifndef SERVER_REPOSITORY_SCENE_TABLE_H_
#define SERVER_REPOSITORY_SCENE_TABLE_H_

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "server/repository/memory_budget.h"
#include "server/repository/model_source.h"
#include "server/repository/repository_stats.h"
#include "server/repository/scene.h"
#include "server/repository/scene_entry.h"
#include "server/repository/table_effects.h"

namespace treeline::repository {

// Not thread-safe: whoever has it locks. It never calls a callback and never
// destroys a model: that is left in Effects, for when the lock has been let go.
class SceneTable {
 public:
  using Effects = TableEffects;

  // One model to load. Its bytes are set aside in the budget until Finish.
  struct Job {
    ModelRef model;
  };

  // 0: no budget.
  explicit SceneTable(uint64_t budget_bytes) : budget_(budget_bytes) {}

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
  // Instead of Finish: the model is known to take `memory_bytes`, more than was
  // set aside for it. The load begins again as soon as there is room for that.
  void Postpone(const Job& job, uint64_t memory_bytes);
  void Finish(
      const Job& job,
      absl::StatusOr<std::shared_ptr<const localizer::Localizer>> localizer,
      double seconds, base::MonotonicTime now, Effects& effects);
  // Neither queued nor running loads.
  bool has_queued() const { return !shared_.queue.empty(); }
  bool is_settled() const {
    return shared_.queue.empty() && budget_.reservations() == 0;
  }

  // Answers all who wait that the repository stops.
  void TurnAwayAll(Effects& effects);

  std::vector<ModelRef> Models() const;
  std::vector<SceneStatus> List() const;
  absl::StatusOr<SceneStatus> Get(const std::string& name) const;
  // All but rescans and resident_bytes.
  RepositoryStats Stats() const;

 private:
  // Null if there is no such scene.
  SceneEntry* Find(const std::string& name);
  void MakeRoom(const ModelRef& model, uint64_t resident_bytes,
                Effects& effects);

  MemoryBudget budget_;
  SharedByScenes shared_;
  std::map<std::string, SceneEntry> scenes_;
  LoadTimes load_times_;
};

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_SCENE_TABLE_H_
