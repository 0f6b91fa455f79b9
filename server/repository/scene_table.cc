#include "server/repository/scene_table.h"

#include <algorithm>
#include <chrono>

#include "absl/strings/str_cat.h"
#include "server/repository/load_failure.h"

namespace treeline::repository {
namespace {

// The answer is moved on, so that nobody but the one who asked holds the scene.
void PushAnswer(AcquireDone done,
                absl::StatusOr<std::shared_ptr<const Scene>> answer,
                SceneTable::Effects& effects) {
  effects.answers.push_back(
      [done = std::move(done), answer = std::move(answer)]() mutable {
        done(std::move(answer));
      });
}

}  // namespace

void SceneTable::Apply(const SourceListing& listing, base::MonotonicTime now,
                       Effects& effects) {
  for (auto& [name, entry] : scenes_) {
    for (auto& [version, state] : entry.versions) state.listed = false;
  }
  for (const ModelRef& model : listing.models) {
    if (IsValidName(model.scene) && IsValidName(model.version)) {
      ApplyModel(model, effects);
    }
  }
  for (auto scene = scenes_.begin(); scene != scenes_.end();) {
    Entry& entry = scene->second;
    ApplyMetadata(entry, listing, effects);
    Settle(entry, now, effects);
    Tidy(entry);
    scene = entry.versions.empty() ? scenes_.erase(scene) : std::next(scene);
  }
}

void SceneTable::ApplyModel(const ModelRef& model, Effects& effects) {
  Entry& entry = scenes_[model.scene];
  entry.name = model.scene;
  const auto [found, is_new] = entry.versions.try_emplace(model.version);
  Version& version = found->second;
  version.listed = true;
  if (is_new) {
    version.model = model;
    return;
  }
  if (version.model.fingerprint == model.fingerprint) return;
  version.model = model;
  version.failure = absl::OkStatus();
  version.failures = 0;
  if (version.scene == nullptr) return;
  // What is mapped is no longer what was verified: nobody else may get it.
  if (!model.file_id.empty() && model.file_id == version.loaded.file_id) {
    Release(version, effects);
    effects.events.push_back(
        {RepositoryEvent::Kind::kOverwritten, model.scene, model.version});
  }
  StartLoad(version);
}

void SceneTable::ApplyMetadata(Entry& entry, const SourceListing& listing,
                               Effects& effects) {
  const auto unreadable = listing.scene_json_errors.find(entry.name);
  if (unreadable != listing.scene_json_errors.end()) {
    // Without the message: it tells where the server keeps its files.
    const absl::Status problem = absl::InvalidArgumentError(
        absl::StrCat("scene.json: cannot be read: ",
                     absl::StatusCodeToString(unreadable->second.code())));
    if (entry.metadata_problem == problem) return;
    entry.metadata_problem = problem;
    effects.events.push_back({.kind = RepositoryEvent::Kind::kBadMetadata,
                              .scene = entry.name,
                              .status = problem});
    entry.json.reset();
    return;
  }
  const auto text = listing.scene_json.find(entry.name);
  std::shared_ptr<const SceneMetadata> metadata;
  if (text != listing.scene_json.end()) {
    if (entry.json == text->second) return;
    entry.json = text->second;
    const absl::StatusOr<SceneMetadata> parsed =
        ParseSceneMetadata(text->second);
    entry.metadata_problem = parsed.status();
    if (!parsed.ok()) {
      effects.events.push_back({.kind = RepositoryEvent::Kind::kBadMetadata,
                                .scene = entry.name,
                                .status = parsed.status()});
      return;
    }
    metadata = std::make_shared<const SceneMetadata>(*parsed);
  } else {
    entry.json.reset();
    entry.metadata_problem = absl::OkStatus();
    if (entry.metadata == nullptr) return;
  }
  entry.metadata = std::move(metadata);
  for (auto& [name, version] : entry.versions) {
    if (version.scene == nullptr) continue;
    effects.released.push_back(std::exchange(
        version.scene,
        std::make_shared<const Scene>(Scene{
            entry.name, name, version.scene->localizer, entry.metadata})));
  }
}

void SceneTable::Tidy(Entry& entry) {
  std::erase_if(entry.versions, [](const auto& item) {
    const Version& version = item.second;
    return !version.listed && !version.loading && version.scene == nullptr;
  });
}

bool SceneTable::MayLoad(const Version& version, base::MonotonicTime now) {
  return version.failure.ok() ||
         (IsTransient(version.failure) && now >= version.retry_at);
}

SceneTable::Version* SceneTable::Target(Entry& entry, base::MonotonicTime now) {
  for (auto& [name, version] : entry.versions) {
    if (version.listed && (version.scene != nullptr || version.loading ||
                           MayLoad(version, now))) {
      return &version;
    }
  }
  return nullptr;
}

const SceneTable::Version* SceneTable::Serving(const Entry& entry) {
  const auto serving = entry.versions.find(entry.serving);
  return serving == entry.versions.end() || serving->second.scene == nullptr
             ? nullptr
             : &serving->second;
}

std::shared_ptr<const Scene> SceneTable::Use(Version& version) {
  version.last_use = ++uses_;
  return version.scene;
}

SceneTable::Answer SceneTable::ResolveNamed(Entry& entry, const Waiter& waiter,
                                            base::MonotonicTime now) {
  const auto found = entry.versions.find(waiter.version);
  if (found == entry.versions.end()) {
    return NoVersion(entry.name, waiter.version);
  }
  Version& version = found->second;
  if (version.scene != nullptr && !(waiter.fresh && version.loading) &&
      !(waiter.fresh && !version.failure.ok())) {
    return Use(version);
  }
  if (!version.loading) {
    if (!version.listed) return NoVersion(entry.name, waiter.version);
    if (waiter.fresh ? !version.failure.ok() : !MayLoad(version, now)) {
      return FailureOf(entry, version, now);
    }
  }
  version.if_fits = false;
  StartLoad(version);
  return std::nullopt;
}

SceneTable::Answer SceneTable::ResolveNewest(Entry& entry,
                                             base::MonotonicTime now) {
  Version* const target = Target(entry, now);
  if (target != nullptr && target->scene != nullptr) return Use(*target);
  if (target != nullptr) {
    target->if_fits = false;
    StartLoad(*target);
  }
  if (Version* const serving = Serving(entry)) return Use(*serving);
  if (target != nullptr) return std::nullopt;
  for (auto& [name, version] : entry.versions) {
    if (version.scene != nullptr) return Use(version);
  }
  for (const auto& [name, version] : entry.versions) {
    if (version.listed) return FailureOf(entry, version, now);
  }
  return NoScene(entry.name);
}

absl::Status SceneTable::FailureOf(const Entry& entry, const Version& version,
                                   base::MonotonicTime now) {
  return LoadError(entry.name, version.model.version, version.failure,
                   std::chrono::ceil<std::chrono::milliseconds>(
                       std::max(version.retry_at - now, {})));
}

void SceneTable::Settle(Entry& entry, base::MonotonicTime now,
                        Effects& effects) {
  Version* const target = Target(entry, now);
  Version* const serving = Serving(entry);
  if (target != nullptr && target->scene != nullptr) {
    if (serving != nullptr && serving != target) ++swaps_;
    if (serving != target) {
      effects.events.push_back({RepositoryEvent::Kind::kTookOver, entry.name,
                                target->model.version});
    }
    entry.serving = target->model.version;
    for (auto& [name, version] : entry.versions) {
      if (&version != target && !version.named) Release(version, effects);
    }
  } else if (target != nullptr && serving != nullptr) {
    StartLoad(*target);
  }
  AnswerWaiters(entry, now, effects);
}

void SceneTable::AnswerWaiters(Entry& entry, base::MonotonicTime now,
                               Effects& effects) {
  std::vector<Waiter> still_waiting;
  for (Waiter& waiter : entry.waiters) {
    Answer answer = Resolve(entry, waiter, now);
    if (!answer) {
      still_waiting.push_back(std::move(waiter));
      continue;
    }
    PushAnswer(std::move(waiter.done), *std::move(answer), effects);
  }
  entry.waiters = std::move(still_waiting);
}

void SceneTable::Add(Entry& entry, Waiter waiter, base::MonotonicTime now,
                     Effects& effects) {
  Answer answer = Resolve(entry, waiter, now);
  if (!answer) {
    entry.waiters.push_back(std::move(waiter));
    return;
  }
  PushAnswer(std::move(waiter.done), *std::move(answer), effects);
}

SceneTable::Answer SceneTable::Resolve(Entry& entry, const Waiter& waiter,
                                       base::MonotonicTime now) {
  return waiter.version.empty() ? ResolveNewest(entry, now)
                                : ResolveNamed(entry, waiter, now);
}

void SceneTable::Acquire(const std::string& name, const std::string& version,
                         AcquireDone done, base::MonotonicTime now,
                         Effects& effects) {
  const auto found = scenes_.find(name);
  if (found == scenes_.end()) {
    PushAnswer(std::move(done), NoScene(name), effects);
    return;
  }
  Entry& entry = found->second;
  const auto wanted = entry.versions.find(version);
  if (wanted != entry.versions.end()) wanted->second.named = true;
  Add(entry, {version, false, std::move(done)}, now, effects);
}

void SceneTable::Load(const std::string& name, const std::string& version,
                      AcquireDone done, base::MonotonicTime now,
                      Effects& effects) {
  const auto found = scenes_.find(name);
  if (found == scenes_.end()) {
    PushAnswer(std::move(done), NoScene(name), effects);
    return;
  }
  Entry& entry = found->second;
  auto wanted = entry.versions.find(version);
  if (version.empty()) {
    wanted = std::find_if(entry.versions.begin(), entry.versions.end(),
                          [](const auto& item) { return item.second.listed; });
  }
  // If the source has none any more, the newest in memory has to do.
  const std::string chosen =
      wanted == entry.versions.end() ? version : wanted->first;
  if (wanted != entry.versions.end() && wanted->second.listed) {
    Version& state = wanted->second;
    if (!version.empty()) state.named = true;
    if (!state.failure.ok() || state.scene == nullptr) StartLoad(state);
    state.if_fits = false;
  }
  Add(entry, {chosen, true, std::move(done)}, now, effects);
}

absl::Status SceneTable::Unload(const std::string& name,
                                const std::string& version, Effects& effects) {
  const auto found = scenes_.find(name);
  if (found == scenes_.end()) return NoScene(name);
  Versions& versions = found->second.versions;
  if (!version.empty() && !versions.contains(version)) {
    return NoVersion(name, version);
  }
  for (auto& [candidate, state] : versions) {
    if (state.scene == nullptr) continue;
    if (!version.empty() && candidate != version) continue;
    Release(state, effects);
    effects.events.push_back({.kind = RepositoryEvent::Kind::kUnloaded,
                              .scene = name,
                              .version = candidate,
                              .bytes = state.loaded.bytes});
  }
  Tidy(found->second);
  if (versions.empty()) scenes_.erase(found);
  return absl::OkStatus();
}

void SceneTable::TurnAwayAll(Effects& effects) {
  for (auto& [name, entry] : scenes_) {
    for (Waiter& waiter : entry.waiters) {
      PushAnswer(std::move(waiter.done), Stopping(name), effects);
    }
    entry.waiters.clear();
  }
}

SceneState SceneTable::StateOf(const Version& version) {
  if (version.scene != nullptr) return SceneState::kReady;
  if (version.loading) return SceneState::kLoading;
  return version.failure.ok() ? SceneState::kUnloaded : SceneState::kFailed;
}

SceneState SceneTable::StateOf(const Entry& entry) {
  const bool is_ready = std::any_of(
      entry.versions.begin(), entry.versions.end(),
      [](const auto& item) { return item.second.scene != nullptr; });
  // Apply() leaves no scene without a version.
  return is_ready ? SceneState::kReady
                  : StateOf(entry.versions.begin()->second);
}

uint64_t SceneTable::BytesOf(const Entry& entry) {
  uint64_t bytes = 0;
  for (const auto& [name, version] : entry.versions) {
    if (version.scene != nullptr) bytes += version.loaded.bytes;
  }
  return bytes;
}

SceneStatus SceneTable::StatusOf(const Entry& entry) {
  SceneStatus status;
  status.name = entry.name;
  status.state = StateOf(entry);
  if (status.state == SceneState::kFailed) {
    status.failure = entry.versions.begin()->second.failure;
  }
  if (const Version* serving = Serving(entry)) status.serving = serving->scene;
  for (const auto& [name, version] : entry.versions) {
    status.versions.push_back(
        {name, StateOf(version), version.failure,
         version.scene == nullptr ? 0 : version.loaded.bytes, version.listed});
  }
  status.metadata = entry.metadata;
  status.metadata_problem = entry.metadata_problem;
  status.resident_bytes = BytesOf(entry);
  return status;
}

std::vector<ModelRef> SceneTable::Models() const {
  std::vector<ModelRef> models;
  for (const auto& [name, entry] : scenes_) {
    if (const Version* serving = Serving(entry)) {
      models.push_back(serving->loaded);
      continue;
    }
    for (const auto& [version_name, version] : entry.versions) {
      if (!version.listed || !version.failure.ok()) continue;
      models.push_back(version.model);
      break;
    }
  }
  return models;
}

std::vector<SceneStatus> SceneTable::List() const {
  std::vector<SceneStatus> list;
  list.reserve(scenes_.size());
  for (const auto& [name, entry] : scenes_) list.push_back(StatusOf(entry));
  return list;
}

absl::StatusOr<SceneStatus> SceneTable::Get(const std::string& name) const {
  const auto scene = scenes_.find(name);
  if (scene == scenes_.end()) return NoScene(name);
  return StatusOf(scene->second);
}

RepositoryStats SceneTable::Stats() const {
  RepositoryStats stats;
  stats.counts = counts_;
  stats.load_times = load_times_;
  stats.swaps = swaps_;
  stats.pending_loads = queue_.size() + running_;
  stats.memory_budget_bytes = budget_bytes_;
  for (const auto& [name, entry] : scenes_) {
    const SceneState state = StateOf(entry);
    ++stats.scenes_by_state[static_cast<size_t>(state)];
    stats.scenes.push_back({name, state, entry.counts, BytesOf(entry)});
  }
  return stats;
}

}  // namespace treeline::repository
