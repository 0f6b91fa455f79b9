// What Polycam and 3D Scanner App write of a frame: a JSON file with ARKit's
// camera. Both exports keep a frame in several files of one name.
#ifndef SERVER_TOOLS_CAPTURE_ARKIT_JSON_H_
#define SERVER_TOOLS_CAPTURE_ARKIT_JSON_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/image/decode.h"
#include "server/tools/capture/capture.h"

namespace treeline::capture {

struct ArkitCamera {
  camera::Camera camera;
  // Our axes of the camera; the world is ARKit's, with y up.
  geometry::Rigid3 world_from_camera;
};

// keyframes/cameras/TIME.json of Polycam's raw data (github.com/PolyCam/
// polyform, README.md, "Polycam's data format"): t_00 to t_23 are the rows of
// camera to world, ARKit's axes and gravity-aligned world; fx, fy, cx, cy,
// width, height (px). INVALID_ARGUMENT, naming `where`.
absl::StatusOr<ArkitCamera> ParsePolycamCamera(absl::string_view text,
                                               const std::string& where);

// frame_NNNNN.json of 3D Scanner App ("All data" export): cameraPoseARFrame is
// the 4 x 4 matrix of camera to world, row by row, intrinsics the 3 x 3 one in
// pixels of frame_NNNNN.jpg, both ARKit's. The app has no published
// description; programs that read its exports agree on this: the matrices are
// reshaped in NumPy's row order, the fourth column is the position, and y and z
// of the camera change their signs on the way to OpenCV's axes.
absl::StatusOr<ArkitCamera> ParseScannerAppCamera(absl::string_view text,
                                                  image::ImageSize size,
                                                  const std::string& where);

// Polycam's raw data: the folder that has keyframes/. The corrected images and
// cameras where both are there, else ARKit's; depth/TIME.png in mm, and
// confidence/TIME.png with 0, 127 and 255 for low, medium and high.
bool IsPolycam(const std::string& folder);
absl::StatusOr<Capture> OpenPolycam(const std::string& folder,
                                    const OpenOptions& options);

// 3D Scanner App: frame_NNNNN.jpg and .json, depth_NNNNN.png (mm) and
// conf_NNNNN.png (0 to 2). Frames without a picture, of which the app writes
// many, are no frames here.
bool IsScannerApp(const std::string& folder);
absl::StatusOr<Capture> OpenScannerApp(const std::string& folder,
                                       const OpenOptions& options);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_ARKIT_JSON_H_
