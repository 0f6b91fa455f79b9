#include "server/repository/folder_source.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "server/repository/names.h"
#include "server/repository/scene_metadata.h"

namespace treeline::repository {
namespace {

namespace fs = std::filesystem;

constexpr char kModelFileName[] = "model.treeline";
constexpr char kMetadataFileName[] = "scene.json";

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

// Nothing unless a file lies at `path`.
std::optional<struct stat> LookAtFile(const std::string& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0 || !S_ISREG(info.st_mode)) {
    return std::nullopt;
  }
  return info;
}

ModelRef RefOf(const std::string& scene, const std::string& version,
               const struct stat& info) {
  ModelRef ref;
  ref.scene = scene;
  ref.version = version;
  ref.bytes = static_cast<uint64_t>(info.st_size);
  ref.file_id = absl::StrCat(info.st_dev, ":", info.st_ino);
  ref.fingerprint = absl::StrCat(ref.file_id, ":", info.st_mtim.tv_sec, ".",
                                 info.st_mtim.tv_nsec, ":", info.st_size);
  return ref;
}

void AddMetadata(const fs::path& folder, const std::string& scene,
                 SourceListing& listing) {
  const std::string path = (folder / kMetadataFileName).string();
  absl::StatusOr<std::string> text = base::ReadFile(path, kMaxSceneJsonBytes);
  if (text.ok()) {
    listing.scene_json[scene] = *std::move(text);
  } else if (!absl::IsNotFound(text.status())) {
    listing.scene_json_errors[scene] = text.status();
  }
}

// Whether a path relative to the root is one that is listed.
bool IsInPlace(const fs::path& relative) {
  const std::vector<fs::path> parts(relative.begin(), relative.end());
  return parts.size() == 3 && parts[2] == kModelFileName &&
         IsValidName(parts[0].string()) && IsValidName(parts[1].string());
}

}  // namespace

std::vector<std::string> MisplacedModels(const std::string& root,
                                         size_t limit) {
  constexpr int kDeepest = 2;  // <scene>/<version>/
  std::vector<std::string> found;
  std::error_code error;
  fs::recursive_directory_iterator entry(
      root, fs::directory_options::skip_permission_denied, error);
  for (; !error && entry != fs::recursive_directory_iterator();
       entry.increment(error)) {
    const fs::path& path = entry->path();
    const bool is_hidden = path.filename().string().starts_with('.');
    if (is_hidden || entry.depth() == kDeepest) {
      entry.disable_recursion_pending();
    }
    const fs::path relative = path.lexically_relative(root);
    if (!is_hidden && path.extension() == ".treeline" && !IsInPlace(relative)) {
      found.push_back(relative.string());
    }
  }
  std::ranges::sort(found);
  if (found.size() > limit) found.resize(limit);
  return found;
}

FolderSource::FolderSource(std::string root) : root_(std::move(root)) {}

absl::StatusOr<SourceListing> FolderSource::List() {
  SourceListing listing;
  TL_ASSIGN_OR_RETURN(const std::vector<std::string> scenes, FoldersIn(root_));
  for (const std::string& scene : scenes) {
    const fs::path folder = fs::path(root_) / scene;
    // A scene's folder that cannot be read does not stop the others.
    const auto versions = FoldersIn(folder);
    if (!versions.ok()) continue;
    bool has_model = false;
    for (const std::string& version : *versions) {
      const auto file =
          LookAtFile((folder / version / kModelFileName).string());
      if (!file) continue;
      listing.models.push_back(RefOf(scene, version, *file));
      has_model = true;
    }
    if (has_model) AddMetadata(folder, scene, listing);
  }
  return listing;
}

absl::StatusOr<std::string> FolderSource::Fetch(const ModelRef& model,
                                                const std::stop_token&) {
  return LocalPath(model);
}

absl::StatusOr<std::string> FolderSource::LocalPath(const ModelRef& model) {
  std::string path =
      (fs::path(root_) / model.scene / model.version / kModelFileName).string();
  if (!LookAtFile(path)) {
    return absl::NotFoundError("the model file was removed");
  }
  return path;
}

}  // namespace treeline::repository
