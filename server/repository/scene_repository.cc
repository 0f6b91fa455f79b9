#include "server/repository/scene_repository.h"

#include <condition_variable>
#include <mutex>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "server/repository/load_failure.h"

namespace treeline::repository {
namespace {

constexpr int kMaxLoaderThreads = 64;

// Clients see why a model failed, but not where the server keeps it.
absl::Status WithoutPath(const absl::Status& status, const std::string& path) {
  absl::Status stripped(
      status.code(),
      absl::StripPrefix(status.message(), absl::StrCat(path, ": ")));
  status.ForEachPayload([&](absl::string_view key, const absl::Cord& value) {
    stripped.SetPayload(key, value);
  });
  return stripped;
}

}  // namespace

absl::Status RepositoryOptions::Validate() const {
  if (loader_threads < 1 || loader_threads > kMaxLoaderThreads) {
    return absl::InvalidArgumentError(
        absl::StrCat("loader threads is ", loader_threads,
                     "; it must be between 1 and ", kMaxLoaderThreads));
  }
  if (poll_interval.count() < 0) {
    return absl::InvalidArgumentError("the poll interval is negative");
  }
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<SceneRepository>> SceneRepository::Open(
    std::unique_ptr<ModelSource> source, LocalizerOpener opener,
    const RepositoryOptions& options, const base::Clock& clock) {
  TL_RETURN_IF_ERROR(options.Validate());
  std::unique_ptr<SceneRepository> repository(new SceneRepository(
      std::move(source), std::move(opener), options, clock));
  TL_RETURN_IF_ERROR(repository->Rescan());
  repository->StartThreads();
  return repository;
}

SceneRepository::SceneRepository(std::unique_ptr<ModelSource> source,
                                 LocalizerOpener opener,
                                 const RepositoryOptions& options,
                                 const base::Clock& clock)
    : source_(std::move(source)),
      opener_(std::move(opener)),
      options_(options),
      clock_(clock),
      shared_(std::make_shared<Shared>()),
      table_(options.memory_budget_bytes) {}

SceneRepository::~SceneRepository() { Stop(); }

void SceneRepository::Carry(SceneTable::Effects& effects) const {
  effects.released.clear();
  if (options_.on_event != nullptr) {
    for (const RepositoryEvent& event : effects.events) {
      options_.on_event(event);
    }
  }
  effects.events.clear();
  for (const std::function<void()>& answer : effects.answers) answer();
  effects.answers.clear();
}

void SceneRepository::StartThreads() {
  if (options_.load_all_at_start) {
    absl::MutexLock lock(&shared_->mutex);
    table_.LoadWhatFits(clock_.Now());
  }
  for (int i = 0; i < options_.loader_threads; ++i) {
    threads_.emplace_back(
        [this](const std::stop_token& stop) { RunLoader(stop); });
  }
  if (options_.poll_interval.count() > 0) {
    threads_.emplace_back(
        [this](const std::stop_token& stop) { RunPoll(stop); });
  }
}

void SceneRepository::Stop() {
  SceneTable::Effects effects;
  {
    absl::MutexLock lock(&shared_->mutex);
    stopping_ = true;
    table_.TurnAwayAll(effects);
    Wake();
  }
  for (std::jthread& thread : threads_) thread.request_stop();
  Carry(effects);
  std::deque<std::function<void()>> tasks;
  threads_.clear();
  {
    absl::MutexLock lock(&shared_->mutex);
    tasks = std::move(tasks_);
    tasks_.clear();
  }
  // They see that it stops, and answer so.
  for (const std::function<void()>& task : tasks) task();
}

void SceneRepository::RunLoader(const std::stop_token& stop) {
  while (true) {
    SceneTable::Effects effects;
    std::optional<SceneTable::Job> job;
    std::function<void()> task;
    {
      absl::MutexLock lock(&shared_->mutex);
      while (!stopping_) {
        if (!tasks_.empty()) {
          task = std::move(tasks_.front());
          tasks_.pop_front();
          break;
        }
        const bool was_settled = table_.is_settled();
        job = table_.NextJob(shared_->resident_bytes, clock_.Now(), effects);
        if (job || !effects.empty()) break;
        // The last load was dropped. (Without a change nobody is woken: loaders
        // would go on waking each other.)
        if (table_.is_settled() && !was_settled) Wake();
        shared_->changed.Wait(&shared_->mutex);
      }
      if (stopping_ && !task && !job && effects.empty()) return;
    }
    Carry(effects);
    if (task) task();
    if (job) RunJob(*job, stop);
  }
}

std::optional<absl::StatusOr<std::unique_ptr<localizer::Localizer>>>
SceneRepository::OpenModel(const SceneTable::Job& job,
                           const std::stop_token& stop) {
  const absl::StatusOr<std::string> path = source_->Fetch(job.model, stop);
  if (!path.ok()) return path.status();
  if (options_.read_memory_bytes != nullptr) {
    const absl::StatusOr<uint64_t> memory_bytes =
        options_.read_memory_bytes(*path);
    if (memory_bytes.ok() && *memory_bytes > job.model.reserved_bytes()) {
      absl::MutexLock lock(&shared_->mutex);
      table_.Postpone(job, *memory_bytes);
      Wake();
      return std::nullopt;
    }
  }
  absl::StatusOr<std::unique_ptr<localizer::Localizer>> localizer =
      opener_(*path);
  if (!localizer.ok()) return WithoutPath(localizer.status(), *path);
  return localizer;
}

void SceneRepository::RunJob(const SceneTable::Job& job,
                             const std::stop_token& stop) {
  const base::MonotonicTime start = clock_.Now();
  // For as long as the model is in memory, so that it can be loaded again, also
  // by another process, when the source is out of reach.
  std::shared_ptr<const void> kept = source_->Keep(job.model);
  auto maybe_opened = OpenModel(job, stop);
  if (!maybe_opened) return;
  absl::StatusOr<std::unique_ptr<localizer::Localizer>>& opened = *maybe_opened;
  const base::MonotonicTime end = clock_.Now();
  absl::StatusOr<std::shared_ptr<const localizer::Localizer>> localizer;
  if (!opened.ok()) {
    localizer = opened.status();
  } else {
    localizer = std::shared_ptr<const localizer::Localizer>(
        opened->release(),
        [shared = shared_, bytes = job.model.reserved_bytes(),
         kept = std::move(kept)](const localizer::Localizer* gone) {
          delete gone;
          absl::MutexLock lock(&shared->mutex);
          shared->resident_bytes -= bytes;
          shared->changed.SignalAll();
        });
  }
  SceneTable::Effects effects;
  {
    absl::MutexLock lock(&shared_->mutex);
    if (localizer.ok()) shared_->resident_bytes += job.model.reserved_bytes();
    table_.Finish(job, std::move(localizer),
                  std::chrono::duration<double>(end - start).count(), end,
                  effects);
    Wake();
  }
  Carry(effects);
}

void SceneRepository::RunPoll(const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  while (!never.wait_for(lock, stop, options_.poll_interval,
                         [&] { return stop.stop_requested(); })) {
    // What failed is counted; all stays as it was.
    (void)Rescan();
  }
}

void SceneRepository::AcquireAsync(const std::string& name,
                                   const std::string& version,
                                   AcquireDone done) {
  if (const absl::Status valid = CheckSceneAndVersion(name, version);
      !valid.ok()) {
    done(valid);
    return;
  }
  SceneTable::Effects effects;
  {
    absl::MutexLock lock(&shared_->mutex);
    table_.Acquire(name, version, std::move(done), clock_.Now(), effects);
    if (stopping_) table_.TurnAwayAll(effects);
    if (table_.has_queued()) Wake();
  }
  Carry(effects);
}

absl::StatusOr<std::shared_ptr<const Scene>> SceneRepository::Acquire(
    const std::string& name, const std::string& version,
    const std::stop_token& stop) {
  // It may be called after this has been cancelled.
  struct Waiting {
    std::mutex mutex;
    std::condition_variable_any answered;
    std::optional<absl::StatusOr<std::shared_ptr<const Scene>>> answer;
  };
  const auto waiting = std::make_shared<Waiting>();
  AcquireAsync(name, version,
               [waiting](absl::StatusOr<std::shared_ptr<const Scene>> scene) {
                 const std::lock_guard lock(waiting->mutex);
                 waiting->answer = std::move(scene);
                 waiting->answered.notify_all();
               });
  std::unique_lock lock(waiting->mutex);
  if (!waiting->answered.wait(lock, stop,
                              [&] { return waiting->answer.has_value(); })) {
    return absl::CancelledError(
        absl::StrCat("while scene '", name, "' was loaded"));
  }
  return *std::move(waiting->answer);
}

bool SceneRepository::IsStopping() const {
  absl::MutexLock lock(&shared_->mutex);
  return stopping_;
}

void SceneRepository::Load(const std::string& name, const std::string& version,
                           StatusDone done) {
  {
    absl::MutexLock lock(&shared_->mutex);
    if (!stopping_) {
      tasks_.push_back([this, name, version, done = std::move(done)] {
        LoadNow(name, version, done);
      });
      Wake();
      return;
    }
  }
  done(Stopping(name));
}

void SceneRepository::LoadNow(const std::string& name,
                              const std::string& version, StatusDone done) {
  absl::Status valid = CheckSceneAndVersion(name, version);
  if (valid.ok() && IsStopping()) valid = Stopping(name);
  if (valid.ok()) valid = Rescan();
  if (!valid.ok()) {
    done(valid);
    return;
  }
  SceneTable::Effects effects;
  {
    absl::MutexLock lock(&shared_->mutex);
    table_.Load(
        name, version,
        [this, name, done = std::move(done)](
            const absl::StatusOr<std::shared_ptr<const Scene>>& scene) {
          if (scene.ok()) {
            done(Get(name));
          } else {
            done(scene.status());
          }
        },
        clock_.Now(), effects);
    if (stopping_) table_.TurnAwayAll(effects);
    Wake();
  }
  Carry(effects);
}

absl::StatusOr<SceneStatus> SceneRepository::Unload(
    const std::string& name, const std::string& version) {
  TL_RETURN_IF_ERROR(CheckSceneAndVersion(name, version));
  SceneTable::Effects effects;
  absl::StatusOr<SceneStatus> status;
  {
    absl::MutexLock lock(&shared_->mutex);
    TL_RETURN_IF_ERROR(table_.Unload(name, version, effects));
    status = table_.Get(name);
    // It was in memory only.
    if (!status.ok()) status = SceneStatus{.name = name};
  }
  Carry(effects);
  return status;
}

absl::Status SceneRepository::Rescan() {
  uint64_t number = 0;
  {
    absl::MutexLock lock(&shared_->mutex);
    number = ++listings_;
  }
  const absl::StatusOr<SourceListing> listing = source_->List();
  SceneTable::Effects effects;
  {
    absl::MutexLock lock(&shared_->mutex);
    last_rescan_ = listing.status();
    if (!listing.ok()) {
      ++rescan_failures_;
      return listing.status();
    }
    ++rescans_;
    // One that began later has been applied.
    if (number < applied_listing_) return absl::OkStatus();
    applied_listing_ = number;
    table_.Apply(*listing, clock_.Now(), effects);
    Wake();
  }
  Carry(effects);
  return absl::OkStatus();
}

absl::Status SceneRepository::WaitForLoads(const std::stop_token& stop) {
  const std::stop_callback wake(stop, [this] {
    absl::MutexLock lock(&shared_->mutex);
    Wake();
  });
  absl::MutexLock lock(&shared_->mutex);
  while (!table_.is_settled() && !stopping_ && !stop.stop_requested()) {
    shared_->changed.Wait(&shared_->mutex);
  }
  return table_.is_settled() ? absl::OkStatus()
                             : absl::CancelledError("while models were loaded");
}

std::vector<ModelRef> SceneRepository::Models() const {
  absl::MutexLock lock(&shared_->mutex);
  return table_.Models();
}

std::vector<SceneStatus> SceneRepository::List() const {
  absl::MutexLock lock(&shared_->mutex);
  return table_.List();
}

absl::StatusOr<SceneStatus> SceneRepository::Get(
    const std::string& name) const {
  TL_RETURN_IF_ERROR(CheckSceneAndVersion(name, ""));
  absl::MutexLock lock(&shared_->mutex);
  return table_.Get(name);
}

RepositoryStats SceneRepository::Stats() const {
  absl::MutexLock lock(&shared_->mutex);
  RepositoryStats stats = table_.Stats();
  stats.rescans = rescans_;
  stats.rescan_failures = rescan_failures_;
  stats.last_rescan = last_rescan_;
  stats.resident_bytes = shared_->resident_bytes;
  return stats;
}

}  // namespace treeline::repository
