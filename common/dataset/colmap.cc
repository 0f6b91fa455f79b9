#include "common/dataset/colmap.h"

#include <cmath>
#include <initializer_list>
#include <utility>
#include <vector>

#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/folder.h"
#include "common/base/status_macros.h"
#include "common/dataset/colmap_binary.h"
#include "common/dataset/colmap_builder.h"
#include "common/dataset/colmap_text.h"
#include "common/dataset/text_lines.h"

namespace treeline::dataset {
namespace {

constexpr uint64_t kMaxModelBytes = uint64_t{4} << 30;
constexpr double kPixelShift_px = 0.5;
constexpr uint64_t kLargestSize_px = 1u << 20;  // Camera::Create knows better.

// FOLDER/NAME.bin, or else .txt; nullopt if there is neither.
absl::StatusOr<std::optional<ColmapFile>> FindFile(const std::string& folder,
                                                   const char* name) {
  for (const bool binary : {true, false}) {
    std::string path =
        absl::StrCat(folder, "/", name, binary ? ".bin" : ".txt");
    if (!base::IsFile(path)) continue;
    TL_ASSIGN_OR_RETURN(std::string bytes,
                        base::ReadFile(path, kMaxModelBytes));
    return ColmapFile{std::move(path), std::move(bytes), binary};
  }
  return std::nullopt;
}

}  // namespace

absl::Status ColmapPlace::Error(absl::string_view what) const {
  return absl::InvalidArgumentError(
      file->binary ? absl::StrCat(file->path, ": byte ", at, ": ", what)
                   : absl::StrCat(file->path, ":", at, ": ", what));
}

ColmapBuilder::ColmapBuilder(const std::optional<camera::Camera>& camera,
                             bool has_points)
    : one_camera_(camera.has_value()), has_points_(has_points) {
  if (camera) model_.cameras.push_back(*camera);
}

absl::Status ColmapBuilder::AddCamera(const ColmapPlace& place, uint32_t id,
                                      camera::CameraModel model, uint64_t width,
                                      uint64_t height,
                                      std::span<const double> parameters) {
  std::vector<double> ours(parameters.begin(), parameters.end());
  const size_t cx =
      static_cast<size_t>(camera::CameraPrincipalPointIndex(model));
  for (size_t i = cx; i < std::min(cx + 2, ours.size()); ++i) {
    ours[i] -= kPixelShift_px;
  }
  const auto size = [](uint64_t pixels) {
    return static_cast<int>(std::min(pixels, kLargestSize_px));
  };
  const absl::StatusOr<camera::Camera> camera =
      camera::Camera::Create(model, size(width), size(height), ours.data(),
                             static_cast<int>(ours.size()));
  if (!camera.ok()) return place.Error(camera.status().message());
  if (!camera_of_id_.emplace(id, static_cast<int32_t>(model_.cameras.size()))
           .second) {
    return place.Error(absl::StrCat("camera ", id, " was already defined"));
  }
  model_.cameras.push_back(*camera);
  return absl::OkStatus();
}

absl::Status ColmapBuilder::AddPoint(const ColmapPlace& place, uint64_t id,
                                     geometry::Vec3 position,
                                     std::span<const TrackElement> track) {
  if (!geometry::IsFinite(position)) {
    return place.Error(
        absl::StrCat("the position of point ", id, " is not finite"));
  }
  if (!point_of_id_.emplace(id, static_cast<int32_t>(model_.points.size()))
           .second) {
    return place.Error(absl::StrCat("point ", id, " was already defined"));
  }
  model_.points.push_back({position, static_cast<int32_t>(track.size())});
  tracks_.push_back({place, {track.begin(), track.end()}});
  return absl::OkStatus();
}

absl::Status ColmapBuilder::AddImage(
    const ColmapPlace& place, uint32_t id, std::span<const double, 7> pose,
    uint32_t camera_id, absl::string_view name,
    std::span<const Observation> observations) {
  if (name.empty() || LeadsOutside(name) ||
      absl::StrContains(name, absl::string_view("\0", 1))) {
    return place.Error(absl::StrCat("'", absl::CHexEscape(name),
                                    "' is no name of an image in the folder "
                                    "of the images"));
  }
  SfmModel::Image image;
  image.name = std::string(name);
  const absl::StatusOr<geometry::Rigid3> camera_from_world =
      geometry::RigidFromQuaternion(pose[0], pose[1], pose[2], pose[3],
                                    {pose[4], pose[5], pose[6]});
  if (!camera_from_world.ok()) {
    return place.Error(camera_from_world.status().message());
  }
  image.camera_from_world = *camera_from_world;
  if (!one_camera_) {
    const auto camera = camera_of_id_.find(camera_id);
    if (camera == camera_of_id_.end()) {
      return place.Error(absl::StrCat("image ", id, " has camera ", camera_id,
                                      ", which the cameras file does not"));
    }
    image.camera = camera->second;
  }
  image.keypoints.reserve(observations.size());
  for (const Observation& seen : observations) {
    if (!std::isfinite(seen.x) || !std::isfinite(seen.y)) {
      return place.Error(
          absl::StrCat("a keypoint of image ", id, " is not finite"));
    }
    SfmModel::Keypoint keypoint{
        {seen.x - kPixelShift_px, seen.y - kPixelShift_px}};
    if (has_points_ && seen.point_id != kNoPoint) {
      const auto point = point_of_id_.find(seen.point_id);
      if (point == point_of_id_.end()) {
        return place.Error(absl::StrCat("image ", id, " sees point ",
                                        seen.point_id,
                                        ", which the points file does not "
                                        "have"));
      }
      keypoint.point = point->second;
    }
    image.keypoints.push_back(keypoint);
  }
  if (!image_of_id_.emplace(id, static_cast<int32_t>(model_.images.size()))
           .second) {
    return place.Error(absl::StrCat("image ", id, " was already defined"));
  }
  if (const auto [other, added] = id_of_name_.emplace(image.name, id); !added) {
    return place.Error(absl::StrCat("images ", other->second, " and ", id,
                                    " have the same name '", image.name, "'"));
  }
  model_.images.push_back(std::move(image));
  return absl::OkStatus();
}

absl::StatusOr<SfmModel> ColmapBuilder::Finish() {
  for (size_t i = 0; i < tracks_.size(); ++i) {
    for (const TrackElement& element : tracks_[i].elements) {
      const auto image = image_of_id_.find(element.image_id);
      if (image == image_of_id_.end()) {
        return tracks_[i].place.Error(
            absl::StrCat("the track names image ", element.image_id,
                         ", which the images file does not have"));
      }
      const std::vector<SfmModel::Keypoint>& keypoints =
          model_.images[static_cast<size_t>(image->second)].keypoints;
      if (element.keypoint >= keypoints.size() ||
          keypoints[element.keypoint].point != static_cast<int32_t>(i)) {
        return tracks_[i].place.Error(absl::StrCat(
            "the track names keypoint ", element.keypoint, " of image ",
            element.image_id, ", which does not see this point"));
      }
    }
  }
  return std::move(model_);
}

absl::StatusOr<SfmModel> ParseColmap(const ColmapFiles& files) {
  if (!files.cameras && !files.camera) {
    return absl::InvalidArgumentError(
        absl::StrCat(files.images.path, ": has no cameras"));
  }
  ColmapBuilder builder(files.camera, files.points.has_value());
  if (!files.camera) {
    TL_RETURN_IF_ERROR(files.cameras->binary
                           ? ReadCamerasBinary(*files.cameras, builder)
                           : ReadCamerasText(*files.cameras, builder));
  }
  if (files.points) {
    TL_RETURN_IF_ERROR(files.points->binary
                           ? ReadPointsBinary(*files.points, builder)
                           : ReadPointsText(*files.points, builder));
  }
  TL_RETURN_IF_ERROR(files.images.binary
                         ? ReadImagesBinary(files.images, builder)
                         : ReadImagesText(files.images, builder));
  return builder.Finish();
}

absl::StatusOr<SfmModel> ReadColmap(
    const std::string& folder, const std::optional<camera::Camera>& camera) {
  ColmapFiles files;
  TL_ASSIGN_OR_RETURN(std::optional<ColmapFile> images,
                      FindFile(folder, "images"));
  if (!images) {
    return absl::NotFoundError(
        absl::StrCat(folder,
                     ": no images.bin nor images.txt; is this the "
                     "folder of a COLMAP model?"));
  }
  files.images = *std::move(images);
  files.camera = camera;
  if (!camera) {
    for (const char* place : {"", "/../sparse", "/../sparse/0", "/.."}) {
      TL_ASSIGN_OR_RETURN(files.cameras, FindFile(folder + place, "cameras"));
      if (files.cameras) break;
    }
    if (!files.cameras) {
      return absl::NotFoundError(
          absl::StrCat(folder,
                       ": no cameras.bin nor cameras.txt, neither here nor in "
                       "../sparse; give the colour camera"));
    }
  }
  TL_ASSIGN_OR_RETURN(files.points, FindFile(folder, "points3D"));
  return ParseColmap(files);
}

}  // namespace treeline::dataset
