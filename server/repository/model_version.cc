#include "server/repository/model_version.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "server/repository/load_failure.h"

namespace treeline::repository {
namespace {

// After the first failure that may pass; each further one doubles it.
constexpr std::chrono::seconds kFirstRetry{1};
constexpr int kMaxDoublings = 6;

}  // namespace

ModelVersion::FileChange ModelVersion::List(const ModelRef& model) {
  is_listed_ = true;
  if (model_.fingerprint == model.fingerprint) return FileChange::kNone;
  const bool is_same_file =
      !model.file_id.empty() && model.file_id == model_.file_id;
  model_ = model;
  failures_ = 0;
  if (has_failed()) load_ = NotLoading{};
  return is_same_file ? FileChange::kOverwritten : FileChange::kReplaced;
}

bool ModelVersion::IsInUse() const {
  return resident_ && (resident_->scene.use_count() > 1 ||
                       resident_->scene->localizer.use_count() > 1);
}

std::shared_ptr<const Scene> ModelVersion::Use(uint64_t use) {
  resident_->last_use = use;
  return resident_->scene;
}

std::shared_ptr<const Scene> ModelVersion::Install(
    std::shared_ptr<const Scene> scene, const ModelRef& model, uint64_t use) {
  std::shared_ptr<const Scene> before;
  if (resident_) before = std::move(resident_->scene);
  resident_ = {std::move(scene), model, use};
  failures_ = 0;
  if (has_failed()) load_ = NotLoading{};
  return before;
}

std::shared_ptr<const Scene> ModelVersion::SetMetadata(
    std::shared_ptr<const SceneMetadata> metadata) {
  const Scene& scene = *resident_->scene;
  return std::exchange(
      resident_->scene,
      std::make_shared<const Scene>(Scene{
          scene.name, scene.version, scene.localizer, std::move(metadata)}));
}

std::shared_ptr<const Scene> ModelVersion::Release() {
  if (!resident_) return nullptr;
  std::shared_ptr<const Scene> scene = std::move(resident_->scene);
  resident_.reset();
  is_named_ = false;
  return scene;
}

bool ModelVersion::is_loading() const {
  return std::holds_alternative<Queued>(load_) ||
         std::holds_alternative<AtWork>(load_);
}

const absl::Status* ModelVersion::failure() const {
  const auto* failed = std::get_if<Failed>(&load_);
  return failed == nullptr ? nullptr : &failed->failure;
}

base::MonotonicTime ModelVersion::retry_at() const {
  const auto* failed = std::get_if<Failed>(&load_);
  return failed == nullptr ? base::MonotonicTime{} : failed->retry_at;
}

bool ModelVersion::MayLoad(base::MonotonicTime now) const {
  const auto* failed = std::get_if<Failed>(&load_);
  return failed == nullptr ||
         (IsTransient(failed->failure) && now >= failed->retry_at);
}

bool ModelVersion::Queue(LoadPurpose purpose) {
  if (is_loading()) return false;
  load_ = Queued{purpose};
  return true;
}

void ModelVersion::Want() {
  if (auto* queued = std::get_if<Queued>(&load_)) {
    queued->purpose = LoadPurpose::kWanted;
  } else if (auto* at_work = std::get_if<AtWork>(&load_)) {
    at_work->purpose = LoadPurpose::kWanted;
  }
}

LoadPurpose ModelVersion::purpose() const {
  return std::get<Queued>(load_).purpose;
}

void ModelVersion::Begin() { load_ = AtWork{purpose()}; }

void ModelVersion::Postpone(const ModelRef& model, uint64_t memory_bytes) {
  if (model.fingerprint == model_.fingerprint) {
    model_.memory_bytes = memory_bytes;
  }
  load_ = Queued{std::get<AtWork>(load_).purpose};
}

void ModelVersion::Drop() { load_ = NotLoading{}; }

LoadPurpose ModelVersion::End() {
  const LoadPurpose purpose = std::get<AtWork>(load_).purpose;
  load_ = NotLoading{};
  return purpose;
}

void ModelVersion::Fail(const absl::Status& failure, base::MonotonicTime now) {
  load_ = Failed{failure,
                 now + kFirstRetry * (1 << std::min(failures_, kMaxDoublings))};
  ++failures_;
}

SceneState ModelVersion::state() const {
  if (is_resident()) return SceneState::kReady;
  if (is_loading()) return SceneState::kLoading;
  return has_failed() ? SceneState::kFailed : SceneState::kUnloaded;
}

VersionStatus ModelVersion::status() const {
  return {.version = model_.version,
          .state = state(),
          .failure = has_failed() ? *failure() : absl::OkStatus(),
          .resident_bytes = resident_bytes(),
          .listed = is_listed_};
}

}  // namespace treeline::repository
