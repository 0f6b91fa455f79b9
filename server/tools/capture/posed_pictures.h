// Folders of pictures, depth maps and a list of poses, one a frame.
#ifndef SERVER_TOOLS_CAPTURE_POSED_PICTURES_H_
#define SERVER_TOOLS_CAPTURE_POSED_PICTURES_H_

#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"
#include "server/tools/capture/capture.h"
#include "server/tools/capture/picture_files.h"

namespace treeline::capture {

// World from camera by the number of the frame; not OK: that is no pose.
using ListedPoses = std::map<size_t, absl::StatusOr<geometry::Rigid3>>;

// Sixteen numbers a line, a 4 x 4 matrix row by row, as NICE-SLAM's traj.txt:
// the pose of frame 0, 1, ... nan and inf stand for a pose that was lost.
// INVALID_ARGUMENT, "FILE:LINE: ...": a line of something else.
absl::StatusOr<ListedPoses> ParsePoseLines(absl::string_view text,
                                           const std::string& file);

// Open3D's and Redwood's .log: a line of three numbers, of which the first is
// the frame's, and four lines of four. The same errors.
absl::StatusOr<ListedPoses> ParsePoseLog(absl::string_view text,
                                         const std::string& file);

// A capture of such pictures, `files` in the order of the frames.
struct PosedPictures {
  std::string format;
  std::vector<FrameFiles> files;
  ListedPoses poses;
  camera::Camera color;
  geometry::Rotation3 z_up;
  double depth_unit_m = 0.001;
  std::vector<std::string> notes;
};
Capture CaptureOf(PosedPictures pictures);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_POSED_PICTURES_H_
