// Recordings of the app Record3D: NAME.r3d, a zip file, or its folder.
//
// Conventions, as the app's author states them (issues of
// github.com/marek-simonik/record3d) and as other readers have them
// (nerfstudio's process_data/record3d_utils.py):
//   metadata      JSON: w, h of the pictures, dw, dh of the depth maps (px), K
//                 (3 x 3, column by column), perFrameIntrinsicCoeffs (fx, fy,
//                 cx, cy of each frame) in newer versions
//   poses         qx qy qz qw tx ty tz (#33): camera to world (#36), OpenGL's
//                 camera axes (#33), of the pictures as they are stored. The
//                 first pose is "zero" (#27): y of the world is up as far as
//                 the phone was upright at the start
//   rgbd/N.jpg    pictures, from 0 (#93)
//   rgbd/N.depth  32-bit floats, m, row by row (#93), packed by LZFSE
//   rgbd/N.conf   bytes 0 to 2 (ARConfidenceLevel), packed by LZFSE
#ifndef SERVER_TOOLS_CAPTURE_RECORD3D_H_
#define SERVER_TOOLS_CAPTURE_RECORD3D_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/image/decode.h"
#include "server/tools/capture/capture.h"

namespace treeline::capture {

struct Record3dFrame {
  int number = 0;  // names its files
  camera::Camera camera;
  geometry::Rigid3 world_from_camera;  // our axes of the camera
};

struct Record3dMetadata {
  std::vector<Record3dFrame> frames;
  std::optional<image::ImageSize> depth_size;
  LeftOut left_out;
};

// INVALID_ARGUMENT, naming `where`, for what is no such file. A frame whose
// pose or camera is none is left out.
absl::StatusOr<Record3dMetadata> ParseRecord3dMetadata(
    absl::string_view text, const std::string& where);

// The depth map of floats in a .depth file, in mm.
absl::StatusOr<image::DepthImage> DecodeRecord3dDepth(absl::string_view file,
                                                      image::ImageSize size);

bool IsRecord3d(const std::string& path);
absl::StatusOr<Capture> OpenRecord3d(const std::string& path,
                                     const OpenOptions& options);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_RECORD3D_H_
