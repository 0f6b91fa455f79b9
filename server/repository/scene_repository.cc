#include "server/repository/scene_repository.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/parallel_for.h"
#include "common/base/status_macros.h"

namespace treeline {
namespace {

namespace fs = std::filesystem;

constexpr char kModelFileName[] = "model.treeline";

// The valid names of the folders in `folder`.
absl::StatusOr<std::vector<std::string>> FoldersIn(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  fs::directory_iterator entries(folder, error);
  for (; !error && entries != fs::directory_iterator();
       entries.increment(error)) {
    std::error_code unreadable;
    const std::string name = entries->path().filename().string();
    if (IsValidName(name) && entries->is_directory(unreadable)) {
      names.push_back(name);
    }
  }
  if (error) {
    return absl::ErrnoToStatus(
        error.value(), absl::StrCat("reading folder ", folder.string()));
  }
  return names;
}

// Clients see why a model failed, but not where the server keeps it.
absl::Status WithoutPath(const absl::Status& status, const std::string& path) {
  const absl::string_view message =
      absl::StripPrefix(status.message(), absl::StrCat(path, ": "));
  return absl::Status(status.code(), message);
}

// Why a version does not answer, as the one who asked should see it.
absl::Status Unusable(const std::string& name, const std::string& version,
                      SceneState state, const absl::Status& failure) {
  const std::string what =
      absl::StrCat("scene '", name, "' version '", version, "'");
  if (state != SceneState::kFailed) {
    return absl::FailedPreconditionError(absl::StrCat(what, " is not loaded"));
  }
  const absl::StatusCode code = failure.code() == absl::StatusCode::kDataLoss
                                    ? absl::StatusCode::kDataLoss
                                    : absl::StatusCode::kFailedPrecondition;
  return absl::Status(
      code, absl::StrCat(what, " could not be loaded: ", failure.message()));
}

}  // namespace

absl::StatusOr<std::unique_ptr<SceneRepository>> SceneRepository::Open(
    const std::string& root, LocalizerOpener opener) {
  std::unique_ptr<SceneRepository> repository(
      new SceneRepository(std::move(opener)));
  TL_ASSIGN_OR_RETURN(const std::vector<VersionKey> found,
                      repository->Scan(root));
  ParallelFor(
      static_cast<int64_t>(found.size()), HardwareThreads(),
      [&](int64_t i) { repository->Load(found[static_cast<size_t>(i)]); });
  return repository;
}

absl::StatusOr<std::vector<SceneRepository::VersionKey>> SceneRepository::Scan(
    const std::string& root) {
  std::vector<VersionKey> added;
  TL_ASSIGN_OR_RETURN(const std::vector<std::string> scenes, FoldersIn(root));
  for (const std::string& scene : scenes) {
    const fs::path folder = fs::path(root) / scene;
    // A scene's folder that cannot be read does not stop the others.
    const auto versions = FoldersIn(folder);
    if (!versions.ok()) continue;
    for (const std::string& version : *versions) {
      const fs::path file = folder / version / kModelFileName;
      std::error_code unreadable;
      if (!fs::is_regular_file(file, unreadable)) continue;
      absl::MutexLock lock(&mutex_);
      scenes_[scene][version].model_path = file.string();
      added.push_back({scene, version});
    }
  }
  return added;
}

void SceneRepository::Load(const VersionKey& key) {
  std::string path;
  {
    absl::MutexLock lock(&mutex_);
    Version& version = scenes_[key.scene][key.version];
    version.state = SceneState::kLoading;
    path = version.model_path;
  }
  absl::StatusOr<std::unique_ptr<Localizer>> localizer = opener_(path);
  absl::MutexLock lock(&mutex_);
  Version& version = scenes_[key.scene][key.version];
  if (!localizer.ok()) {
    version.state = SceneState::kFailed;
    version.failure = WithoutPath(localizer.status(), path);
    return;
  }
  version.state = SceneState::kReady;
  version.scene = std::make_shared<const Scene>(
      Scene{key.scene, key.version, *std::move(localizer)});
}

absl::StatusOr<std::shared_ptr<const Scene>> SceneRepository::Acquire(
    const std::string& name, const std::string& version) const {
  TL_RETURN_IF_ERROR(CheckName("scene", name));
  if (!version.empty()) TL_RETURN_IF_ERROR(CheckName("model_version", version));
  absl::MutexLock lock(&mutex_);
  const auto scene = scenes_.find(name);
  if (scene == scenes_.end()) {
    return absl::NotFoundError(absl::StrCat("no scene '", name, "'"));
  }
  if (version.empty()) {
    SceneStatus status = StatusOf(name, scene->second);
    if (status.serving != nullptr) return std::move(status.serving);
    return Unusable(name, status.versions.front().version, status.state,
                    status.failure);
  }
  const auto wanted = scene->second.find(version);
  if (wanted == scene->second.end()) {
    return absl::NotFoundError(
        absl::StrCat("scene '", name, "' has no version '", version, "'"));
  }
  if (wanted->second.scene != nullptr) return wanted->second.scene;
  return Unusable(name, version, wanted->second.state, wanted->second.failure);
}

std::vector<SceneStatus> SceneRepository::List() const {
  absl::MutexLock lock(&mutex_);
  std::vector<SceneStatus> list;
  list.reserve(scenes_.size());
  for (const auto& [name, versions] : scenes_) {
    list.push_back(StatusOf(name, versions));
  }
  return list;
}

absl::StatusOr<SceneStatus> SceneRepository::Get(
    const std::string& name) const {
  TL_RETURN_IF_ERROR(CheckName("scene", name));
  absl::MutexLock lock(&mutex_);
  const auto scene = scenes_.find(name);
  if (scene == scenes_.end()) {
    return absl::NotFoundError(absl::StrCat("no scene '", name, "'"));
  }
  return StatusOf(name, scene->second);
}

SceneStatus SceneRepository::StatusOf(const std::string& name,
                                      const Versions& versions) {
  SceneStatus status;
  status.name = name;
  for (const auto& [version, entry] : versions) {
    status.versions.push_back({version, entry.state, entry.failure});
    if (status.serving == nullptr) status.serving = entry.scene;
  }
  // Scan() makes no scene without a version.
  status.state = status.versions.front().state;
  status.failure = status.versions.front().failure;
  if (status.serving != nullptr) {
    status.state = SceneState::kReady;
    status.failure = absl::OkStatus();
  }
  return status;
}

}  // namespace treeline
