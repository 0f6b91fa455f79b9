// A .sens file: a scene of ScanNet as it is downloaded, before SensReader.
//
// Conventions (github.com/ScanNet/ScanNet, SensReader/c++/src/sensorData.h,
// version 4; SensReader/python/SensorData.py), numbers little-endian:
//   head     uint32 version; the sensor's name (uint64 length, bytes); four 4 x
//   4
//            matrices of floats: intrinsic and extrinsic of colour, of depth;
//            int32 how colour and depth are packed; uint32 width and height of
//            colour, of depth; float units of depth in a metre; uint64 frames.
//   frame    4 x 4 floats, camera to world, -inf where tracking was lost;
//   uint64
//            times of colour and depth; uint64 bytes of colour, of depth;
//            these.
//   colour   1 PNG, 2 JPEG.
//   depth    16 bit, little-endian, rows from the top: 0 as they are, 1 zlib.
// What the matrices mean: scannet.h.
#ifndef SERVER_TOOLS_CAPTURE_SENS_FILE_H_
#define SERVER_TOOLS_CAPTURE_SENS_FILE_H_

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"
#include "common/image/decode.h"
#include "server/tools/capture/capture.h"

namespace treeline::capture {

struct SensFrame {
  std::array<double, 16> world_from_camera{};  // as it stands there, row by row
  uint64_t color_offset = 0;
  uint64_t color_bytes = 0;
  uint64_t depth_offset = 0;
  uint64_t depth_bytes = 0;
};

struct SensContents {
  camera::Camera color;
  camera::Camera depth;
  geometry::Rigid3 color_from_depth;
  bool depth_is_packed = false;  // by zlib
  double depth_unit_m = 0.001;
  std::vector<SensFrame> frames;
  // Frames that the file says it has, and which were cut off.
  uint64_t cut_off = 0;
};

// Fills `out` with the file's bytes from `offset` on.
using ReadBytes =
    std::function<absl::Status(uint64_t offset, std::span<uint8_t> out)>;

// Reads all but the pictures. INVALID_ARGUMENT: it is no .sens file of version
// 4, its cameras are none, or it packs pictures in a way that is not read.
absl::StatusOr<SensContents> ReadSens(const ReadBytes& read, uint64_t size);

// Depth of one frame in mm, unpacked. INVALID_ARGUMENT: it is broken, or has
// not the size that the head says.
absl::StatusOr<image::DepthImage> DecodeSensDepth(absl::string_view bytes,
                                                  const SensContents& contents);

bool IsSens(const std::string& path);
absl::StatusOr<Capture> OpenSens(const std::string& path,
                                 const OpenOptions& options);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_SENS_FILE_H_
