// The camera of a picture that was mirrored, cropped or resized. For one that
// was turned, see common/image/quarter_turn.h.
//
// Pixel centres are at integer coordinates. Each function says where a pixel
// (x, y) of a picture of w x h pixels goes; the camera that it returns images a
// ray there. Distortion goes with it, tangential and thin prism too.
#ifndef COMMON_CAMERA_DERIVED_CAMERA_H_
#define COMMON_CAMERA_DERIVED_CAMERA_H_

#include "absl/status/statusor.h"
#include "common/camera/camera.h"

namespace treeline::camera {

// After left and right were exchanged: (w - 1 - x, y).
Camera Mirrored(const Camera& camera);

// Of the window of width x height pixels whose top left pixel is (left, top):
// (x - left, y - top). INVALID_ARGUMENT: it is empty or leaves the picture.
absl::StatusOr<Camera> Cropped(const Camera& camera, int left, int top,
                               int width, int height);

// After resizing by `factor`: ((x + 0.5) * factor - 0.5, the same of y). Width
// and height are rounded. INVALID_ARGUMENT: not positive, or the result has no
// pixels or too many.
absl::StatusOr<Camera> Resized(const Camera& camera, double factor);

// With its focal lengths times `factor`, and the same picture. INVALID_ARGUMENT
// unless that makes a camera.
absl::StatusOr<Camera> WithFocalScaled(const Camera& camera, double factor);

// With its principal point moved by so many pixels, and the same picture.
// INVALID_ARGUMENT unless that makes a camera.
absl::StatusOr<Camera> WithPrincipalPointMoved(const Camera& camera, double x,
                                               double y);

// With `k` added to its first coefficient of radial distortion: a pinhole
// camera becomes SIMPLE_RADIAL or OPENCV. INVALID_ARGUMENT for fisheyes.
absl::StatusOr<Camera> WithRadialAdded(const Camera& camera, double k);

}  // namespace treeline::camera

#endif  // COMMON_CAMERA_DERIVED_CAMERA_H_
