// Frames, proto <-> C++. This is where images from outside are decoded.
#ifndef COMMON_WIRE_FRAME_H_
#define COMMON_WIRE_FRAME_H_

#include <optional>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/camera/rgbd_calibration.h"
#include "common/image/decode.h"
#include "common/image/frame.h"
#include "common/wire/query_frame.h"
#include "treeline/v1/frame.pb.h"

namespace treeline::wire {

// What a client sends.
v1::Frame ToProto(const QueryFrame& frame);

// What a server makes of it: decoded images, and the calibration that the
// request and the scene give together:
//
//   request                     calibration of the result
//   no camera, no depth         nullopt: the scene's; of a picture of another
//                               size than its, or whose EXIF names another
//                               lens: the scene's, with AssumedCamera as its
//                               colour camera
//   no camera, SCENE_CALIBR.    nullopt: the scene's
//   camera, (SCENE_CALIBR.)     the scene's, with `camera` as its colour camera
//   REGISTERED_TO_COLOR         colour camera for both, identity between them
//   EXPLICIT                    colour camera and the one described
//
// where "colour camera" is the request's or else the scene's. The pose sensor
// is always the scene's.
//
// INVALID_ARGUMENT, naming the field: images that are missing, truncated,
// corrupt, over `limits` or of another size than their camera; cameras and
// poses that are not valid; a unit or registration that is missing or absurd.
// Cheap checks come before decoding, and nothing is allocated for an image
// before its size was checked.
absl::StatusOr<image::Frame> FromProto(
    const v1::Frame& proto, const camera::RgbdCalibration& scene_calibration,
    const image::DecodeLimits& limits, absl::string_view field);

// The two halves of it, for a frame that is tried in several scenes: what does
// not depend on the scene, to be decoded once, without a calibration;
absl::StatusOr<image::Frame> PixelsFromProto(const v1::Frame& proto,
                                             const image::DecodeLimits& limits,
                                             absl::string_view field);
// and what becomes Frame::calibration in one scene. `pixels` are of the first;
// INVALID_ARGUMENT if their sizes are not those of the cameras.
absl::StatusOr<std::optional<camera::RgbdCalibration>> CalibrationFromProto(
    const v1::Frame& proto, const image::Frame& pixels,
    const camera::RgbdCalibration& scene_calibration, absl::string_view field);

// The colour camera that is assumed by the above, camera::AssumedCamera;
// nullopt: the request states one, or it is the scene's.
std::optional<camera::Camera> AssumedCamera(
    const v1::Frame& proto, const image::Frame& pixels,
    const camera::RgbdCalibration& scene_calibration);

}  // namespace treeline::wire

#endif  // COMMON_WIRE_FRAME_H_
