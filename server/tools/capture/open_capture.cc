#include "server/tools/capture/open_capture.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/base/folder.h"
#include "common/base/status_macros.h"
#include "server/tools/capture/arkit_json.h"
#include "server/tools/capture/open3d.h"
#include "server/tools/capture/picture_files.h"
#include "server/tools/capture/record3d.h"
#include "server/tools/capture/replica.h"
#include "server/tools/capture/ros_bag.h"
#include "server/tools/capture/rtabmap.h"
#include "server/tools/capture/scannet.h"
#include "server/tools/capture/sens_file.h"
#include "server/tools/capture/stray_scanner.h"
#include "server/tools/capture/transforms_json.h"

namespace treeline::capture {
namespace {

constexpr CaptureFormat kFormats[] = {
    {"stray", "Stray Scanner: the folder with odometry.csv", IsStrayScanner,
     OpenStrayScanner},
    {"record3d", "Record3D: NAME.r3d, or its unpacked folder", IsRecord3d,
     OpenRecord3d},
    {"polycam", "Polycam, raw data: the folder with keyframes/", IsPolycam,
     OpenPolycam},
    {"3dscanner", "3D Scanner App, all data: the folder with frame_00000.json",
     IsScannerApp, OpenScannerApp},
    {"scannet", "ScanNet: the folder with color/, depth/, pose/, intrinsic/",
     IsScanNet, OpenScanNet},
    {"sens", "ScanNet: NAME.sens", IsSens, OpenSens},
    {"replica", "Replica, NICE-SLAM: the folder with results/ and traj.txt",
     IsReplica, OpenReplica},
    {"open3d", "Open3D, reconstructed: color/, depth/, scene/trajectory.log",
     IsOpen3d, OpenOpen3d},
    {"nerfstudio", "nerfstudio, instant-ngp: transforms.json, or its folder",
     IsTransforms, OpenTransforms},
    {"rosbag", "ROS: NAME.mcap, .db3, .bag, or the folder of ros2 bag record",
     IsRosBag, OpenRosBag},
    {"rtabmap", "RTAB-Map, of robots and phones: NAME.db", IsRtabmap,
     OpenRtabmap},
};

std::string Names() {
  return absl::StrJoin(kFormats, ", ",
                       [](std::string* out, const CaptureFormat& format) {
                         absl::StrAppend(out, format.name);
                       });
}

const CaptureFormat* FormatOf(const std::string& path) {
  const auto* found = std::ranges::find_if(
      kFormats, [&](const CaptureFormat& known) { return known.is_it(path); });
  return found == std::end(kFormats) ? nullptr : found;
}

// What to do with what people often have instead; empty: nothing is known.
std::string Advice(const std::string& path) {
  if (absl::EndsWith(path, ".zip")) {
    return "Unpack the zip file first, and give the folder";
  }
  if (absl::EndsWith(path, ".db")) {
    return "A database of RTAB-Map has tables Node and Data: is it whole?";
  }
  const std::vector<std::string> names = base::SortedNamesIn(path);
  for (const std::string& name : names) {
    const std::string inside = absl::StrCat(path, "/", name);
    // transforms_train.json and the like.
    if (absl::StartsWith(name, "transforms") && IsTransforms(inside)) {
      return absl::StrCat("Give the file: ", inside);
    }
    // Any JSON could be a transforms.json.
    if (FormatOf(inside) != nullptr && !absl::EndsWith(name, ".json")) {
      return base::IsFile(inside)
                 ? absl::StrCat("Give the file: ", inside)
                 : absl::StrCat("A folder in it is one: ", inside);
    }
    if (name == "EXR_RGBD") {
      return "Record3D's EXR export is not read: export the .r3d file";
    }
    if (name == "mav0") {
      return absl::StrCat(
          "EuRoC's cameras measure no depth. Structure from motion of their "
          "pictures finds poses of its own: give ",
          inside, "/cam0/data");
    }
  }
  return "";
}

absl::Status NoFormat(const std::string& path) {
  std::string message =
      absl::StrCat(path, ": is a capture of none of these formats:");
  for (const CaptureFormat& format : kFormats) {
    absl::StrAppend(&message, "\n  ", format.summary);
  }
  absl::StrAppend(&message,
                  "\nnor a recording: folders seq-01, ... of 7-Scenes; "
                  "rgb.txt of TUM; images and sparse/0 of COLMAP\n");
  std::string advice = Advice(path);
  const std::string photographs = PhotographFolderIn(path);
  if (advice.empty() && !photographs.empty()) {
    advice = absl::StrCat(
        "Photographs are in ", photographs,
        ". Without poses, give that folder: structure from motion finds them. "
        "With a model of COLMAP, put it into sparse/0 beside the folder "
        "images, or give colmap:MODEL_DIR,IMAGES_DIR");
  }
  absl::StrAppend(&message, advice);
  if (advice.empty()) {
    absl::StrAppend(
        &message,
        "Without poses, a folder with three photographs or more "
        "(JPEG, PNG, HEIC) or a video (.mp4, .mov, .m4v) goes through "
        "structure from motion; depth without poses, through "
        "`treeline-agent map --rgbd`: "
        "docs/how-to/import-a-capture.md");
  }
  return absl::InvalidArgumentError(message);
}

}  // namespace

std::span<const CaptureFormat> CaptureFormats() { return kFormats; }

absl::StatusOr<Capture> OpenCapture(const std::string& path,
                                    const std::string& format,
                                    const OpenOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  std::string trimmed = path;
  while (trimmed.size() > 1 && trimmed.back() == '/') trimmed.pop_back();
  std::error_code error;
  if (!std::filesystem::exists(trimmed, error)) {
    return absl::NotFoundError(absl::StrCat("there is no ", trimmed));
  }
  if (format == "auto") {
    const CaptureFormat* const known = FormatOf(trimmed);
    return known == nullptr ? NoFormat(trimmed) : known->open(trimmed, options);
  }
  const auto* named = std::ranges::find(kFormats, format, &CaptureFormat::name);
  if (named != std::end(kFormats)) return named->open(trimmed, options);
  return absl::InvalidArgumentError(
      absl::StrCat("format '", format, "' is none of auto, ", Names()));
}

}  // namespace treeline::capture
