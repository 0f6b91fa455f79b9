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
#include "common/dataset/dataset_index.h"
#include "common/dataset/seven_scenes.h"
#include "common/dataset/sfm_datasets.h"
#include "common/dataset/tum.h"
#include "common/dataset/twelve_scenes.h"
#include "common/image/decode.h"

namespace treeline::dataset {
namespace {

constexpr uint64_t kMaxTextBytes = 256u << 20;
constexpr uint64_t kMaxImageBytes = 128u << 20;
// Focal lengths of one camera vary by less from frame to frame.
constexpr double kMaxFocalSpread = 0.01;

// A format's name in URIs, and its reader.
struct Format {
  const char* prefix;
  const char* arguments;
  absl::StatusOr<DatasetIndex> (*index)(const IndexRequest& request);
};

constexpr Format kFormats[] = {
    {"7scenes:", "DIR", IndexSevenScenes},
    {"12scenes:", "DIR", IndexTwelveScenes},
    {"tum:", "DIR", IndexTum},
    {"colmap:", "MODEL_DIR,IMAGES_DIR", IndexColmap},
    {"nvm:", "FILE", IndexNvm},
};

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
          absl::StrAppend(out, f.prefix, f.arguments);
        })));
  }
  if (format->index == IndexNvm) {
    request.folder = std::string(rest);
    return format;
  }
  if (format->index == IndexColmap) {
    const size_t comma = rest.rfind(',');
    if (comma == absl::string_view::npos) {
      return absl::InvalidArgumentError(
          absl::StrCat("data set '", uri, "' is not of the form ",
                       format->prefix, format->arguments));
    }
    TL_ASSIGN_OR_RETURN(request.images,
                        ExistingFolder(uri, rest.substr(comma + 1)));
    rest = rest.substr(0, comma);
  }
  TL_ASSIGN_OR_RETURN(request.folder, ExistingFolder(uri, rest));
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

absl::StatusOr<image::ImageSize> ReadSizeOf(const std::string& path) {
  TL_ASSIGN_OR_RETURN(const std::string bytes,
                      base::ReadFile(path, kMaxImageBytes));
  const absl::StatusOr<image::ImageSize> size = image::ReadImageSize(bytes);
  if (!size.ok()) return base::Annotate(size.status(), path);
  return size;
}

// The camera from `option`, or the format's default, which holds for one image
// size only.
absl::StatusOr<camera::Camera> ChooseCamera(absl::string_view name,
                                            const std::string& option,
                                            const std::string& default_camera,
                                            const DatasetIndex& index,
                                            image::ImageSize size,
                                            const std::string& uri) {
  if (option.empty() &&
      size != image::ImageSize{index.default_width, index.default_height}) {
    return absl::InvalidArgumentError(
        absl::StrCat(uri, ": images are ", size.width, " x ", size.height,
                     " pixels, but the default ", name, " camera is for ",
                     index.default_width, " x ", index.default_height,
                     "; give the ", name, " camera"));
  }
  return camera::Camera::Parse(option.empty() ? default_camera : option,
                               size.width, size.height);
}

absl::StatusOr<camera::Camera> WithFocalLength(const camera::Camera& camera,
                                               double focal_px) {
  std::array<double, camera::Camera::kMaxParameters> parameters =
      camera.parameters();
  parameters[0] = focal_px;
  parameters[1] = focal_px;  // The defaults all have fx and fy.
  return camera::Camera::Create(camera.model(), camera.width(), camera.height(),
                                parameters.data(),
                                camera::CameraParameterCount(camera.model()));
}

// That of a format which knows its cameras, with what the options replace.
absl::StatusOr<camera::RgbdCalibration> GivenCalibration(
    const DatasetOptions& options, const DatasetIndex& index) {
  camera::RgbdCalibration calibration = *index.calibration;
  if (index.structure != nullptr) return calibration;
  if (!options.pose_file.empty()) {
    calibration.pose_sensor = camera::RgbdSensor::kColor;
  }
  for (auto [option, camera] :
       {std::pair(&options.color_camera, &calibration.color),
        std::pair(&options.depth_camera, &calibration.depth)}) {
    if (option->empty()) continue;
    TL_ASSIGN_OR_RETURN(*camera, camera::Camera::Parse(*option, camera->width(),
                                                       camera->height()));
  }
  return calibration;
}

absl::StatusOr<camera::RgbdCalibration> ChooseCalibration(
    const DatasetOptions& options, const DatasetIndex& index,
    std::optional<double> focal_length_px) {
  if (index.calibration) return GivenCalibration(options, index);
  camera::RgbdCalibration calibration;
  TL_ASSIGN_OR_RETURN(const image::ImageSize color_size,
                      ReadSizeOf(index.frames[0].color_path));
  TL_ASSIGN_OR_RETURN(
      calibration.color,
      ChooseCamera("colour", options.color_camera, index.color_camera, index,
                   color_size, options.uri));
  if (options.color_camera.empty() && focal_length_px.has_value()) {
    TL_ASSIGN_OR_RETURN(calibration.color,
                        WithFocalLength(calibration.color, *focal_length_px));
  }
  calibration.pose_sensor = options.pose_file.empty()
                                ? index.pose_sensor
                                : camera::RgbdSensor::kColor;
  if (index.depth_camera.empty()) {
    if (!options.depth_camera.empty()) {
      return absl::InvalidArgumentError(absl::StrCat(
          options.uri,
          ": depth is registered to colour in this format and "
          "takes the colour camera; a depth camera cannot be given"));
    }
    calibration.depth = calibration.color;
    return calibration;
  }
  const auto with_depth = std::find_if(
      index.frames.begin(), index.frames.end(),
      [](const DatasetFrame& frame) { return !frame.depth_path.empty(); });
  image::ImageSize depth_size{index.default_width, index.default_height};
  if (with_depth != index.frames.end()) {
    TL_ASSIGN_OR_RETURN(depth_size, ReadSizeOf(with_depth->depth_path));
  }
  TL_ASSIGN_OR_RETURN(
      calibration.depth,
      ChooseCamera("depth", options.depth_camera, index.depth_camera, index,
                   depth_size, options.uri));
  return calibration;
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

absl::StatusOr<image::DepthImage> DecodeDepthOf(const camera::Camera& camera,
                                                double unit_m,
                                                const std::string& bytes) {
  TL_ASSIGN_OR_RETURN(image::DepthImage image,
                      image::DecodeDepthPng(bytes, unit_m));
  TL_RETURN_IF_ERROR(CheckSameSize("depth", image.width, image.height, camera));
  return image;
}

}  // namespace

absl::Status StemNotFound(const IndexRequest& request, const ListedStem& stem,
                          const std::string& where) {
  std::string message = absl::StrCat("no frame '", stem.stem, "' in ", where);
  if (!request.frame_list.empty()) {
    message = absl::StrCat(request.frame_list, ":", stem.line, ": ", message);
  }
  return absl::NotFoundError(message);
}

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
  dataset.depth_is_registered_ =
      !index.calibration && index.depth_camera.empty();
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

absl::StatusOr<Dataset::Encoded> Dataset::ReadEncoded(int i) const {
  Encoded encoded;
  encoded.color_camera = frame(i).color_camera;
  TL_ASSIGN_OR_RETURN(encoded.color,
                      base::ReadFile(frame(i).color_path, kMaxImageBytes));
  if (!frame(i).depth_path.empty()) {
    TL_ASSIGN_OR_RETURN(encoded.depth,
                        base::ReadFile(frame(i).depth_path, kMaxImageBytes));
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
    absl::StatusOr<image::DepthImage> depth =
        DecodeDepthOf(calibration_.depth, depth_unit_m_, encoded.depth);
    if (!depth.ok()) return base::Annotate(depth.status(), frame(i).depth_path);
    result.depth = *std::move(depth);
  }
  return result;
}

absl::StatusOr<image::Frame> Dataset::Decode(const Encoded& encoded) const {
  image::Frame result;
  result.calibration = CalibrationOf(encoded);
  TL_ASSIGN_OR_RETURN(
      result.color,
      DecodeColorOf(encoded.color_camera.value_or(calibration_.color),
                    encoded.color));
  if (!encoded.depth.empty()) {
    TL_ASSIGN_OR_RETURN(
        result.depth,
        DecodeDepthOf(calibration_.depth, depth_unit_m_, encoded.depth));
  }
  return result;
}

}  // namespace treeline::dataset
