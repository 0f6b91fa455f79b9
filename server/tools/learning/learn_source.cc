#include "server/tools/learning/learn_source.h"

#include <filesystem>
#include <system_error>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/folder.h"
#include "common/base/status_macros.h"
#include "server/tools/training_place.h"

namespace treeline::learning {
namespace {

namespace fs = std::filesystem;

constexpr const char* kUriPrefixes[] = {
    "7scenes:", "12scenes:", "tum:", "colmap:", "nvm:"};

bool IsFolder(const std::string& path) {
  std::error_code error;
  return fs::is_directory(path, error);
}

std::string WithoutSlashes(std::string path) {
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  return path;
}

bool IsSevenScenes(const std::string& folder) {
  for (const std::string& name : base::SortedNamesIn(folder)) {
    if (absl::StartsWith(name, "seq-") &&
        IsFolder(absl::StrCat(folder, "/", name))) {
      return true;
    }
  }
  return false;
}

// As COLMAP itself and programs beside it lay their models out: `sparse/0` and
// so on of its mapper, `sparse` of its image_undistorter. The one of most
// images, as the sizes of its files tell. Empty: there is none.
std::string ColmapModelIn(const std::string& folder) {
  const std::string sparse = folder + "/sparse";
  std::vector<std::string> models = {sparse};
  for (const std::string& name : base::SortedNamesIn(sparse)) {
    models.push_back(absl::StrCat(sparse, "/", name));
  }
  std::string best;
  uintmax_t most = 0;
  for (const std::string& model : models) {
    for (const char* file : {"/images.bin", "/images.txt"}) {
      std::error_code error;
      const uintmax_t bytes = fs::file_size(model + file, error);
      if (error || bytes <= most) continue;
      most = bytes;
      best = model;
    }
  }
  return best;
}

// The URI of a folder in the layout of a data set; empty: it has none.
std::string UriOfFolder(const std::string& folder) {
  if (base::IsFile(folder + "/rgb.txt")) return "tum:" + folder;
  if (base::IsFile(folder + "/info.txt") && IsFolder(folder + "/data")) {
    return "12scenes:" + folder;
  }
  // As `treeline import` writes photographs.
  if (IsFolder(folder + "/model") && IsFolder(folder + "/images")) {
    return absl::StrCat("colmap:", folder, "/model,", folder, "/images");
  }
  // Where there is transforms.json too, it says more: it may have depth.
  if (IsFolder(folder + "/images") &&
      !base::IsFile(folder + "/transforms.json")) {
    const std::string model = ColmapModelIn(folder);
    if (!model.empty()) {
      return absl::StrCat("colmap:", model, ",", folder, "/images");
    }
  }
  return IsSevenScenes(folder) ? "7scenes:" + folder : "";
}

// What lies beside the frames of a recording.
void LookInto(const std::string& folder, LearnSource& source) {
  source.has_cameras = base::IsFile(folder + "/cameras.json");
  const std::string train = folder + "/train.txt";
  const std::string test = folder + "/test.txt";
  if (!base::IsFile(train) || !base::IsFile(test)) return;
  source.train_list = train;
  source.test_list = test;
}

// The folder that a URI names; empty where it names a file or two folders.
std::string FolderOfUri(const std::string& uri) {
  std::string path = uri.substr(uri.find(':') + 1);
  return IsFolder(path) ? WithoutSlashes(std::move(path)) : "";
}

}  // namespace

absl::StatusOr<LearnSource> FindLearnSource(const std::string& given) {
  LearnSource source;
  for (const char* prefix : kUriPrefixes) {
    if (!absl::StartsWith(given, prefix)) continue;
    source.kind = SourceKind::kRecording;
    source.uri = given;
    const std::string folder = FolderOfUri(given);
    if (!folder.empty()) LookInto(folder, source);
    return source;
  }
  const std::string path = WithoutSlashes(given);
  std::error_code error;
  if (!fs::exists(path, error)) {
    return absl::NotFoundError(absl::StrCat("there is no ", path));
  }
  if (!IsFolder(path)) return source;
  if (base::IsFile(path + "/bundle.yaml")) {
    source.kind = SourceKind::kMapBundle;
    TL_ASSIGN_OR_RETURN(source.scene, tools::SceneOfMapBundle(path));
    source.uri = absl::StrCat("7scenes:", path, "/keyframes");
    source.calibration_path = path + "/keyframes/calibration.json";
    return source;
  }
  source.uri = UriOfFolder(path);
  if (source.uri.empty()) return source;
  source.kind = SourceKind::kRecording;
  LookInto(path, source);
  return source;
}

std::string SceneNameOf(const std::string& given) {
  std::string path = given;
  for (const char* prefix : kUriPrefixes) {
    if (absl::StartsWith(path, prefix)) path = path.substr(path.find(':') + 1);
  }
  path = WithoutSlashes(path.substr(0, path.find(',')));
  std::error_code error;
  const fs::path absolute =
      WithoutSlashes(fs::absolute(path, error).lexically_normal().string());
  const std::string name =
      IsFolder(path) ? absolute.filename().string() : absolute.stem().string();
  // What a URL and a shell take as it is.
  std::string scene;
  for (const char c : name) {
    scene += absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '-' ||
                     c == '_'
                 ? c
                 : '-';
  }
  return scene.empty() ? "scene" : scene;
}

absl::Status CheckLearnable(const dataset::Dataset& dataset,
                            const std::string& method,
                            const std::string& given) {
  int with_pose = 0;
  int with_depth = 0;
  for (int i = 0; i < dataset.size(); ++i) {
    with_pose += dataset.frame(i).world_from_camera.has_value();
    with_depth += !dataset.frame(i).depth_path.empty();
  }
  if (with_pose == 0 && with_depth > 0) {
    return absl::FailedPreconditionError(absl::StrCat(
        given, ": no frame has a pose. Find the poses from the depth images:\n",
        "  treeline-agent map --rgbd ", dataset.uri(),
        " --output map\n  treeline learn map\n"
        "docs/how-to/learn-a-place.md says more"));
  }
  if (method == "sift") {
    if (dataset.structure() != nullptr) return absl::OkStatus();
    return absl::FailedPreconditionError(absl::StrCat(
        given,
        ": method sift learns from a structure from motion (colmap:, nvm:); "
        "docs/how-to/learn-from-photographs.md"));
  }
  if (with_pose > 0 && with_depth > 0) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(
      given,
      with_pose == 0 ? ": no frame has a pose, and none has depth. "
                     : ": no frame has depth. ",
      "Pictures alone need structure from motion: "
      "docs/how-to/learn-from-photographs.md"));
}

std::string LeftOutText(const dataset::Dataset& dataset,
                        const std::string& method) {
  int without_pose = 0;
  int without_depth = 0;
  for (int i = 0; i < dataset.size(); ++i) {
    const dataset::DatasetFrame& frame = dataset.frame(i);
    if (!frame.world_from_camera) {
      ++without_pose;
    } else if (frame.depth_path.empty() && method != "sift") {
      ++without_depth;
    }
  }
  std::string text;
  if (const auto& missing = dataset.missing_pictures(); missing.count > 0) {
    absl::StrAppend(&text, missing.count,
                    missing.count == 1 ? " image whose picture is"
                                       : " images whose pictures are",
                    " missing (the first: ", missing.first, ")");
  }
  if (without_pose + without_depth == 0) return text;
  absl::StrAppend(&text, text.empty() ? "" : "; ", without_pose,
                  " frames without a pose, ", without_depth,
                  " without depth, of ", dataset.size());
  return text;
}

}  // namespace treeline::learning
