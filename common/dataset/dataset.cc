#include "common/dataset/dataset.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <unordered_map>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/strip.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/dataset/dataset_cameras.h"
#include "common/dataset/dataset_index.h"
#include "common/dataset/picture_files.h"
#include "common/dataset/seven_scenes.h"
#include "common/dataset/sfm_datasets.h"
#include "common/dataset/tum.h"
#include "common/dataset/twelve_scenes.h"
#include "common/image/decode.h"

namespace treeline::dataset {
namespace {

constexpr uint64_t kMaxTextBytes = 256u << 20;
// Focal lengths of one camera vary by less from frame to frame.
constexpr double kMaxFocalSpread = 0.01;

absl::StatusOr<std::string> ExistingFolder(const std::string& uri,
                                           absl::string_view name) {
  while (name.size() > 1 && absl::EndsWith(name, "/")) name.remove_suffix(1);
  if (name.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("data set '", uri, "' names no folder"));
  }
  std::string folder(name);
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) {
    return absl::NotFoundError(
        absl::StrCat("data set '", uri, "': there is no folder ", folder));
  }
  return folder;
}

// What follows a format's name in a URI, and how it gets into a request.
struct Arguments {
  const char* text;
  absl::Status (*parse)(const std::string& uri, absl::string_view arguments,
                        IndexRequest& request);
};

absl::Status ParseFolder(const std::string& uri, absl::string_view arguments,
                         IndexRequest& request) {
  TL_ASSIGN_OR_RETURN(request.path, ExistingFolder(uri, arguments));
  return absl::OkStatus();
}

// Its reader says if there is no such file.
absl::Status ParseFile(const std::string& /*uri*/, absl::string_view arguments,
                       IndexRequest& request) {
  request.path = std::string(arguments);
  return absl::OkStatus();
}

constexpr const char* kTwoFoldersText = "MODEL_DIR,IMAGES_DIR";

absl::Status ParseTwoFolders(const std::string& uri,
                             absl::string_view arguments,
                             IndexRequest& request) {
  const size_t comma = arguments.rfind(',');
  if (comma == absl::string_view::npos) {
    return absl::InvalidArgumentError(
        absl::StrCat("data set '", uri, "' is not of the form ",
                     uri.substr(0, uri.find(':') + 1), kTwoFoldersText));
  }
  TL_ASSIGN_OR_RETURN(request.image_folder,
                      ExistingFolder(uri, arguments.substr(comma + 1)));
  return ParseFolder(uri, arguments.substr(0, comma), request);
}

constexpr Arguments kFolder = {"DIR", ParseFolder};
constexpr Arguments kFile = {"FILE", ParseFile};
constexpr Arguments kTwoFolders = {kTwoFoldersText, ParseTwoFolders};

// A format's name in URIs, and its reader.
struct Format {
  const char* prefix;
  Arguments arguments;
  absl::StatusOr<DatasetIndex> (*index)(const IndexRequest& request);
};

constexpr Format kFormats[] = {
    {"7scenes:", kFolder, IndexSevenScenes},
    {"12scenes:", kFolder, IndexTwelveScenes},
    {"tum:", kFolder, IndexTum},
    {"colmap:", kTwoFolders, IndexColmap},
    {"nvm:", kFile, IndexNvm},
};

// "7scenes:DIR" -> the format, and DIR in `request`.
absl::StatusOr<const Format*> ParseUri(const std::string& uri,
                                       IndexRequest& request) {
  absl::string_view rest = uri;
  const auto* format = std::ranges::find_if(kFormats, [&](const Format& f) {
    return absl::ConsumePrefix(&rest, f.prefix);
  });
  if (format == std::end(kFormats)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "data set '", uri, "' is none of ",
        absl::StrJoin(kFormats, ", ", [](std::string* out, const Format& f) {
          absl::StrAppend(out, f.prefix, f.arguments.text);
        })));
  }
  TL_RETURN_IF_ERROR(format->arguments.parse(uri, rest, request));
  return format;
}

absl::Status CheckNumbers(const DatasetOptions& options) {
  if (!std::isfinite(options.depth_unit_m) || options.depth_unit_m < 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        "depth unit of ", options.depth_unit_m, " m is not positive"));
  }
  if (!(options.max_time_difference_s > 0) ||
      !(options.max_time_difference_s <= 1)) {
    return absl::InvalidArgumentError(
        absl::StrCat("largest time difference of ",
                     options.max_time_difference_s, " s is outside (0, 1]"));
  }
  return absl::OkStatus();
}

// Puts the pose file's poses into `frames`. Returns the focal length that it
// gives for them, if any.
absl::StatusOr<std::optional<double>> ApplyPoseFile(
    const std::string& file, std::vector<DatasetFrame>& frames) {
  TL_ASSIGN_OR_RETURN(const std::string text,
                      base::ReadFile(file, kMaxTextBytes));
  TL_ASSIGN_OR_RETURN(const std::vector<StemPose> poses,
                      ParseStemPoses(text, file));
  std::unordered_map<std::string, const StemPose*> pose_of;
  for (const StemPose& pose : poses) pose_of[pose.stem] = &pose;
  int count = 0;
  std::vector<double> focal_lengths_px;
  for (DatasetFrame& frame : frames) {
    const auto found = pose_of.find(frame.stem);
    if (found == pose_of.end()) continue;
    ++count;
    frame.world_from_camera = found->second->world_from_camera;
    if (found->second->focal_length_px.has_value()) {
      focal_lengths_px.push_back(*found->second->focal_length_px);
    }
  }
  if (count == 0) {
    return absl::InvalidArgumentError(
        absl::StrCat(file, ": has a pose for none of the ", frames.size(),
                     " frames, of which the first is '", frames[0].stem, "'"));
  }
  if (focal_lengths_px.empty()) return std::nullopt;
  std::sort(focal_lengths_px.begin(), focal_lengths_px.end());
  const double median_px = focal_lengths_px[focal_lengths_px.size() / 2];
  if (focal_lengths_px.back() - focal_lengths_px.front() >
      kMaxFocalSpread * median_px) {
    return absl::InvalidArgumentError(absl::StrCat(
        file, ": focal lengths from ", focal_lengths_px.front(), " to ",
        focal_lengths_px.back(),
        " px are not those of one camera; give the colour camera instead"));
  }
  return median_px;
}

absl::Status CheckSameSize(absl::string_view name, int width, int height,
                           const camera::Camera& camera) {
  if (width == camera.width() && height == camera.height()) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      name, " image of ", width, " x ", height, " pixels; the ", name,
      " camera has ", camera.width(), " x ", camera.height()));
}

absl::StatusOr<image::ColorImage> DecodeColorOf(const camera::Camera& camera,
                                                const std::string& bytes) {
  TL_ASSIGN_OR_RETURN(image::ColorImage image, image::DecodeColor(bytes));
  TL_RETURN_IF_ERROR(
      CheckSameSize("colour", image.width, image.height, camera));
  return image;
}

absl::StatusOr<image::DepthImage> DecodeDepthOf(
    const camera::RgbdCalibration& calibration, bool is_registered,
    double unit_m, const std::string& bytes) {
  TL_ASSIGN_OR_RETURN(image::DepthImage image,
                      image::DecodeDepthPng(bytes, unit_m));
  const absl::Status same =
      CheckSameSize("depth", image.width, image.height, calibration.depth);
  if (same.ok()) return image;
  if (!is_registered) return same;
  return absl::InvalidArgumentError(absl::StrCat(
      same.message(),
      ": this format takes depth to be registered to colour. If it is not, say "
      "where the depth camera is in a file cameras.json in the recording's "
      "folder (color_from_depth): docs/reference/import.md"));
}

}  // namespace

absl::StatusOr<Dataset> Dataset::Open(const DatasetOptions& options) {
  TL_RETURN_IF_ERROR(CheckNumbers(options));
  IndexRequest request;
  TL_ASSIGN_OR_RETURN(const Format* format, ParseUri(options.uri, request));
  request.color_camera = options.color_camera;
  request.read_poses = options.pose_file.empty();
  request.max_time_difference_s = options.max_time_difference_s;
  if (!options.frame_list.empty()) {
    request.frame_list = options.frame_list;
    TL_ASSIGN_OR_RETURN(const std::string text,
                        base::ReadFile(options.frame_list, kMaxTextBytes));
    TL_ASSIGN_OR_RETURN(request.stems,
                        ParseFrameList(text, options.frame_list));
  }
  TL_ASSIGN_OR_RETURN(DatasetIndex index, format->index(request));
  if (index.structure != nullptr &&
      !(options.pose_file.empty() && options.depth_camera.empty())) {
    return absl::InvalidArgumentError(absl::StrCat(
        options.uri,
        ": structure from motion has its own poses and no depth; a pose file "
        "or a depth camera cannot be given"));
  }
  std::optional<double> focal_length_px;
  if (!options.pose_file.empty()) {
    TL_ASSIGN_OR_RETURN(focal_length_px,
                        ApplyPoseFile(options.pose_file, index.frames));
  }
  Dataset dataset;
  TL_ASSIGN_OR_RETURN(dataset.calibration_,
                      ChooseCalibration(options, index, focal_length_px));
  dataset.uri_ = options.uri;
  dataset.frames_ = std::move(index.frames);
  dataset.missing_pictures_ = std::move(index.missing_pictures);
  dataset.states_its_cameras_ =
      std::holds_alternative<camera::RgbdCalibration>(index.cameras);
  dataset.depth_is_registered_ = DepthIsRegistered(index);
  dataset.units_are_metres_ = index.units_are_metres;
  dataset.structure_ = std::move(index.structure);
  dataset.depth_unit_m_ =
      options.depth_unit_m > 0 ? options.depth_unit_m : index.depth_unit_m;
  return dataset;
}

Dataset Dataset::Subset(std::span<const int> frames) const {
  Dataset subset = *this;
  subset.frames_.clear();
  for (const int i : frames) subset.frames_.push_back(frame(i));
  return subset;
}

Dataset Dataset::WithShutter(const image::RollingShutter& shutter,
                             const camera::RgbdCalibration& calibration) const {
  Dataset undone = *this;
  undone.undone_shutter_ = {shutter, calibration};
  return undone;
}

absl::StatusOr<Dataset::Encoded> Dataset::ReadEncoded(int i) const {
  Encoded encoded;
  encoded.color_camera = frame(i).color_camera;
  TL_ASSIGN_OR_RETURN(encoded.color, ReadPicture(frame(i).color_path));
  if (!frame(i).depth_path.empty()) {
    TL_ASSIGN_OR_RETURN(encoded.depth, ReadPicture(frame(i).depth_path));
  }
  return encoded;
}

std::optional<camera::RgbdCalibration> Dataset::CalibrationOf(
    const Encoded& encoded) const {
  if (!encoded.color_camera) return std::nullopt;
  camera::RgbdCalibration calibration = calibration_;
  calibration.color = calibration.depth = *encoded.color_camera;
  return calibration;
}

absl::StatusOr<image::Frame> Dataset::Load(int i) const {
  TL_ASSIGN_OR_RETURN(const Encoded encoded, ReadEncoded(i));
  absl::StatusOr<image::ColorImage> color = DecodeColorOf(
      encoded.color_camera.value_or(calibration_.color), encoded.color);
  if (!color.ok()) return base::Annotate(color.status(), frame(i).color_path);
  image::Frame result;
  result.calibration = CalibrationOf(encoded);
  result.color = *std::move(color);
  if (!frame(i).depth_path.empty()) {
    absl::StatusOr<image::DepthImage> depth = DecodeDepthOf(
        calibration_, depth_is_registered_, depth_unit_m_, encoded.depth);
    if (!depth.ok()) return base::Annotate(depth.status(), frame(i).depth_path);
    result.depth = *std::move(depth);
  }
  const std::optional<image::FrameMotion>& motion = frame(i).motion;
  if (!undone_shutter_ || !motion) return result;
  return image::AtTimeStamp(
      result, result.calibration.value_or(undone_shutter_->calibration),
      undone_shutter_->shutter, *motion);
}

absl::StatusOr<image::Frame> Dataset::Decode(const Encoded& encoded) const {
  image::Frame result;
  result.calibration = CalibrationOf(encoded);
  TL_ASSIGN_OR_RETURN(
      result.color,
      DecodeColorOf(encoded.color_camera.value_or(calibration_.color),
                    encoded.color));
  if (!encoded.depth.empty()) {
    TL_ASSIGN_OR_RETURN(result.depth,
                        DecodeDepthOf(calibration_, depth_is_registered_,
                                      depth_unit_m_, encoded.depth));
  }
  return result;
}

}  // namespace treeline::dataset
