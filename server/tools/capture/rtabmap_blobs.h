// What RTAB-Map keeps in the blobs of its databases.
//
// Laid down, in github.com/introlab/rtabmap (July 2026), corelib/src:
//   calibration  CameraModel.cpp, serialize(), since version 0.18 of the
//                database: eleven int32 (version, 0 for one camera, width,
//                height, numbers of K, D, R, P and of the local transform),
//                then K, D, R and P as doubles and the transform as floats;
//                several cameras one after the other. StereoCameraModel.cpp:
//                the fourth int32 is 1. Before, floats (stepSensorData in
//                DBDriverSqlite3.cpp): fx, fy, cx, cy, since 0.11.2 width and
//                height, and the transform; a stereo camera has one float more.
//   matrices     Compression.cpp, compressData2(): a zlib stream, then rows,
//                columns and OpenCV's type as int32.
//   poses        twelve floats, the upper rows of a 4 x 4 matrix.
// All numbers are little-endian. A pixel's centre is at integers: project() of
// CameraModel.cpp is (u - cx) / fx.
#ifndef SERVER_TOOLS_CAPTURE_RTABMAP_BLOBS_H_
#define SERVER_TOOLS_CAPTURE_RTABMAP_BLOBS_H_

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"
#include "common/image/decode.h"
#include "common/image/image.h"

namespace treeline::capture {

using Bytes = std::span<const uint8_t>;

// The version of RTAB-Map by whose schema a database was made.
using RtabmapVersion = std::array<int, 3>;

// "0.21.4". INVALID_ARGUMENT: these are no three numbers.
absl::StatusOr<RtabmapVersion> ParseRtabmapVersion(absl::string_view text);

// The pictures of a database are those that the projection matrix is of, unless
// there is none: then they have the camera's distortion.
struct RtabmapCamera {
  camera::Camera camera;
  geometry::Rigid3 base_from_camera;
};

// `blob` of one node, whose picture, of all its cameras beside each other, has
// this size: old calibrations do not say theirs. UNIMPLEMENTED: a stereo
// camera. INVALID_ARGUMENT: it is none of a camera, or is cut off.
absl::StatusOr<std::vector<RtabmapCamera>> ParseRtabmapCalibration(
    Bytes blob, const RtabmapVersion& version, image::ImageSize picture);

// INVALID_ARGUMENT: not twelve floats, or not rigid. (Before 0.15.2 rotations
// could be scaled a little; they are brought to the nearest.)
absl::StatusOr<geometry::Rigid3> ParseRtabmapPose(Bytes blob);

// The poses of nodes that graph optimization found, by node; poses that are not
// rigid are not among them. INVALID_ARGUMENT: the two do not fit, or are
// broken.
absl::StatusOr<std::map<int, geometry::Rigid3>> ParseOptimizedPoses(
    Bytes ids, Bytes poses);

// One byte (0 to 100) for each pixel of a depth map of this size.
absl::StatusOr<std::vector<uint8_t>> ParseDepthConfidence(
    Bytes blob, image::ImageSize size);

// Depth in mm: RVL ("DEPTHRVL" in front) or 16-bit PNG in units of unit_m, or
// floats in metres as PNG.
absl::StatusOr<image::DepthImage> DecodeRtabmapDepth(Bytes blob, double unit_m);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_RTABMAP_BLOBS_H_
