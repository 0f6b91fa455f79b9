// Between the conventions of others and ours (docs/frames.md).
//
//   camera: ARKit and OpenGL have x right, y up, z backwards; ours has y down
//           and z forward. For ARKit that is in the landscape orientation of
//           the sensor, however the phone was held (Apple's documentation of
//           ARCamera.transform).
//   world:  ARKit's has y up, along gravity (ARConfiguration.WorldAlignment);
//           ours gets z up.
//   pixels: Apple, nerfstudio and COLMAP measure the principal point from the
//           corner of the top left pixel, whose centre is at (0.5, 0.5) then
//           (Apple's documentation of intrinsicMatrix: "relative to the
//           top-left corner of the top-left pixel"; nerfstudio's
//           Cameras.get_image_coords with its pixel_offset of 0.5).
#ifndef SERVER_TOOLS_CAPTURE_CONVENTIONS_H_
#define SERVER_TOOLS_CAPTURE_CONVENTIONS_H_

#include <string>

#include "absl/status/statusor.h"
#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"
#include "common/image/decode.h"

namespace treeline::capture {

// The rotation that brings `axis` ("x", "-y", ...) of a world up to z, by a
// quarter turn, a half or none. INVALID_ARGUMENT: no axis.
absl::StatusOr<geometry::Rotation3> ZUpFromAxis(const std::string& axis);

// The same, for the axis that the options name, or else the format's own.
absl::StatusOr<geometry::Rotation3> ZUpFrom(const std::string& option,
                                            const std::string& format_axis);

// The pose of our camera, given that of the same one with OpenGL's axes.
geometry::Rigid3 FromOpenGlCamera(const geometry::Rigid3& world_from_opengl);

// `rotation` applied to the world of a pose.
geometry::Rigid3 Rotated(const geometry::Rotation3& rotation,
                         const geometry::Rigid3& pose);

// A pinhole whose principal point is measured from the corner of the picture.
// INVALID_ARGUMENT unless it is a camera and its principal point lies in the
// picture.
absl::StatusOr<camera::Camera> PinholeFromCorner(image::ImageSize size,
                                                 double fx, double fy,
                                                 double cx, double cy);

// The camera at another size of its picture, with the same field of view: a
// pixel (x, y) goes to ((x + 0.5) s - 0.5, ...), with one s for each axis. The
// camera must have two focal lengths (PINHOLE, OPENCV, ...).
absl::StatusOr<camera::Camera> ScaledTo(const camera::Camera& camera,
                                        image::ImageSize size);

}  // namespace treeline::capture

#endif  // SERVER_TOOLS_CAPTURE_CONVENTIONS_H_
