// Recordings of the app Stray Scanner.
//
// Conventions, as its code has them (github.com/strayrobots/scanner,
// StrayScanner/Helpers):
//   rgb.mp4            landscape, one frame a line of odometry.csv
//                      (DatasetEncoder.swift). In place of it a folder rgb/ of
//                      pictures NNNNNN.jpg or .png is read, too.
//   odometry.csv       timestamp, frame, x, y, z, qx, qy, qz, qw, and in newer
//                      versions fx, fy, cx, cy of each frame: camera to world.
//                      The app turns ARKit's camera by half a turn about x
//                      (OdometryEncoder.swift, q_AC), so its axes are ours; the
//                      world stays ARKit's, with y up. The oldest versions have
//                      no header and begin with x.
//   camera_matrix.csv  3 x 3, in pixels of the video, ARKit's
//   depth/NNNNNN.png   16 bit, mm, by the column frame; it has the field of
//                      view of the video. Old versions wrote .npy files, which
//                      are not read.
//   confidence/NNNNNN.png  0, 1 or 2 (ARConfidenceLevel)
#ifndef SERVER_TOOLS_CAPTURE_STRAY_SCANNER_H_
#define SERVER_TOOLS_CAPTURE_STRAY_SCANNER_H_

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/tools/capture/capture.h"

namespace treeline::capture {

struct StrayRow {
  int video_frame = 0;  // from 0
  std::string frame;    // names the files of depth and confidence
  // Our axes of the camera; y of the world is up.
  geometry::Rigid3 world_from_camera;
  std::optional<std::array<double, 4>> intrinsics;  // fx, fy, cx, cy
};

struct StrayOdometry {
  std::vector<StrayRow> rows;
  LeftOut left_out;
};

// INVALID_ARGUMENT, "FILE:LINE: ...", for what is no such file. A line whose
// pose is no pose, or whose time is not later than that before, is left out.
absl::StatusOr<StrayOdometry> ParseStrayOdometry(absl::string_view text,
                                                 const std::string& file);

// fx, fy, cx, cy of a 3 x 3 matrix, a row a line.
absl::StatusOr<std::array<double, 4>> ParseStrayCameraMatrix(
    absl::string_view text, const std::string& file);

bool IsStrayScanner(const std::string& folder);
absl::StatusOr<Capture> OpenStrayScanner(const std::string& folder,
                                         const OpenOptions& options);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_STRAY_SCANNER_H_
