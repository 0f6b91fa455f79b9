#include "server/tools/capture/replica.h"

#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
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
constexpr const char* kCameraFile = "cam_params.json";

struct ReplicaCamera {
  camera::Camera camera;
  double depth_unit_m = 0;
};

// Of the scenes that NICE-SLAM offers.
constexpr image::ImageSize kReleasedSize{1200, 680};
constexpr std::array<double, 4> kReleasedPinhole{600, 600, 599.5, 339.5};
constexpr double kReleasedUnit_m = 1 / 6553.5;

absl::StatusOr<ReplicaCamera> ReadCamera(const std::string& path) {
  TL_ASSIGN_OR_RETURN(const Json file, ReadJsonObject(path));
  const auto found = file.find("camera");
  if (found == file.end() || !found->is_object()) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": has no \"camera\": {...}"));
  }
  const Json& json = *found;
  image::ImageSize size;
  TL_ASSIGN_OR_RETURN(size.width, SideOf(json, "w", path));
  TL_ASSIGN_OR_RETURN(size.height, SideOf(json, "h", path));
  std::array<double, 4> pinhole{};
  const char* const names[] = {"fx", "fy", "cx", "cy"};
  for (size_t i = 0; i < pinhole.size(); ++i) {
    TL_ASSIGN_OR_RETURN(pinhole[i], NumberOf(json, names[i], path));
  }
  const bool is_plain = json.contains("scale");
  TL_ASSIGN_OR_RETURN(
      const double units,
      NumberOf(json, is_plain ? "scale" : "png_depth_scale", path));
  if (!(units >= 1)) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": scale is ", units,
                     "; it must be 1 unit of depth a metre or "
                     "more"));
  }
  auto camera =
      camera::Camera::Create(camera::CameraModel::kPinhole, size.width,
                             size.height, pinhole.data(), 4);
  if (!camera.ok()) return base::Annotate(camera.status(), path);
  return ReplicaCamera{*std::move(camera), 1 / units};
}

// The file's, or that of the released scenes, where the pictures are like them.
absl::StatusOr<ReplicaCamera> CameraOf(const std::string& folder,
                                       const std::string& picture,
                                       std::vector<std::string>& notes) {
  for (const char* place : {"/", "/../"}) {
    const std::string path = absl::StrCat(folder, place, kCameraFile);
    if (base::IsFile(path)) return ReadCamera(path);
  }
  TL_ASSIGN_OR_RETURN(const image::ImageSize size,
                      dataset::ReadPictureSize(picture));
  if (size != kReleasedSize) {
    return absl::NotFoundError(absl::StrCat(
        folder, ": there is no ", kCameraFile,
        " here or above, and pictures of ", size.width, " x ", size.height,
        " are not of NICE-SLAM's camera. Write one: {\"camera\": {\"w\": ",
        size.width, ", \"h\": ", size.height,
        ", \"fx\": ..., \"fy\": ..., \"cx\": ..., \"cy\": ..., \"scale\": "
        "units "
        "of depth a metre}}"));
  }
  notes.push_back(
      absl::StrCat("no ", kCameraFile, ": NICE-SLAM's camera was taken"));
  TL_ASSIGN_OR_RETURN(
      camera::Camera camera,
      camera::Camera::Create(camera::CameraModel::kPinhole, size.width,
                             size.height, kReleasedPinhole.data(), 4));
  return ReplicaCamera{std::move(camera), kReleasedUnit_m};
}

std::vector<FrameFiles> FilesIn(const std::string& results) {
  std::vector<FrameFiles> files;
  for (const char* ending : {".jpg", ".png"}) {
    for (const std::string& stem : StemsIn(results, ending)) {
      absl::string_view number = stem;
      if (!absl::ConsumePrefix(&number, "frame")) continue;
      files.push_back(
          {.color = absl::StrCat(results, "/", stem, ending),
           .depth = IfFile(absl::StrCat(results, "/depth", number, ".png")),
           .confidence = {}});
    }
  }
  return files;
}

}  // namespace

bool IsReplica(const std::string& folder) {
  return base::IsFile(folder + "/traj.txt") &&
         !base::SortedNamesIn(folder + "/results").empty();
}

absl::StatusOr<Capture> OpenReplica(const std::string& folder,
                                    const OpenOptions& options) {
  PosedPictures pictures;
  pictures.format = "replica";
  TL_ASSIGN_OR_RETURN(pictures.z_up, ZUpFrom(options.up, "z"));
  pictures.files = FilesIn(folder + "/results");
  if (pictures.files.empty()) {
    return absl::NotFoundError(
        absl::StrCat(folder, "/results: has no frame*.jpg"));
  }
  TL_ASSIGN_OR_RETURN(
      const ReplicaCamera camera,
      CameraOf(folder, pictures.files.front().color, pictures.notes));
  pictures.color = camera.camera;
  pictures.depth_unit_m =
      options.depth_unit_m > 0 ? options.depth_unit_m : camera.depth_unit_m;
  const std::string trajectory = folder + "/traj.txt";
  TL_ASSIGN_OR_RETURN(const std::string text,
                      base::ReadFile(trajectory, kMaxTrajectoryBytes));
  TL_ASSIGN_OR_RETURN(pictures.poses, ParsePoseLines(text, trajectory));
  pictures.notes.emplace_back("poses as they are; pixel centres at integers");
  return CaptureOf(std::move(pictures));
}

}  // namespace treeline::capture
