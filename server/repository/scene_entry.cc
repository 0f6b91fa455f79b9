#include "server/repository/scene_entry.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "server/repository/load_failure.h"

namespace treeline::repository {

void SceneEntry::UnlistAll() {
  for (auto& [name, version] : versions_) version.Unlist();
}

void SceneEntry::List(const ModelRef& model, TableEffects& effects) {
  const auto [found, is_new] = versions_.try_emplace(model.version, model);
  if (is_new) return;
  ModelVersion& version = found->second;
  const ModelVersion::FileChange change = version.List(model);
  if (change == ModelVersion::FileChange::kNone || !version.is_resident()) {
    return;
  }
  // What is in memory stays what was verified, and serves on until the file is
  // found to be good.
  if (change == ModelVersion::FileChange::kOverwritten) {
    effects.events.push_back(
        {RepositoryEvent::Kind::kOverwritten, name_, model.version});
  }
  Queue(version, LoadPurpose::kWanted);
}

void SceneEntry::EndListing(const SourceListing& listing,
                            base::MonotonicTime now, TableEffects& effects) {
  ApplyMetadata(listing, effects);
  Settle(now, effects);
  Tidy();
}

void SceneEntry::ApplyMetadata(const SourceListing& listing,
                               TableEffects& effects) {
  const SceneJson::Change change = json_.Apply(SceneJson::Of(name_, listing));
  if (change.is_problem) {
    effects.events.push_back({.kind = RepositoryEvent::Kind::kBadMetadata,
                              .scene = name_,
                              .status = json_.problem()});
  }
  if (!change.of_metadata) return;
  for (ModelVersion* version : Resident()) {
    effects.released.push_back(version->SetMetadata(json_.metadata()));
  }
}

void SceneEntry::Tidy() {
  std::erase_if(versions_, [](const auto& item) {
    const ModelVersion& version = item.second;
    return !version.is_listed() && !version.is_loading() &&
           !version.is_resident();
  });
}

ModelVersion* SceneEntry::Target(base::MonotonicTime now) {
  for (auto& [name, version] : versions_) {
    if (version.is_listed() && (version.is_resident() || version.is_loading() ||
                                version.MayLoad(now))) {
      return &version;
    }
  }
  return nullptr;
}

const ModelVersion* SceneEntry::Serving() const {
  const auto serving = versions_.find(serving_);
  return serving == versions_.end() || !serving->second.is_resident()
             ? nullptr
             : &serving->second;
}

ModelVersion* SceneEntry::Serving() {
  return const_cast<ModelVersion*>(std::as_const(*this).Serving());
}

void SceneEntry::Queue(ModelVersion& version, LoadPurpose purpose) {
  if (version.Queue(purpose)) {
    shared_.queue.push_back({name_, version.model().version});
  }
}

void SceneEntry::Settle(base::MonotonicTime now, TableEffects& effects) {
  ModelVersion* const target = Target(now);
  ModelVersion* const serving = Serving();
  if (target != nullptr && target->is_resident()) {
    if (serving != nullptr && serving != target) ++shared_.swaps;
    if (serving != target) {
      effects.events.push_back(
          {RepositoryEvent::Kind::kTookOver, name_, target->model().version});
    }
    serving_ = target->model().version;
    for (ModelVersion* version : Resident()) {
      if (version != target && !version->is_named()) {
        Release(*version, effects);
      }
    }
  } else if (target != nullptr && serving != nullptr) {
    Queue(*target, LoadPurpose::kWanted);
  }
  for (Waiter& waiter : std::exchange(waiters_, {})) {
    Add(std::move(waiter), now, effects);
  }
}

void SceneEntry::Add(Waiter waiter, base::MonotonicTime now,
                     TableEffects& effects) {
  Answer answer = Resolve(waiter, now);
  if (answer) {
    effects.Answer(std::move(waiter.done), *std::move(answer));
  } else {
    waiters_.push_back(std::move(waiter));
  }
}

SceneEntry::Answer SceneEntry::Resolve(const Waiter& waiter,
                                       base::MonotonicTime now) {
  return waiter.version.empty() ? ResolveNewest(now)
                                : ResolveNamed(waiter, now);
}

SceneEntry::Answer SceneEntry::ResolveNamed(const Waiter& waiter,
                                            base::MonotonicTime now) {
  const auto found = versions_.find(waiter.version);
  if (found == versions_.end()) return NoVersion(name_, waiter.version);
  ModelVersion& version = found->second;
  const bool wants_load = waiter.until == Until::kLoadHasEnded;
  const bool is_enough =
      !wants_load || (!version.is_loading() && !version.has_failed());
  if (version.is_resident() && is_enough) return Use(version);
  if (!version.is_loading()) {
    if (!version.is_listed()) return NoVersion(name_, waiter.version);
    if (wants_load ? version.has_failed() : !version.MayLoad(now)) {
      return FailureOf(version, now);
    }
  }
  Queue(version, LoadPurpose::kWanted);
  version.Want();
  return std::nullopt;
}

SceneEntry::Answer SceneEntry::ResolveNewest(base::MonotonicTime now) {
  ModelVersion* const target = Target(now);
  if (target != nullptr) {
    if (target->is_resident()) return Use(*target);
    Queue(*target, LoadPurpose::kWanted);
    target->Want();
  }
  if (ModelVersion* const serving = Serving()) return Use(*serving);
  if (target != nullptr) return std::nullopt;
  if (const auto resident = Resident(); !resident.empty()) {
    return Use(*resident.front());
  }
  for (const auto& [name, version] : versions_) {
    if (version.is_listed()) return FailureOf(version, now);
  }
  return NoScene(name_);
}

absl::Status SceneEntry::FailureOf(const ModelVersion& version,
                                   base::MonotonicTime now) const {
  return LoadError(name_, version.model().version, *version.failure(),
                   std::chrono::ceil<std::chrono::milliseconds>(
                       std::max(version.retry_at() - now, {})));
}

void SceneEntry::Acquire(const std::string& version, AcquireDone done,
                         base::MonotonicTime now, TableEffects& effects) {
  const auto wanted = versions_.find(version);
  if (wanted != versions_.end()) wanted->second.SetNamed();
  Add({version, Until::kInMemory, std::move(done)}, now, effects);
}

void SceneEntry::Load(const std::string& version, AcquireDone done,
                      base::MonotonicTime now, TableEffects& effects) {
  auto wanted = versions_.find(version);
  if (version.empty()) {
    wanted = std::ranges::find_if(
        versions_, [](const auto& item) { return item.second.is_listed(); });
  }
  // If the source has none any more, the newest in memory has to do.
  const std::string chosen =
      wanted == versions_.end() ? version : wanted->first;
  if (wanted != versions_.end() && wanted->second.is_listed()) {
    ModelVersion& state = wanted->second;
    if (!version.empty()) state.SetNamed();
    if (state.has_failed() || !state.is_resident()) {
      Queue(state, LoadPurpose::kWanted);
    }
    state.Want();
  }
  Add({chosen, Until::kLoadHasEnded, std::move(done)}, now, effects);
}

absl::Status SceneEntry::Unload(const std::string& version,
                                TableEffects& effects) {
  if (!version.empty() && !versions_.contains(version)) {
    return NoVersion(name_, version);
  }
  for (ModelVersion* candidate : Resident()) {
    const std::string& name = candidate->model().version;
    if (!version.empty() && name != version) continue;
    const uint64_t bytes = candidate->resident_bytes();
    Release(*candidate, effects);
    effects.events.push_back({.kind = RepositoryEvent::Kind::kUnloaded,
                              .scene = name_,
                              .version = name,
                              .bytes = bytes});
  }
  Tidy();
  return absl::OkStatus();
}

void SceneEntry::LoadIfItFits(base::MonotonicTime now) {
  ModelVersion* const target = Target(now);
  if (target == nullptr || target->is_resident()) return;
  Queue(*target, LoadPurpose::kIfItFits);
}

void SceneEntry::TurnAwayAll(TableEffects& effects) {
  for (Waiter& waiter : std::exchange(waiters_, {})) {
    effects.Answer(std::move(waiter.done), Stopping(name_));
  }
}

void SceneEntry::Refuse(const std::string& version, const absl::Status& failure,
                        base::MonotonicTime now, TableEffects& effects) {
  NoteFailure(versions_.at(version), failure, now, effects);
  Settle(now, effects);
}

void SceneEntry::Finish(
    const ModelRef& model,
    absl::StatusOr<std::shared_ptr<const localizer::Localizer>> localizer,
    double seconds, base::MonotonicTime now, TableEffects& effects) {
  ModelVersion& version = versions_.at(model.version);
  const LoadPurpose purpose = version.End();
  const bool has_changed = version.model().fingerprint != model.fingerprint;
  if (localizer.ok()) {
    Install(version, model, *std::move(localizer), effects);
    effects.events.push_back({.kind = RepositoryEvent::Kind::kLoaded,
                              .scene = name_,
                              .version = model.version,
                              .bytes = model.reserved_bytes(),
                              .seconds = seconds});
  } else if (!has_changed) {
    NoteFailure(version, localizer.status(), now, effects);
  }
  if (has_changed && version.is_listed()) {
    Queue(version, LoadPurpose::kWanted);
  }
  Settle(now, effects);
  if (purpose == LoadPurpose::kIfItFits && state() != SceneState::kReady) {
    LoadIfItFits(now);  // the one before it
  }
  Tidy();
}

void SceneEntry::Install(ModelVersion& version, const ModelRef& model,
                         std::shared_ptr<const localizer::Localizer> localizer,
                         TableEffects& effects) {
  auto scene = std::make_shared<const Scene>(
      Scene{name_, model.version, std::move(localizer), json_.metadata()});
  if (auto before = version.Install(std::move(scene), model, ++shared_.uses)) {
    ++shared_.swaps;
    effects.released.push_back(std::move(before));
  }
  Count(&LoadCounts::loads);
}

void SceneEntry::NoteFailure(ModelVersion& version, const absl::Status& failure,
                             base::MonotonicTime now, TableEffects& effects) {
  Count(&LoadCounts::load_failures);
  version.Fail(failure, now);
  effects.events.push_back({.kind = RepositoryEvent::Kind::kLoadFailed,
                            .scene = name_,
                            .version = version.model().version,
                            .status = failure});
}

std::vector<ModelVersion*> SceneEntry::Resident() {
  std::vector<ModelVersion*> resident;
  for (auto& [name, version] : versions_) {
    if (version.is_resident()) resident.push_back(&version);
  }
  return resident;
}

void SceneEntry::Evict(ModelVersion& version, TableEffects& effects) {
  Count(&LoadCounts::evictions);
  const uint64_t bytes = version.resident_bytes();
  Release(version, effects);
  effects.events.push_back({.kind = RepositoryEvent::Kind::kEvicted,
                            .scene = name_,
                            .version = version.model().version,
                            .bytes = bytes});
}

void SceneEntry::Release(ModelVersion& version, TableEffects& effects) {
  if (auto scene = version.Release()) {
    effects.released.push_back(std::move(scene));
  }
}

void SceneEntry::Count(uint64_t LoadCounts::*what) {
  ++(counts_.*what);
  ++(shared_.counts.*what);
}

uint64_t SceneEntry::resident_bytes() const {
  uint64_t bytes = 0;
  for (const auto& [name, version] : versions_) {
    bytes += version.resident_bytes();
  }
  return bytes;
}

SceneState SceneEntry::state() const {
  const bool is_ready = std::ranges::any_of(
      versions_, [](const auto& item) { return item.second.is_resident(); });
  // A table keeps no scene without a version.
  return is_ready ? SceneState::kReady : versions_.begin()->second.state();
}

SceneStatus SceneEntry::status() const {
  SceneStatus status;
  status.name = name_;
  status.state = state();
  if (status.state == SceneState::kFailed) {
    status.failure = *versions_.begin()->second.failure();
  }
  if (const ModelVersion* serving = Serving()) {
    status.serving = serving->scene();
  }
  for (const auto& [name, version] : versions_) {
    status.versions.push_back(version.status());
  }
  status.metadata = json_.metadata();
  status.metadata_problem = json_.problem();
  status.resident_bytes = resident_bytes();
  return status;
}

SceneStats SceneEntry::stats() const {
  return {name_, state(), counts_, resident_bytes()};
}

std::optional<ModelRef> SceneEntry::Model() const {
  if (const ModelVersion* serving = Serving()) return serving->loaded();
  for (const auto& [name, version] : versions_) {
    if (version.is_listed() && !version.has_failed()) return version.model();
  }
  return std::nullopt;
}

}  // namespace treeline::repository
