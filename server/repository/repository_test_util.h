// For the tests of this folder: sources and models that tests command.
#ifndef SERVER_REPOSITORY_REPOSITORY_TEST_UTIL_H_
#define SERVER_REPOSITORY_REPOSITORY_TEST_UTIL_H_

#include <chrono>
#include <map>
#include <memory>
#include <stop_token>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "common/base/clock.h"
#include "server/core/localizer/localizer.h"
#include "server/repository/model_source.h"

namespace treeline::repository {

// A localizer that knows where it came from.
class FakeLocalizer final : public localizer::Localizer {
 public:
  explicit FakeLocalizer(std::string content) {
    info_.dataset = std::move(content);
  }
  absl::StatusOr<localizer::PoseEstimate> Localize(
      const image::Frame&, const localizer::LocalizeOptions&) const override {
    return localizer::PoseEstimate{};
  }
  const forest::ModelInfo& info() const override { return info_; }
  localizer::DepthUse depth_use() const override {
    return localizer::DepthUse::kIgnored;
  }

 private:
  forest::ModelInfo info_;
};

// Opens what begins with "good"; everything else is corrupt, but for what was
// written by a newer version, and what cannot be had now.
inline absl::StatusOr<std::unique_ptr<localizer::Localizer>> OpenContent(
    const std::string& content) {
  if (content == "newer") return absl::UnimplementedError("format 99");
  if (content == "away") return absl::UnavailableError("try later");
  if (content == "odd") return absl::InternalError("odd");
  if (content.substr(0, 4) != "good") {
    return absl::DataLossError("not a Treeline model");
  }
  return std::make_unique<FakeLocalizer>(content);
}

// A clock that stands still until it is set forward.
class ManualClock final : public base::Clock {
 public:
  base::MonotonicTime Now() const override {
    absl::MutexLock lock(&mutex_);
    return now_;
  }
  void Advance(std::chrono::milliseconds by) {
    absl::MutexLock lock(&mutex_);
    now_ += by;
  }

 private:
  mutable absl::Mutex mutex_;
  base::MonotonicTime now_ ABSL_GUARDED_BY(mutex_);
};

// Models in memory. What Fetch returns as a path is the model's content.
class FakeSource final : public ModelSource {
 public:
  absl::StatusOr<SourceListing> List() override {
    absl::MutexLock lock(&mutex_);
    ++lists_;
    if (!error_.ok()) return error_;
    SourceListing listing;
    for (const auto& [key, model] : models_)
      listing.models.push_back(model.ref);
    listing.scene_json = json_;
    return listing;
  }
  absl::StatusOr<std::string> Fetch(const ModelRef& ref,
                                    const std::stop_token&) override {
    return LocalPath(ref);
  }
  absl::StatusOr<std::string> LocalPath(const ModelRef& ref) override {
    absl::MutexLock lock(&mutex_);
    const auto found = models_.find({ref.scene, ref.version});
    if (found == models_.end()) return absl::NotFoundError("gone");
    return found->second.content;
  }

  // Adds a model, or renames another one into its place.
  void Put(const std::string& scene, const std::string& version,
           const std::string& content, uint64_t bytes = 1) {
    absl::MutexLock lock(&mutex_);
    const std::string id = std::to_string(++files_);
    models_[{scene, version}] = {{scene, version, bytes, id + ":0", id},
                                 content};
  }
  // Writes over the file itself.
  void Overwrite(const std::string& scene, const std::string& version,
                 const std::string& content) {
    absl::MutexLock lock(&mutex_);
    Model& model = models_.at({scene, version});
    model.content = content;
    model.ref.fingerprint += "+";
  }
  void Remove(const std::string& scene, const std::string& version) {
    absl::MutexLock lock(&mutex_);
    models_.erase({scene, version});
  }
  void SetJson(const std::string& scene, const std::string& json) {
    absl::MutexLock lock(&mutex_);
    json_[scene] = json;
  }
  void SetError(const absl::Status& error) {
    absl::MutexLock lock(&mutex_);
    error_ = error;
  }
  int lists() const {
    absl::MutexLock lock(&mutex_);
    return lists_;
  }

 private:
  struct Model {
    ModelRef ref;
    std::string content;
  };
  mutable absl::Mutex mutex_;
  std::map<std::pair<std::string, std::string>, Model> models_
      ABSL_GUARDED_BY(mutex_);
  std::map<std::string, std::string> json_ ABSL_GUARDED_BY(mutex_);
  absl::Status error_ ABSL_GUARDED_BY(mutex_);
  int files_ ABSL_GUARDED_BY(mutex_) = 0;
  int lists_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_REPOSITORY_TEST_UTIL_H_
