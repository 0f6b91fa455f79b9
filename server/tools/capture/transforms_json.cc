#include "server/tools/capture/transforms_json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/file.h"
#include "common/base/folder.h"
#include "common/base/status_macros.h"
#include "common/dataset/picture_files.h"
#include "common/dataset/text_lines.h"
#include "server/tools/capture/conventions.h"
#include "server/tools/capture/json_text.h"
#include "server/tools/capture/picture_files.h"

namespace treeline::capture {
namespace {

namespace fs = std::filesystem;
using camera::CameraModel;

// A frame's entry, with the file's for what it does not have itself.
class Entry {
 public:
  Entry(const Json& file, const Json& frame, std::string where)
      : file_(file), frame_(frame), where_(std::move(where)) {}

  const std::string& where() const { return where_; }

  absl::StatusOr<std::optional<double>> Number(const char* name) const {
    TL_ASSIGN_OR_RETURN(const std::optional<double> own,
                        OptionalNumberOf(frame_, name, where_));
    if (own) return own;
    return OptionalNumberOf(file_, name, where_);
  }
  absl::StatusOr<double> NumberOr(const char* name, double fallback) const {
    TL_ASSIGN_OR_RETURN(const std::optional<double> number, Number(name));
    return number.value_or(fallback);
  }
  bool IsTrue(const char* name) const {
    for (const Json* json : {&frame_, &file_}) {
      const auto found = json->find(name);
      if (found != json->end())
        return found->is_boolean() && found->get<bool>();
    }
    return false;
  }
  std::string Text(const char* name) const {
    for (const Json* json : {&frame_, &file_}) {
      const auto found = json->find(name);
      if (found != json->end() && found->is_string()) {
        return found->get<std::string>();
      }
    }
    return "";
  }

  // The size that is written down, if one is.
  absl::StatusOr<std::optional<image::ImageSize>> Size() const {
    const bool own = frame_.contains("w") || frame_.contains("h");
    const Json& json = own ? frame_ : file_;
    if (!json.contains("w") && !json.contains("h")) return std::nullopt;
    image::ImageSize size;
    TL_ASSIGN_OR_RETURN(size.width, SideOf(json, "w", where_));
    TL_ASSIGN_OR_RETURN(size.height, SideOf(json, "h", where_));
    return size;
  }

 private:
  const Json& file_;
  const Json& frame_;
  const std::string where_;
};

struct FocalLengths {
  double x = 0;
  double y = 0;
};

absl::StatusOr<FocalLengths> FocalLengthsOf(const Entry& entry,
                                            image::ImageSize size) {
  // From a field of view (rad), where that is all there is.
  const auto from_angle =
      [&](const char* name, int side) -> absl::StatusOr<std::optional<double>> {
    TL_ASSIGN_OR_RETURN(const std::optional<double> angle, entry.Number(name));
    if (!angle) return std::nullopt;
    return 0.5 * side / std::tan(0.5 * *angle);
  };
  TL_ASSIGN_OR_RETURN(std::optional<double> x, entry.Number("fl_x"));
  TL_ASSIGN_OR_RETURN(std::optional<double> y, entry.Number("fl_y"));
  if (!x) {
    TL_ASSIGN_OR_RETURN(x, from_angle("camera_angle_x", size.width));
  }
  if (!y) {
    TL_ASSIGN_OR_RETURN(y, from_angle("camera_angle_y", size.height));
  }
  if (!x && !y) {
    return absl::InvalidArgumentError(absl::StrCat(
        entry.where(),
        ": says no focal length; it needs fl_x (px) or camera_angle_x (rad), "
        "in the frame or at the top of the file"));
  }
  return FocalLengths{x ? *x : *y, y ? *y : *x};
}

absl::StatusOr<CameraModel> ModelOf(const Entry& entry) {
  if (entry.IsTrue("is_fisheye")) return CameraModel::kOpenCvFisheye;
  const std::string name = entry.Text("camera_model");
  if (name == "OPENCV_FISHEYE") return CameraModel::kOpenCvFisheye;
  for (const char* known : {"", "OPENCV", "PINHOLE", "SIMPLE_PINHOLE",
                            "SIMPLE_RADIAL", "RADIAL", "PERSPECTIVE"}) {
    if (name == known) return CameraModel::kOpenCv;
  }
  return absl::InvalidArgumentError(absl::StrCat(
      entry.where(), ": camera_model '", name,
      "' is not supported; undistort the pictures to PINHOLE, for instance "
      "with `colmap image_undistorter`"));
}

absl::StatusOr<camera::Camera> CameraOf(const Entry& entry,
                                        image::ImageSize size) {
  TL_ASSIGN_OR_RETURN(const CameraModel model, ModelOf(entry));
  TL_ASSIGN_OR_RETURN(const FocalLengths f, FocalLengthsOf(entry, size));
  TL_ASSIGN_OR_RETURN(const double cx, entry.NumberOr("cx", 0.5 * size.width));
  TL_ASSIGN_OR_RETURN(const double cy, entry.NumberOr("cy", 0.5 * size.height));
  absl::StatusOr<camera::Camera> pinhole =
      PinholeFromCorner(size, f.x, f.y, cx, cy);
  if (!pinhole.ok()) return base::Annotate(pinhole.status(), entry.where());
  std::array<double, 6> d{};  // k1 k2 k3 k4 p1 p2
  const char* const names[] = {"k1", "k2", "k3", "k4", "p1", "p2"};
  for (size_t i = 0; i < d.size(); ++i) {
    TL_ASSIGN_OR_RETURN(d[i], entry.NumberOr(names[i], 0));
  }
  const auto [k1, k2, k3, k4, p1, p2] = d;
  if (std::ranges::all_of(d, [](double k) { return k == 0; }) &&
      model != CameraModel::kOpenCvFisheye) {
    return pinhole;
  }
  std::array<double, 12> p{f.x, f.y, cx - 0.5, cy - 0.5};
  CameraModel chosen = model;
  if (model == CameraModel::kOpenCvFisheye) {
    std::ranges::copy(std::array{k1, k2, k3, k4}, p.begin() + 4);
  } else if (k4 != 0) {
    return absl::InvalidArgumentError(absl::StrCat(
        entry.where(), ": k4 = ", k4,
        " of a camera that is no fisheye is not supported; undistort the "
        "pictures first"));
  } else {
    chosen = k3 != 0 ? CameraModel::kFullOpenCv : CameraModel::kOpenCv;
    std::ranges::copy(std::array{k1, k2, p1, p2, k3}, p.begin() + 4);
  }
  absl::StatusOr<camera::Camera> camera =
      camera::Camera::Create(chosen, size.width, size.height, p.data(),
                             camera::CameraParameterCount(chosen));
  if (!camera.ok()) return base::Annotate(camera.status(), entry.where());
  return camera;
}

// Paths as they stand in the file, and as they are used.
class Paths {
 public:
  explicit Paths(const IsInFolder& is_in_folder)
      : is_in_folder_(is_in_folder) {}

  // Relative to the folder of the file; nothing: `path` leads out of it, and no
  // end of it is in the folder.
  std::optional<std::string> Inside(absl::string_view path) {
    if (!dataset::LeadsOutside(path) && !HasDrive(path)) {
      return std::string(path);
    }
    for (size_t slash = path.find('/'); slash != absl::string_view::npos;
         slash = path.find('/')) {
      path.remove_prefix(slash + 1);
      if (path.empty() || dataset::LeadsOutside(path)) continue;
      if (is_in_folder_(std::string(path))) {
        ++found_;
        return std::string(path);
      }
    }
    return std::nullopt;
  }

  std::string Note() const {
    if (found_ == 0) return "";
    return absl::StrCat(found_,
                        " paths lead out of the folder, as those of another "
                        "machine do; the files were found in it by the ends of "
                        "their paths");
  }

 private:
  // "C:/..."
  static bool HasDrive(absl::string_view path) {
    return path.size() > 2 && path[1] == ':' && path[2] == '/';
  }

  const IsInFolder& is_in_folder_;
  int found_ = 0;
};

// A path of the file, without a leading "./". Programs on Windows write it with
// backslashes.
absl::StatusOr<std::string> PathOf(const Json& frame, const char* name,
                                   const std::string& where) {
  const auto found = frame.find(name);
  if (found == frame.end()) return "";
  std::string written;
  if (found->is_string()) written = found->get_ref<const std::string&>();
  std::ranges::replace(written, '\\', '/');
  absl::string_view path = written;
  while (absl::ConsumePrefix(&path, "./")) {
  }
  if (path.empty() || absl::StrContains(path, '\0')) {
    return absl::InvalidArgumentError(
        absl::StrCat(where, ": ", name, " is no path of a file"));
  }
  return std::string(path);
}

absl::StatusOr<double> DepthUnit_m(const Json& file, const std::string& where) {
  for (const char* name : {"depth_unit_scale_factor", "integer_depth_scale"}) {
    TL_ASSIGN_OR_RETURN(const std::optional<double> unit,
                        OptionalNumberOf(file, name, where));
    if (!unit) continue;
    if (*unit > 0 && *unit <= 1) return *unit;
    return absl::InvalidArgumentError(
        absl::StrCat(where, ": \"", name, "\" is ", *unit,
                     "; metres per unit of depth must be in (0, 1]"));
  }
  return 0.001;
}

absl::StatusOr<double> AppliedScale(const Json& file, const std::string& where,
                                    TransformsJson& result) {
  TL_ASSIGN_OR_RETURN(const std::optional<double> scale,
                      OptionalNumberOf(file, "applied_scale", where));
  if (!scale) return 1.0;
  if (!(*scale > 1e-6) || !(*scale < 1e6)) {
    return absl::InvalidArgumentError(absl::StrCat(
        where, ": \"applied_scale\" is ", *scale, ", and should be positive"));
  }
  result.notes.push_back(
      absl::StrCat("positions divided by applied_scale, ", *scale));
  return *scale;
}

// One entry of "frames"; false: it was left out.
absl::StatusOr<bool> ParseFrame(const Json& file, const Json& json,
                                const std::string& where, double scale,
                                const SizeOfPicture& size_of, Paths& paths,
                                TransformsJson& result) {
  if (!json.is_object()) {
    return absl::InvalidArgumentError(absl::StrCat(where, ": is no object"));
  }
  TransformsFrame frame;
  TL_ASSIGN_OR_RETURN(const std::string file_path,
                      PathOf(json, "file_path", where));
  if (file_path.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(where, ": has no \"file_path\""));
  }
  TL_ASSIGN_OR_RETURN(std::string depth_path,
                      PathOf(json, "depth_file_path", where));
  if (depth_path.empty()) {
    TL_ASSIGN_OR_RETURN(depth_path, PathOf(json, "depth_path", where));
  }
  const std::optional<std::string> inside = paths.Inside(file_path);
  if (!inside) {
    result.left_out.Add(
        "file_path leads out of the folder, and nothing with the end of that "
        "path is in it: put the JSON file into the folder that has the "
        "pictures, or write paths relative to it",
        file_path);
    return false;
  }
  frame.file_path = *inside;
  // One that is not there is said to be missing, by its whole name.
  if (!depth_path.empty()) {
    frame.depth_path = paths.Inside(depth_path).value_or("");
    if (frame.depth_path.empty()) frame.missing_depth = depth_path;
  }
  const auto matrix = MatrixRowsOf(json, "transform_matrix", where);
  if (!matrix.ok()) {
    result.left_out.Add("transform_matrix is no matrix of 16 finite numbers",
                        frame.file_path);
    return false;
  }
  const auto pose = geometry::RigidFromMatrix4(*matrix);
  if (!pose.ok()) {
    result.left_out.Add("transform_matrix is not rigid", frame.file_path);
    return false;
  }
  frame.world_from_camera = FromOpenGlCamera(*pose);
  frame.world_from_camera.translation =
      frame.world_from_camera.translation / scale;
  const Entry entry(file, json, where);
  TL_ASSIGN_OR_RETURN(std::optional<image::ImageSize> size, entry.Size());
  if (!size) {
    const absl::StatusOr<image::ImageSize> found = size_of(frame.file_path);
    if (!found.ok()) {
      result.left_out.Add("the picture cannot be read", frame.file_path);
      return false;
    }
    size = *found;
  }
  TL_ASSIGN_OR_RETURN(frame.camera, CameraOf(entry, *size));
  result.frames.push_back(std::move(frame));
  return true;
}

std::string FileOf(const std::string& path) {
  return base::IsFile(path) ? path : absl::StrCat(path, "/transforms.json");
}

// The picture at a path that may have no ending, as in instant-ngp's files.
std::string PictureAt(const std::string& path) {
  return base::IsFile(path) ? path : FindPicture(path);
}

}  // namespace

absl::StatusOr<TransformsJson> ParseTransforms(absl::string_view text,
                                               const std::string& where,
                                               const SizeOfPicture& size_of,
                                               const IsInFolder& is_in_folder) {
  TL_ASSIGN_OR_RETURN(const Json file, ParseJsonObject(text, where));
  const auto frames = file.find("frames");
  if (frames == file.end() || !frames->is_array() || frames->empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(where,
                     ": has no \"frames\": [...]; is it a transforms.json of "
                     "nerfstudio or instant-ngp?"));
  }
  TransformsJson result;
  TL_ASSIGN_OR_RETURN(const double scale, AppliedScale(file, where, result));
  TL_ASSIGN_OR_RETURN(result.depth_unit_m, DepthUnit_m(file, where));
  if (file.contains("applied_transform")) {
    result.notes.push_back(
        "the world stays as applied_transform of the file made it");
  }
  Paths paths(is_in_folder);
  for (size_t i = 0; i < frames->size(); ++i) {
    TL_RETURN_IF_ERROR(ParseFrame(file, (*frames)[i],
                                  absl::StrCat(where, ": frames[", i, "]"),
                                  scale, size_of, paths, result)
                           .status());
  }
  std::ranges::stable_sort(result.frames, NaturalLess,
                           &TransformsFrame::file_path);
  std::string last;
  std::erase_if(result.frames, [&](const TransformsFrame& frame) {
    if (frame.file_path != last) {
      last = frame.file_path;
      return false;
    }
    result.left_out.Add("its file_path is that of another frame", last);
    return true;
  });
  if (std::string note = paths.Note(); !note.empty()) {
    result.notes.push_back(std::move(note));
  }
  return result;
}

bool IsTransforms(const std::string& path) {
  return base::IsFile(path + "/transforms.json") ||
         (absl::EndsWith(path, ".json") && base::IsFile(path));
}

absl::StatusOr<Capture> OpenTransforms(const std::string& path,
                                       const OpenOptions& options) {
  const std::string file = FileOf(path);
  const std::string folder = fs::path(file).parent_path().string();
  const auto in_folder = [&](const std::string& name) {
    return folder.empty() ? name : absl::StrCat(folder, "/", name);
  };
  TL_ASSIGN_OR_RETURN(const std::string text,
                      base::ReadFile(file, uint64_t{128} << 20));
  TL_ASSIGN_OR_RETURN(
      TransformsJson parsed,
      ParseTransforms(
          text, file,
          [&](const std::string& name) {
            return dataset::ReadPictureSize(PictureAt(in_folder(name)));
          },
          [&](const std::string& name) {
            return !PictureAt(in_folder(name)).empty();
          }));
  TL_ASSIGN_OR_RETURN(const geometry::Rotation3 z_up, ZUpFrom(options.up, "z"));
  Capture capture;
  capture.format = "nerfstudio";
  capture.left_out = std::move(parsed.left_out);
  capture.notes = std::move(parsed.notes);
  capture.notes.push_back(
      "camera axes turned from OpenGL's (y up, z backwards); principal point "
      "half a pixel less");
  std::vector<FrameFiles> files;
  int without_depth = 0;
  std::string first_without_depth;
  for (const TransformsFrame& frame : parsed.frames) {
    const std::string color = PictureAt(in_folder(frame.file_path));
    if (color.empty()) {
      capture.left_out.Add("there is no such picture", frame.file_path);
      continue;
    }
    FrameFiles of_frame{.color = color, .depth = {}, .confidence = {}};
    if (absl::EndsWith(frame.depth_path, ".png")) {
      of_frame.depth = IfFile(in_folder(frame.depth_path));
    }
    const std::string& named =
        frame.depth_path.empty() ? frame.missing_depth : frame.depth_path;
    if (of_frame.depth.empty() && !named.empty()) {
      if (without_depth++ == 0) first_without_depth = named;
    }
    files.push_back(std::move(of_frame));
    capture.frames.push_back({frame.file_path, frame.camera,
                              Rotated(z_up, frame.world_from_camera)});
  }
  if (without_depth > 0) {
    capture.notes.push_back(absl::StrCat(
        without_depth, " frames without their depth, the first ",
        first_without_depth, ": it must be a 16-bit PNG that is there"));
  }
  capture.pictures = std::make_unique<PictureFiles>(
      std::move(files),
      DepthRules{.unit_m = options.depth_unit_m > 0 ? options.depth_unit_m
                                                    : parsed.depth_unit_m});
  return capture;
}

}  // namespace treeline::capture
