// Loads and memory of the table: what is loaded next, and what goes for it.
#include <algorithm>
#include <tuple>

#include "server/repository/load_failure.h"
#include "server/repository/scene_table.h"

namespace treeline::repository {
namespace {

// After the first failure that may pass; each further one doubles it.
constexpr std::chrono::seconds kFirstRetry{1};
constexpr int kMostDoublings = 6;

// Whether a query, or whoever else got it, has this scene or its model.
bool IsInUse(const std::shared_ptr<const Scene>& scene) {
  return scene.use_count() > 1 || scene->localizer.use_count() > 1;
}

}  // namespace

void SceneTable::StartLoad(Version& version) {
  if (version.loading) return;
  version.loading = true;
  version.failure = absl::OkStatus();
  queue_.push_back({version.model.scene, version.model.version});
}

void SceneTable::LoadWhatFits(base::MonotonicTime now) {
  for (auto& [name, entry] : scenes_) {
    Version* const target = Target(entry, now);
    if (target == nullptr || target->scene != nullptr || target->loading) {
      continue;
    }
    StartLoad(*target);
    target->if_fits = true;
  }
}

std::optional<SceneTable::Job> SceneTable::NextJob(uint64_t resident_bytes,
                                                   base::MonotonicTime now,
                                                   Effects& effects) {
  bool is_first = true;
  // Of loads before in the queue that wait for memory.
  uint64_t claimed_bytes = 0;
  for (size_t i = 0; i < queue_.size();) {
    Entry& entry = scenes_.at(queue_[i].scene);
    Version& version = entry.versions.at(queue_[i].version);
    const ModelRef& model = version.model;
    const bool is_too_large = budget_bytes_ != 0 && model.bytes > budget_bytes_;
    if (!is_too_large && (budget_bytes_ == 0 ||
                          Fits(claimed_bytes + model.bytes, resident_bytes))) {
      queue_.erase(queue_.begin() + static_cast<std::ptrdiff_t>(i));
      version.running = true;
      ++running_;
      reserved_bytes_ += model.bytes;
      return Job{model};
    }
    if (is_too_large || version.if_fits) {
      queue_.erase(queue_.begin() + static_cast<std::ptrdiff_t>(i));
      version.loading = false;
      version.if_fits = false;
      if (is_too_large) {
        NoteFailure(entry, version,
                    LargerThanBudget(model.bytes, budget_bytes_), now, effects);
        Settle(entry, now, effects);
      }
      continue;
    }
    if (is_first) {
      MakeRoom(model, resident_bytes, effects);
      if (!effects.released.empty()) return std::nullopt;
      is_first = false;
    }
    claimed_bytes += model.bytes;
    ++i;
  }
  return std::nullopt;
}

void SceneTable::MakeRoom(const ModelRef& model, uint64_t resident_bytes,
                          Effects& effects) {
  // The idle ones first, the longest unused of them first; last what serves the
  // very scene, so that there is no gap.
  struct Candidate {
    std::tuple<bool, bool, uint64_t> order;
    Entry* entry;
    Version* version;
  };
  std::vector<Candidate> candidates;
  for (auto& [name, entry] : scenes_) {
    for (auto& [number, version] : entry.versions) {
      if (version.scene == nullptr) continue;
      candidates.push_back(
          {{name == model.scene, IsInUse(version.scene), version.last_use},
           &entry,
           &version});
    }
  }
  std::ranges::sort(candidates, {}, &Candidate::order);
  // Memory that will come free without anything being done: models that were
  // let go and are still used, and loads at work, which may be let go after.
  uint64_t coming =
      resident_bytes - std::min(resident_bytes, held_bytes_) + reserved_bytes_;
  uint64_t used = resident_bytes + reserved_bytes_ + model.bytes;
  for (const Candidate& candidate : candidates) {
    if (used <= budget_bytes_) return;
    const uint64_t bytes = candidate.version->loaded.bytes;
    if (IsInUse(candidate.version->scene)) {
      // It goes when its queries have ended; as many as are needed.
      if (used - std::min(used, coming) <= budget_bytes_) return;
      coming += bytes;
    } else {
      used -= std::min(used, bytes);
    }
    ++candidate.entry->counts.evictions;
    ++counts_.evictions;
    Release(*candidate.version, effects);
    effects.events.push_back({.kind = RepositoryEvent::Kind::kEvicted,
                              .scene = candidate.entry->name,
                              .version = candidate.version->model.version,
                              .bytes = bytes});
  }
}

void SceneTable::Release(Version& version, Effects& effects) {
  if (version.scene == nullptr) return;
  held_bytes_ -= version.loaded.bytes;
  effects.released.push_back(std::move(version.scene));
  version.scene = nullptr;
  version.named = false;
}

void SceneTable::Finish(
    const Job& job,
    absl::StatusOr<std::shared_ptr<const localizer::Localizer>> localizer,
    double seconds, base::MonotonicTime now, Effects& effects) {
  const auto found = scenes_.find(job.model.scene);
  Entry& entry = found->second;
  Version& version = entry.versions.at(job.model.version);
  --running_;
  reserved_bytes_ -= job.model.bytes;
  load_times_.Add(seconds);
  version.running = false;
  version.loading = false;
  const bool is_preload = std::exchange(version.if_fits, false);
  const bool has_changed = version.model.fingerprint != job.model.fingerprint;
  // While it was read.
  const bool was_overwritten = has_changed && !version.model.file_id.empty() &&
                               version.model.file_id == job.model.file_id;
  if (localizer.ok() && !was_overwritten) {
    Install(entry, version, job, *std::move(localizer), effects);
    effects.events.push_back({.kind = RepositoryEvent::Kind::kLoaded,
                              .scene = entry.name,
                              .version = job.model.version,
                              .bytes = job.model.bytes,
                              .seconds = seconds});
  } else if (localizer.ok()) {
    effects.released.push_back(std::make_shared<const Scene>(
        Scene{entry.name, job.model.version, *std::move(localizer)}));
  } else if (!has_changed) {
    NoteFailure(entry, version, localizer.status(), now, effects);
  }
  if (has_changed && version.listed) StartLoad(version);
  Settle(entry, now, effects);
  if (is_preload && StateOf(entry) != SceneState::kReady) {
    Version* const older = Target(entry, now);
    if (older != nullptr && !older->loading) {
      StartLoad(*older);
      older->if_fits = true;
    }
  }
  Tidy(entry);
  if (entry.versions.empty()) scenes_.erase(found);
}

void SceneTable::Install(Entry& entry, Version& version, const Job& job,
                         std::shared_ptr<const localizer::Localizer> localizer,
                         Effects& effects) {
  if (version.scene != nullptr) ++swaps_;
  const bool was_named = version.named;
  Release(version, effects);
  version.named = was_named;
  version.scene = std::make_shared<const Scene>(Scene{
      entry.name, job.model.version, std::move(localizer), entry.metadata});
  version.loaded = job.model;
  version.last_use = ++uses_;
  version.failure = absl::OkStatus();
  version.failures = 0;
  held_bytes_ += job.model.bytes;
  ++entry.counts.loads;
  ++counts_.loads;
}

void SceneTable::NoteFailure(Entry& entry, Version& version,
                             const absl::Status& failure,
                             base::MonotonicTime now, Effects& effects) {
  ++entry.counts.load_failures;
  ++counts_.load_failures;
  version.failure = failure;
  version.retry_at =
      now + kFirstRetry * (1 << std::min(version.failures, kMostDoublings));
  ++version.failures;
  effects.events.push_back({.kind = RepositoryEvent::Kind::kLoadFailed,
                            .scene = entry.name,
                            .version = version.model.version,
                            .status = failure});
}

}  // namespace treeline::repository
