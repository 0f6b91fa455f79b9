// A scene of ScanNet, as its SensReader exports it.
//
// Conventions (github.com/ScanNet/ScanNet, README.md and SensReader/python/
// SensorData.py): color/N.jpg, depth/N.png (16 bit, mm), pose/N.txt (4 x 4,
// camera to world, x right, y down, z forward; -inf where tracking was lost),
// intrinsic/intrinsic_color.txt and intrinsic_depth.txt (4 x 4, px). Both
// cameras have the same pose: their extrinsics in the files are the identity.
// The world has z up, along the measured gravity. Nothing says where in a pixel
// (0, 0) is; the centre is taken for it, as programs that use OpenCV do.
#ifndef SERVER_TOOLS_CAPTURE_SCANNET_H_
#define SERVER_TOOLS_CAPTURE_SCANNET_H_

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/image/decode.h"
#include "server/tools/capture/capture.h"

namespace treeline::capture {

// A pinhole from a 4 x 4 matrix. INVALID_ARGUMENT, "FILE:LINE: ...".
absl::StatusOr<camera::Camera> ParseScanNetIntrinsic(absl::string_view text,
                                                     image::ImageSize size,
                                                     const std::string& file);

bool IsScanNet(const std::string& folder);
absl::StatusOr<Capture> OpenScanNet(const std::string& folder,
                                    const OpenOptions& options);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_SCANNET_H_
