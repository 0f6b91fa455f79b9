// transforms.json of nerfstudio and instant-ngp.
//
// Conventions, as nerfstudio's documentation ("Data conventions",
// docs.nerf.studio/quickstart/data_conventions.html) and code have them:
//   poses    transform_matrix is camera to world, with OpenGL's camera axes
//            (x right, y up, z backwards); the world has z up.
//   cameras  fl_x, fl_y, cx, cy, w, h and the distortion, of the file or of a
//            frame; cx and cy from the corner of the picture (get_image_coords
//            in cameras/cameras.py adds 0.5). Distortion of OPENCV is
//            1 + k1 r^2 + k2 r^4 + k3 r^6 + k4 r^8 and p1, p2
//            (radial_and_tangential_undistort in cameras/camera_utils.py);
//            that of OPENCV_FISHEYE is COLMAP's. instant-ngp's camera_angle_x
//            is the horizontal field of view (rad), and is_fisheye says what
//            OPENCV_FISHEYE does.
//   depth    depth_file_path (instant-ngp: depth_path), 16-bit PNG along the
//            optical axis. Metres per unit: depth_unit_scale_factor, which
//            nerfstudio's data parser takes to be 0.001 unless told otherwise;
//            instant-ngp: integer_depth_scale.
//   scale    applied_scale is what positions were multiplied by when the file
//            was made: they are divided by it. Depth was not (the data parser
//            multiplies its scale, which depth gets, by applied_scale after the
//            poses had theirs). applied_transform is what the world was turned
//            by: it stays so, because it is what made z point up.
//            instant-ngp's scale and offset are for its viewer and do not
//            change the poses in the file.
#ifndef SERVER_TOOLS_CAPTURE_TRANSFORMS_JSON_H_
#define SERVER_TOOLS_CAPTURE_TRANSFORMS_JSON_H_

#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/image/decode.h"
#include "server/tools/capture/capture.h"

namespace treeline::capture {

struct TransformsFrame {
  std::string file_path;      // relative to the file's folder, and within it
  std::string depth_path;     // empty: none
  std::string missing_depth;  // what stands there, where that leads nowhere
  camera::Camera camera;
  geometry::Rigid3 world_from_camera;  // our axes of the camera; m
};

struct TransformsJson {
  std::vector<TransformsFrame> frames;  // in the natural order of file_path
  double depth_unit_m = 0.001;
  LeftOut left_out;
  std::vector<std::string> notes;
};

// The size of the picture at a file_path, where the file does not say it.
using SizeOfPicture =
    std::function<absl::StatusOr<image::ImageSize>(const std::string& path)>;

// Whether there is a file at a path relative to the folder, with or without an
// ending.
using IsInFolder = std::function<bool(const std::string& path)>;

// INVALID_ARGUMENT, naming `where` and the entry, for what is no such file:
// no frames, a camera model that is not ours, a camera that is none. A frame
// whose pose is not rigid, or which is there twice, is left out. A path that
// leads out of the folder, as of another machine, is never followed: it stands
// for the longest end of it that is in the folder; a frame without one is left
// out.
absl::StatusOr<TransformsJson> ParseTransforms(absl::string_view text,
                                               const std::string& where,
                                               const SizeOfPicture& size_of,
                                               const IsInFolder& is_in_folder);

bool IsTransforms(const std::string& path);
// `path`: the folder of transforms.json, or a JSON file.
absl::StatusOr<Capture> OpenTransforms(const std::string& path,
                                       const OpenOptions& options);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_TRANSFORMS_JSON_H_
