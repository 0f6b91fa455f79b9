#include "server/repository/scene_table.h"

#include <iterator>
#include <utility>

#include "server/repository/load_failure.h"
#include "server/repository/names.h"

namespace treeline::repository {

SceneEntry* SceneTable::Find(const std::string& name) {
  const auto found = scenes_.find(name);
  return found == scenes_.end() ? nullptr : &found->second;
}

void SceneTable::Apply(const SourceListing& listing, base::MonotonicTime now,
                       Effects& effects) {
  for (auto& [name, entry] : scenes_) entry.UnlistAll();
  for (const ModelRef& model : listing.models) {
    if (!IsValidName(model.scene) || !IsValidName(model.version)) continue;
    scenes_.try_emplace(model.scene, model.scene, shared_)
        .first->second.List(model, effects);
  }
  for (auto scene = scenes_.begin(); scene != scenes_.end();) {
    SceneEntry& entry = scene->second;
    entry.EndListing(listing, now, effects);
    scene = entry.empty() ? scenes_.erase(scene) : std::next(scene);
  }
}

void SceneTable::Acquire(const std::string& name, const std::string& version,
                         AcquireDone done, base::MonotonicTime now,
                         Effects& effects) {
  if (SceneEntry* const entry = Find(name)) {
    entry->Acquire(version, std::move(done), now, effects);
  } else {
    effects.Answer(std::move(done), NoScene(name));
  }
}

void SceneTable::Load(const std::string& name, const std::string& version,
                      AcquireDone done, base::MonotonicTime now,
                      Effects& effects) {
  if (SceneEntry* const entry = Find(name)) {
    entry->Load(version, std::move(done), now, effects);
  } else {
    effects.Answer(std::move(done), NoScene(name));
  }
}

absl::Status SceneTable::Unload(const std::string& name,
                                const std::string& version, Effects& effects) {
  SceneEntry* const entry = Find(name);
  if (entry == nullptr) return NoScene(name);
  const absl::Status status = entry->Unload(version, effects);
  if (entry->empty()) scenes_.erase(name);
  return status;
}

void SceneTable::LoadWhatFits(base::MonotonicTime now) {
  for (auto& [name, entry] : scenes_) entry.LoadIfItFits(now);
}

void SceneTable::TurnAwayAll(Effects& effects) {
  for (auto& [name, entry] : scenes_) entry.TurnAwayAll(effects);
}

std::optional<SceneTable::Job> SceneTable::NextJob(uint64_t resident_bytes,
                                                   base::MonotonicTime now,
                                                   Effects& effects) {
  bool is_first = true;
  // Of loads before in the queue that wait for memory.
  uint64_t claimed_bytes = 0;
  for (size_t i = 0; i < shared_.queue.size();) {
    const LoadKey key = shared_.queue[i];
    const auto place = shared_.queue.begin() + static_cast<std::ptrdiff_t>(i);
    SceneEntry& entry = scenes_.at(key.scene);
    ModelVersion& version = entry.loading(key.version);
    const ModelRef& model = version.model();
    if (budget_.IsTooLarge(model.reserved_bytes())) {
      shared_.queue.erase(place);
      entry.Refuse(
          key.version,
          LargerThanBudget(model.reserved_bytes(), budget_.limit_bytes()), now,
          effects);
      continue;
    }
    if (budget_.Fits(claimed_bytes + model.reserved_bytes(), resident_bytes)) {
      shared_.queue.erase(place);
      version.Begin();
      budget_.Reserve(model.reserved_bytes());
      return Job{model};
    }
    if (version.purpose() == LoadPurpose::kIfItFits) {
      shared_.queue.erase(place);
      version.Drop();
      continue;
    }
    if (is_first) {
      MakeRoom(model, resident_bytes, effects);
      if (!effects.released.empty()) return std::nullopt;
      is_first = false;
    }
    claimed_bytes += model.reserved_bytes();
    ++i;
  }
  return std::nullopt;
}

void SceneTable::MakeRoom(const ModelRef& model, uint64_t resident_bytes,
                          Effects& effects) {
  std::vector<std::pair<SceneEntry*, ModelVersion*>> versions;
  std::vector<ResidentModel> held;
  for (auto& [name, entry] : scenes_) {
    for (ModelVersion* version : entry.Resident()) {
      versions.emplace_back(&entry, version);
      held.push_back({.bytes = version->resident_bytes(),
                      .last_use = version->last_use(),
                      .is_in_use = version->IsInUse(),
                      .is_same_scene = name == model.scene});
    }
  }
  for (const size_t i :
       budget_.ChooseToGo(held, model.reserved_bytes(), resident_bytes)) {
    const auto& [entry, version] = versions[i];
    entry->Evict(*version, effects);
  }
}

void SceneTable::Postpone(const Job& job, uint64_t memory_bytes) {
  budget_.Return(job.model.reserved_bytes());
  scenes_.at(job.model.scene)
      .loading(job.model.version)
      .Postpone(job.model, memory_bytes);
  shared_.queue.push_front({job.model.scene, job.model.version});
}

void SceneTable::Finish(
    const Job& job,
    absl::StatusOr<std::shared_ptr<const localizer::Localizer>> localizer,
    double seconds, base::MonotonicTime now, Effects& effects) {
  budget_.Return(job.model.reserved_bytes());
  load_times_.Add(seconds);
  SceneEntry& entry = scenes_.at(job.model.scene);
  entry.Finish(job.model, std::move(localizer), seconds, now, effects);
  if (entry.empty()) scenes_.erase(job.model.scene);
}

std::vector<ModelRef> SceneTable::Models() const {
  std::vector<ModelRef> models;
  for (const auto& [name, entry] : scenes_) {
    if (auto model = entry.Model()) models.push_back(*std::move(model));
  }
  return models;
}

std::vector<SceneStatus> SceneTable::List() const {
  std::vector<SceneStatus> list;
  list.reserve(scenes_.size());
  for (const auto& [name, entry] : scenes_) list.push_back(entry.status());
  return list;
}

absl::StatusOr<SceneStatus> SceneTable::Get(const std::string& name) const {
  const auto scene = scenes_.find(name);
  if (scene == scenes_.end()) return NoScene(name);
  return scene->second.status();
}

RepositoryStats SceneTable::Stats() const {
  RepositoryStats stats;
  stats.counts = shared_.counts;
  stats.load_times = load_times_;
  stats.swaps = shared_.swaps;
  stats.pending_loads = shared_.queue.size() + budget_.reservations();
  stats.memory_budget_bytes = budget_.limit_bytes();
  for (const auto& [name, entry] : scenes_) {
    stats.scenes.push_back(entry.stats());
    ++stats.scenes_by_state[static_cast<size_t>(stats.scenes.back().state)];
  }
  return stats;
}

}  // namespace treeline::repository
