// The files of captures that people send, as arbitrary bytes: no crash, and no
// frame whose pose or camera is none.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "absl/strings/match.h"
#include "absl/strings/string_view.h"
#include "server/tools/capture/arkit_json.h"
#include "server/tools/capture/posed_pictures.h"
#include "server/tools/capture/record3d.h"
#include "server/tools/capture/scannet.h"
#include "server/tools/capture/stray_scanner.h"
#include "server/tools/capture/transforms_json.h"

namespace treeline {
namespace {

void Require(bool holds) {
  if (!holds) std::abort();
}

void CheckArkit(const absl::StatusOr<capture::ArkitCamera>& camera) {
  if (camera.ok()) Require(geometry::IsFinite(camera->world_from_camera));
}

void Parse(absl::string_view text) {
  const auto transforms = capture::ParseTransforms(
      text, "fuzz",
      [](const std::string& /*path*/) {
        return absl::StatusOr<image::ImageSize>(image::ImageSize{640, 480});
      },
      [](const std::string& path) { return path.size() % 2 == 0; });
  if (transforms.ok()) {
    Require(transforms->depth_unit_m > 0);
    for (const capture::TransformsFrame& frame : transforms->frames) {
      Require(geometry::IsFinite(frame.world_from_camera));
      Require(frame.camera.fx() > 0);
      Require(!absl::StartsWith(frame.file_path, "/"));
      Require(!absl::StrContains("/" + frame.file_path + "/", "/../"));
      Require(!absl::StrContains("/" + frame.depth_path + "/", "/../"));
    }
  }
  for (const auto& poses : {capture::ParsePoseLines(text, "fuzz"),
                            capture::ParsePoseLog(text, "fuzz")}) {
    if (!poses.ok()) continue;
    for (const auto& [frame, pose] : *poses) {
      if (pose.ok()) Require(geometry::IsFinite(*pose));
    }
  }
  if (const auto stray = capture::ParseStrayOdometry(text, "fuzz");
      stray.ok()) {
    for (const capture::StrayRow& row : stray->rows) {
      Require(geometry::IsFinite(row.world_from_camera));
      Require(!absl::StrContains(row.frame, "/"));
    }
  }
  if (const auto record3d = capture::ParseRecord3dMetadata(text, "fuzz");
      record3d.ok()) {
    for (const capture::Record3dFrame& frame : record3d->frames) {
      Require(geometry::IsFinite(frame.world_from_camera));
    }
  }
  (void)capture::ParseStrayCameraMatrix(text, "fuzz");
  CheckArkit(capture::ParsePolycamCamera(text, "fuzz"));
  CheckArkit(capture::ParseScannerAppCamera(text, {640, 480}, "fuzz"));
  (void)capture::ParseScanNetIntrinsic(text, {640, 480}, "fuzz");
}

}  // namespace
}  // namespace treeline

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  treeline::Parse(absl::string_view(reinterpret_cast<const char*>(data), size));
  return 0;
}
