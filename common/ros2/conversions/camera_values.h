// Pictures and calibrations of cameras.
#ifndef COMMON_ROS2_CONVERSIONS_CAMERA_VALUES_H_
#define COMMON_ROS2_CONVERSIONS_CAMERA_VALUES_H_

#include "absl/status/statusor.h"
#include "common/camera/camera.h"
#include "common/image/image.h"
#include "common/ros2/messages/sensor_messages.h"

namespace treeline::conversions {

// The camera that took the pictures of a topic: k and d with the distortion
// models "plumb_bob", "rational_polynomial", "equidistant" and none; or, for
// pictures that image_proc has rectified, p alone. Binning and region of
// interest are taken into account. INVALID_ARGUMENT says what is missing: a
// camera that nobody has calibrated has a k of zeros.
absl::StatusOr<camera::Camera> CameraOf(const messages::CameraInfo& info,
                                        bool is_rectified);

// The other way. INVALID_ARGUMENT: none of ROS's models of distortion is like
// the camera's (FOV, ...).
absl::StatusOr<messages::CameraInfo> InfoOf(const camera::Camera& camera,
                                            const messages::Header& header);

// "rgb8", "bgr8", "rgba8", "bgra8", "mono8". INVALID_ARGUMENT names any other
// encoding, and sizes that do not fit.
absl::StatusOr<image::ColorImage> ColorOf(const messages::Image& image);
// JPEG or PNG, whatever `format` says.
absl::StatusOr<image::ColorImage> ColorOf(
    const messages::CompressedImage& image);

// "16UC1" and "mono16" in mm, "32FC1" in m (REP 118), of either byte order;
// what was not measured becomes 0.
absl::StatusOr<image::DepthImage> DepthOf(const messages::Image& image);
// compressed_depth_image_transport: 12 bytes, and a PNG in mm or of inverse
// depth; or a PNG in mm alone.
absl::StatusOr<image::DepthImage> DepthOf(
    const messages::CompressedImage& image);

}  // namespace treeline::conversions

#endif  // COMMON_ROS2_CONVERSIONS_CAMERA_VALUES_H_
