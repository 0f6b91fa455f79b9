// Cameras and calibrations, proto <-> C++.
#ifndef COMMON_WIRE_CAMERA_H_
#define COMMON_WIRE_CAMERA_H_

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/camera/camera.h"
#include "common/camera/rgbd_calibration.h"
#include "treeline/v1/camera.pb.h"

namespace treeline::wire {

// What RgbdCalibration::depth_scale may be: world units per measured metre.
inline constexpr double kMinDepthScale = 0.5;
inline constexpr double kMaxDepthScale = 2.0;

v1::Camera ToProto(const camera::Camera& camera);
// INVALID_ARGUMENT naming `field`: an unknown model, a wrong number of
// parameters, a NaN, a focal length or a size that is not positive.
absl::StatusOr<camera::Camera> FromProto(const v1::Camera& proto,
                                         absl::string_view field);

v1::RgbdSensor ToProto(camera::RgbdSensor sensor);
// INVALID_ARGUMENT naming `field` for UNSPECIFIED and unknown values.
absl::StatusOr<camera::RgbdSensor> FromProto(v1::RgbdSensor proto,
                                             absl::string_view field);

v1::RgbdCalibration ToProto(const camera::RgbdCalibration& calibration);
absl::StatusOr<camera::RgbdCalibration> FromProto(
    const v1::RgbdCalibration& proto, absl::string_view field);

// INVALID_ARGUMENT naming `field` unless kMinDepthScale..kMaxDepthScale.
absl::Status CheckDepthScale(double depth_scale, absl::string_view field);

}  // namespace treeline::wire

#endif  // COMMON_WIRE_CAMERA_H_
