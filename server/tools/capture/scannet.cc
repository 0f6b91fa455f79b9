#include "server/tools/capture/scannet.h"

#include <array>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/base/file.h"
#include "common/base/folder.h"
#include "common/base/status_macros.h"
#include "common/dataset/picture_files.h"
#include "common/dataset/text_formats.h"
#include "common/dataset/text_lines.h"
#include "server/tools/capture/conventions.h"
#include "server/tools/capture/picture_files.h"

namespace treeline::capture {
namespace {

constexpr uint64_t kMaxMatrixBytes = 1u << 16;

absl::StatusOr<camera::Camera> ReadIntrinsic(const std::string& path,
                                             const std::string& picture) {
  TL_ASSIGN_OR_RETURN(const image::ImageSize size,
                      dataset::ReadPictureSize(picture));
  TL_ASSIGN_OR_RETURN(const std::string text,
                      base::ReadFile(path, kMaxMatrixBytes));
  return ParseScanNetIntrinsic(text, size, path);
}

// The pose in a file. Not OK: it is left out.
absl::StatusOr<geometry::Rigid3> ReadPose(const std::string& path,
                                          LeftOut& left_out) {
  const auto text = base::ReadFile(path, kMaxMatrixBytes);
  if (!text.ok()) {
    left_out.Add("there is no pose", path);
    return text.status();
  }
  if (absl::StrContains(*text, "inf")) {
    left_out.Add("tracking was lost", path);
    return absl::NotFoundError(path);
  }
  auto pose = dataset::ParsePoseMatrix(*text, path);
  if (!pose.ok()) {
    left_out.Add("the pose is no rigid 4 x 4 matrix",
                 std::string(pose.status().message()));
  }
  return pose;
}

}  // namespace

absl::StatusOr<camera::Camera> ParseScanNetIntrinsic(absl::string_view text,
                                                     image::ImageSize size,
                                                     const std::string& file) {
  std::array<double, 16> k{};
  size_t row = 0;
  int number = 0;
  for (const absl::string_view line : absl::StrSplit(text, '\n')) {
    ++number;
    const std::vector<absl::string_view> words =
        absl::StrSplit(line, absl::ByAnyChar(" \t\r"), absl::SkipEmpty());
    if (words.empty()) continue;
    if (words.size() != 4 || row == 4) {
      return dataset::LineError(file, number, "expected 4 lines of 4 numbers");
    }
    TL_RETURN_IF_ERROR(dataset::ParseNumbers(words, file, number,
                                             std::span(k).subspan(4 * row, 4)));
    ++row;
  }
  if (row != 4) {
    return dataset::LineError(file, number, "expected 4 lines of 4 numbers");
  }
  const std::array<double, 4> pinhole{k[0], k[5], k[2], k[6]};
  const auto camera =
      camera::Camera::Create(camera::CameraModel::kPinhole, size.width,
                             size.height, pinhole.data(), 4);
  if (!camera.ok()) return base::Annotate(camera.status(), file);
  return camera;
}

bool IsScanNet(const std::string& folder) {
  return base::IsFile(folder + "/intrinsic/intrinsic_color.txt");
}

absl::StatusOr<Capture> OpenScanNet(const std::string& folder,
                                    const OpenOptions& options) {
  TL_ASSIGN_OR_RETURN(const geometry::Rotation3 z_up, ZUpFrom(options.up, "z"));
  Capture capture;
  capture.format = "scannet";
  capture.notes = {"poses and cameras as they are; pixel centres at integers"};
  std::optional<camera::Camera> color;
  std::vector<FrameFiles> files;
  for (const char* ending : {".jpg", ".png"}) {
    for (const std::string& stem : StemsIn(folder + "/color", ending)) {
      FrameFiles of_frame{
          .color = absl::StrCat(folder, "/color/", stem, ending),
          .depth = IfFile(absl::StrCat(folder, "/depth/", stem, ".png")),
          .confidence = {}};
      const auto pose = ReadPose(absl::StrCat(folder, "/pose/", stem, ".txt"),
                                 capture.left_out);
      if (!pose.ok()) continue;
      if (!color) {
        TL_ASSIGN_OR_RETURN(
            color, ReadIntrinsic(folder + "/intrinsic/intrinsic_color.txt",
                                 of_frame.color));
      }
      if (!capture.depth && !of_frame.depth.empty()) {
        TL_ASSIGN_OR_RETURN(
            capture.depth,
            ReadIntrinsic(folder + "/intrinsic/intrinsic_depth.txt",
                          of_frame.depth));
      }
      capture.frames.push_back(
          {absl::StrCat("color/", stem, ending), *color, Rotated(z_up, *pose)});
      files.push_back(std::move(of_frame));
    }
  }
  capture.pictures = std::make_unique<PictureFiles>(
      std::move(files),
      DepthRules{.unit_m =
                     options.depth_unit_m > 0 ? options.depth_unit_m : 0.001});
  return capture;
}

}  // namespace treeline::capture
