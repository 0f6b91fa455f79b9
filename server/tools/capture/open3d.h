// A recording that Open3D's reconstruction system has reconstructed.
//
// Conventions (github.com/isl-org/Open3D, examples/python):
//   pictures     image/, rgb/ or color/ with JPEG, or else PNG, and depth/ with
//                16-bit PNG, in the natural order of their names
//                (open3d_example.py, get_rgbd_file_lists()); 1000 units of
//                depth a metre unless told otherwise (initialize_config.py).
//   camera       JSON with width, height and intrinsic_matrix, column by
//   column:
//                camera_intrinsic.json of sensors/realsense_recorder.py,
//                intrinsic.json of azure_kinect_mkv_reader.py; depth is aligned
//                to colour. Without one it is PrimeSense's, 525 px
//                (integrate_scene.py, run()). Taken as OpenCV means it: pixel
//                centres at integers.
//   poses        scene/trajectory.log, written by integrate_scene.py: camera to
//                world (integrate() gets the inverse), x right, y down, z
//                forward, in the world of the first frame: -y is up if the
//                camera was level then.
#ifndef SERVER_TOOLS_CAPTURE_OPEN3D_H_
#define SERVER_TOOLS_CAPTURE_OPEN3D_H_

#include <string>

#include "absl/status/statusor.h"
#include "server/tools/capture/capture.h"

namespace treeline::capture {

bool IsOpen3d(const std::string& folder);
absl::StatusOr<Capture> OpenOpen3d(const std::string& folder,
                                   const OpenOptions& options);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_OPEN3D_H_
