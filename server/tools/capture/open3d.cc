#include "server/tools/capture/open3d.h"

#include <array>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/folder.h"
#include "common/base/status_macros.h"
#include "common/dataset/picture_files.h"
#include "server/tools/capture/conventions.h"
#include "server/tools/capture/json_text.h"
#include "server/tools/capture/picture_files.h"
#include "server/tools/capture/posed_pictures.h"

namespace treeline::capture {
namespace {

constexpr uint64_t kMaxTrajectoryBytes = 256u << 20;
constexpr const char* kColorFolders[] = {"image", "rgb", "color"};
constexpr const char* kTrajectories[] = {"scene/trajectory.log",
                                         "trajectory.log"};
constexpr const char* kCameras[] = {"camera_intrinsic.json", "intrinsic.json",
                                    "camera.json", "camera_primesense.json"};
constexpr image::ImageSize kPrimeSenseSize{640, 480};
constexpr std::array<double, 4> kPrimeSense{525, 525, 319.5, 239.5};

std::string FirstFile(const std::string& folder,
                      std::span<const char* const> names) {
  for (const char* name : names) {
    std::string path = absl::StrCat(folder, "/", name);
    if (base::IsFile(path)) return path;
  }
  return "";
}

// The names of pictures with their endings, JPEG before PNG, as Open3D has
// them.
std::vector<std::string> PicturesIn(const std::string& folder,
                                    std::span<const char* const> endings) {
  std::vector<std::string> paths;
  for (const char* ending : endings) {
    for (const std::string& stem : StemsIn(folder, ending)) {
      paths.push_back(absl::StrCat(folder, "/", stem, ending));
    }
  }
  return paths;
}

std::vector<std::string> ColorsIn(const std::string& folder) {
  constexpr const char* kEndings[] = {".jpg", ".png"};
  for (const char* name : kColorFolders) {
    std::vector<std::string> paths =
        PicturesIn(absl::StrCat(folder, "/", name), kEndings);
    if (!paths.empty()) return paths;
  }
  return {};
}

absl::StatusOr<std::vector<FrameFiles>> FilesIn(const std::string& folder) {
  constexpr const char* kEndings[] = {".png"};
  const std::vector<std::string> colors = ColorsIn(folder);
  const std::vector<std::string> depths =
      PicturesIn(folder + "/depth", kEndings);
  if (colors.size() != depths.size()) {
    return absl::InvalidArgumentError(absl::StrCat(
        folder, ": has ", colors.size(), " pictures and ", depths.size(),
        " depth maps; Open3D pairs them in the order of their names, so there "
        "must be as many"));
  }
  std::vector<FrameFiles> files;
  for (size_t i = 0; i < colors.size(); ++i) {
    files.push_back({.color = colors[i], .depth = depths[i], .confidence = {}});
  }
  return files;
}

absl::StatusOr<camera::Camera> ReadCamera(const std::string& path) {
  TL_ASSIGN_OR_RETURN(const Json json, ReadJsonObject(path));
  image::ImageSize size;
  TL_ASSIGN_OR_RETURN(size.width, SideOf(json, "width", path));
  TL_ASSIGN_OR_RETURN(size.height, SideOf(json, "height", path));
  const auto matrix = json.find("intrinsic_matrix");
  if (matrix == json.end()) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": has no \"intrinsic_matrix\""));
  }
  std::array<double, 9> k{};
  TL_RETURN_IF_ERROR(NumbersOf(*matrix, "intrinsic_matrix", path, k));
  const std::array<double, 4> pinhole{k[0], k[4], k[6], k[7]};
  auto camera =
      camera::Camera::Create(camera::CameraModel::kPinhole, size.width,
                             size.height, pinhole.data(), 4);
  if (!camera.ok()) return base::Annotate(camera.status(), path);
  return camera;
}

absl::StatusOr<camera::Camera> CameraOf(const std::string& folder,
                                        const std::string& picture,
                                        std::vector<std::string>& notes) {
  const std::string path = FirstFile(folder, kCameras);
  if (!path.empty()) return ReadCamera(path);
  TL_ASSIGN_OR_RETURN(const image::ImageSize size,
                      dataset::ReadPictureSize(picture));
  if (size != kPrimeSenseSize) {
    return absl::NotFoundError(absl::StrCat(
        folder, ": there is no ", kCameras[0], ", and pictures of ", size.width,
        " x ", size.height,
        " are not of Open3D's usual camera. Put the file of its "
        "\"path_intrinsic\" there: {\"width\": ",
        size.width, ", \"height\": ", size.height,
        ", \"intrinsic_matrix\": [fx, 0, 0, 0, fy, 0, cx, cy, 1]}"));
  }
  notes.push_back(absl::StrCat("no ", kCameras[0],
                               ": Open3D's usual camera (PrimeSense, 525 px)"));
  return camera::Camera::Create(camera::CameraModel::kPinhole, size.width,
                                size.height, kPrimeSense.data(), 4);
}

}  // namespace

bool IsOpen3d(const std::string& folder) {
  return !FirstFile(folder, kTrajectories).empty() &&
         !base::SortedNamesIn(folder + "/depth").empty() &&
         !ColorsIn(folder).empty();
}

absl::StatusOr<Capture> OpenOpen3d(const std::string& folder,
                                   const OpenOptions& options) {
  PosedPictures pictures;
  pictures.format = "open3d";
  TL_ASSIGN_OR_RETURN(pictures.z_up, ZUpFrom(options.up, "-y"));
  TL_ASSIGN_OR_RETURN(pictures.files, FilesIn(folder));
  const std::string trajectory = FirstFile(folder, kTrajectories);
  if (pictures.files.empty() || trajectory.empty()) {
    return absl::NotFoundError(
        absl::StrCat(folder,
                     ": needs color/, depth/ and scene/trajectory.log, which "
                     "Open3D's run_system.py --integrate writes"));
  }
  TL_ASSIGN_OR_RETURN(
      pictures.color,
      CameraOf(folder, pictures.files.front().color, pictures.notes));
  if (options.depth_unit_m > 0) pictures.depth_unit_m = options.depth_unit_m;
  TL_ASSIGN_OR_RETURN(const std::string text,
                      base::ReadFile(trajectory, kMaxTrajectoryBytes));
  TL_ASSIGN_OR_RETURN(pictures.poses, ParsePoseLog(text, trajectory));
  pictures.notes.emplace_back(
      "the world is that of the first picture, taken to be level (or say "
      "--up); pixel centres at integers");
  return CaptureOf(std::move(pictures));
}

}  // namespace treeline::capture
