#include "server/tools/capture/arkit_json.h"

#include <array>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/folder.h"
#include "common/base/status_macros.h"
#include "common/dataset/picture_files.h"
#include "server/tools/capture/conventions.h"
#include "server/tools/capture/json_text.h"
#include "server/tools/capture/picture_files.h"

namespace treeline::capture {
namespace {

constexpr uint64_t kMaxFrameJsonBytes = 4u << 20;

absl::StatusOr<geometry::Rigid3> PoseFromArkit(
    const std::array<double, 16>& matrix, const std::string& where) {
  const auto pose = geometry::RigidFromMatrix4(matrix);
  if (!pose.ok()) return base::Annotate(pose.status(), where);
  return FromOpenGlCamera(*pose);
}

absl::StatusOr<camera::Camera> PinholeOf(image::ImageSize size, double fx,
                                         double fy, double cx, double cy,
                                         const std::string& where) {
  auto camera = PinholeFromCorner(size, fx, fy, cx, cy);
  if (!camera.ok()) return base::Annotate(camera.status(), where);
  return camera;
}

// Gathers the frames of a capture; what is wrong with one leaves it out.
class Gatherer {
 public:
  Gatherer(std::string format, const geometry::Rotation3& z_up) : z_up_(z_up) {
    capture_.format = std::move(format);
    capture_.notes = {
        "world turned from ARKit's (y up) and camera axes from ARKit's (y up, "
        "z backwards); principal point half a pixel less"};
  }

  void Note(std::string note) { capture_.notes.push_back(std::move(note)); }
  void LeaveOut(const std::string& reason, const std::string& name) {
    capture_.left_out.Add(reason, name);
  }
  void Add(const std::string& name, const absl::StatusOr<ArkitCamera>& camera,
           FrameFiles files) {
    if (!camera.ok()) {
      LeaveOut("its camera or pose is none",
               std::string(camera.status().message()));
      return;
    }
    capture_.frames.push_back(
        {name, camera->camera, Rotated(z_up_, camera->world_from_camera)});
    files_.push_back(std::move(files));
  }
  Capture Finish(const DepthRules& rules) {
    capture_.pictures =
        std::make_unique<PictureFiles>(std::move(files_), rules);
    return std::move(capture_);
  }

 private:
  const geometry::Rotation3 z_up_;
  Capture capture_;
  std::vector<FrameFiles> files_;
};

double DepthUnit_m(const OpenOptions& options) {
  return options.depth_unit_m > 0 ? options.depth_unit_m : 0.001;
}

bool IsFolder(const std::string& path) {
  std::error_code error;
  return std::filesystem::is_directory(path, error);
}

}  // namespace

absl::StatusOr<ArkitCamera> ParsePolycamCamera(absl::string_view text,
                                               const std::string& where) {
  TL_ASSIGN_OR_RETURN(const Json json, ParseJsonObject(text, where));
  std::array<double, 16> matrix{};
  matrix[15] = 1;
  for (size_t row = 0; row < 3; ++row) {
    for (size_t column = 0; column < 4; ++column) {
      const std::string name = absl::StrCat("t_", row, column);
      TL_ASSIGN_OR_RETURN(matrix[4 * row + column],
                          NumberOf(json, name.c_str(), where));
    }
  }
  ArkitCamera result;
  TL_ASSIGN_OR_RETURN(result.world_from_camera, PoseFromArkit(matrix, where));
  image::ImageSize size;
  TL_ASSIGN_OR_RETURN(size.width, SideOf(json, "width", where));
  TL_ASSIGN_OR_RETURN(size.height, SideOf(json, "height", where));
  TL_ASSIGN_OR_RETURN(const double fx, NumberOf(json, "fx", where));
  TL_ASSIGN_OR_RETURN(const double fy, NumberOf(json, "fy", where));
  TL_ASSIGN_OR_RETURN(const double cx, NumberOf(json, "cx", where));
  TL_ASSIGN_OR_RETURN(const double cy, NumberOf(json, "cy", where));
  TL_ASSIGN_OR_RETURN(result.camera, PinholeOf(size, fx, fy, cx, cy, where));
  return result;
}

absl::StatusOr<ArkitCamera> ParseScannerAppCamera(absl::string_view text,
                                                  image::ImageSize size,
                                                  const std::string& where) {
  TL_ASSIGN_OR_RETURN(const Json json, ParseJsonObject(text, where));
  const auto numbers = [&](const char* name, std::span<double> out) {
    const auto found = json.find(name);
    return found == json.end() ? absl::InvalidArgumentError(absl::StrCat(
                                     where, ": has no \"", name, "\""))
                               : NumbersOf(*found, name, where, out);
  };
  std::array<double, 16> matrix{};
  std::array<double, 9> k{};
  TL_RETURN_IF_ERROR(numbers("cameraPoseARFrame", matrix));
  TL_RETURN_IF_ERROR(numbers("intrinsics", k));
  ArkitCamera result;
  TL_ASSIGN_OR_RETURN(result.world_from_camera, PoseFromArkit(matrix, where));
  TL_ASSIGN_OR_RETURN(result.camera,
                      PinholeOf(size, k[0], k[4], k[2], k[5], where));
  return result;
}

bool IsPolycam(const std::string& folder) {
  return IsFolder(folder + "/keyframes/cameras") ||
         IsFolder(folder + "/keyframes/corrected_cameras");
}

absl::StatusOr<Capture> OpenPolycam(const std::string& folder,
                                    const OpenOptions& options) {
  const std::string keyframes = folder + "/keyframes";
  TL_ASSIGN_OR_RETURN(const geometry::Rotation3 z_up, ZUpFrom(options.up, "y"));
  Gatherer gatherer("polycam", z_up);
  std::string cameras = keyframes + "/corrected_cameras";
  std::string images = keyframes + "/corrected_images";
  if (!IsFolder(cameras) || !IsFolder(images)) {
    cameras = keyframes + "/cameras";
    images = keyframes + "/images";
    gatherer.Note(
        "poses and pictures as ARKit measured them: without loop closure, and "
        "with the distortion of the lens. Process the capture with loop "
        "closure in the app for better ones");
  }
  for (const std::string& stem : StemsIn(cameras, ".json")) {
    const std::string json = absl::StrCat(cameras, "/", stem, ".json");
    FrameFiles files{
        .color = FindPicture(absl::StrCat(images, "/", stem)),
        .depth = IfFile(absl::StrCat(keyframes, "/depth/", stem, ".png")),
        .confidence =
            IfFile(absl::StrCat(keyframes, "/confidence/", stem, ".png"))};
    if (files.color.empty()) {
      gatherer.LeaveOut("there is no picture of this name",
                        absl::StrCat(images, "/", stem, ".jpg"));
      continue;
    }
    const auto text = base::ReadFile(json, kMaxFrameJsonBytes);
    gatherer.Add(stem,
                 text.ok() ? ParsePolycamCamera(*text, json)
                           : absl::StatusOr<ArkitCamera>(text.status()),
                 std::move(files));
  }
  constexpr int kMinValue[] = {0, 64, 192};
  return gatherer.Finish(
      {.unit_m = DepthUnit_m(options),
       .min_confidence_value = kMinValue[options.min_confidence]});
}

bool IsScannerApp(const std::string& folder) {
  for (const std::string& name : base::SortedNamesIn(folder)) {
    if (name.starts_with("frame_") && name.ends_with(".json")) return true;
  }
  return false;
}

absl::StatusOr<Capture> OpenScannerApp(const std::string& folder,
                                       const OpenOptions& options) {
  TL_ASSIGN_OR_RETURN(const geometry::Rotation3 z_up, ZUpFrom(options.up, "y"));
  Gatherer gatherer("3dscanner", z_up);
  for (const std::string& stem : StemsIn(folder, ".json")) {
    if (!stem.starts_with("frame_")) continue;
    const std::string number = stem.substr(std::string("frame_").size());
    FrameFiles files{
        .color = FindPicture(absl::StrCat(folder, "/", stem)),
        .depth = IfFile(absl::StrCat(folder, "/depth_", number, ".png")),
        .confidence = IfFile(absl::StrCat(folder, "/conf_", number, ".png"))};
    if (files.color.empty()) continue;
    const auto size = dataset::ReadPictureSize(files.color);
    if (!size.ok()) {
      gatherer.LeaveOut("the picture cannot be read",
                        std::string(size.status().message()));
      continue;
    }
    const std::string json = absl::StrCat(folder, "/", stem, ".json");
    const auto text = base::ReadFile(json, kMaxFrameJsonBytes);
    gatherer.Add(stem,
                 text.ok() ? ParseScannerAppCamera(*text, *size, json)
                           : absl::StatusOr<ArkitCamera>(text.status()),
                 std::move(files));
  }
  return gatherer.Finish({.unit_m = DepthUnit_m(options),
                          .min_confidence_value = options.min_confidence});
}

}  // namespace treeline::capture
