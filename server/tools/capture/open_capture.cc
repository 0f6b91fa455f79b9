#include "server/tools/capture/open_capture.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/base/status_macros.h"
#include "server/tools/capture/arkit_json.h"
#include "server/tools/capture/record3d.h"
#include "server/tools/capture/ros_bag.h"
#include "server/tools/capture/scannet.h"
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
    {"nerfstudio", "nerfstudio, instant-ngp: transforms.json, or its folder",
     IsTransforms, OpenTransforms},
    {"rosbag", "ROS: NAME.mcap, .db3, .bag, or the folder of ros2 bag record",
     IsRosBag, OpenRosBag},
};

std::string Names() {
  return absl::StrJoin(kFormats, ", ",
                       [](std::string* out, const CaptureFormat& format) {
                         absl::StrAppend(out, format.name);
                       });
}

absl::Status NoFormat(const std::string& path) {
  std::string message =
      absl::StrCat(path, ": is a capture of none of these formats:");
  for (const CaptureFormat& format : kFormats) {
    absl::StrAppend(&message, "\n  ", format.summary);
  }
  absl::StrAppend(&message, "\n");
  if (absl::EndsWith(path, ".zip")) {
    absl::StrAppend(&message, "Unpack the zip file first, and give the folder");
  } else {
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
  const auto* found =
      std::ranges::find_if(kFormats, [&](const CaptureFormat& known) {
        return format == "auto" ? known.is_it(trimmed) : format == known.name;
      });
  if (found != std::end(kFormats)) return found->open(trimmed, options);
  if (format == "auto") return NoFormat(trimmed);
  return absl::InvalidArgumentError(
      absl::StrCat("format '", format, "' is none of auto, ", Names()));
}

}  // namespace treeline::capture
