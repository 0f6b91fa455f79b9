// Cameras and poses as other systems state them, in Treeline's conventions: a
// camera frame with x right, y down, z forward, and the centre of the top left
// pixel at (0, 0). docs/frames.md has pictures of all of them. The TypeScript
// and Python clients have the same functions.
//
// `device` is the world of a device's own tracking: y up, its origin where the
// session began. Matrices are given as the systems store them, so of those of
// ARKit and WebXR columns come first. Errors are INVALID_ARGUMENT and say what
// is wrong. Everything is pure.
#ifndef CLIENT_DEVICE_CAMERAS_DEVICE_CAMERAS_H_
#define CLIENT_DEVICE_CAMERAS_DEVICE_CAMERAS_H_

#include <array>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"

namespace treeline::device_cameras {

// A line of COLMAP's cameras.txt: half a pixel is subtracted from cx and cy.
absl::StatusOr<camera::Camera> CameraFromColmap(
    absl::string_view model, int width_px, int height_px,
    const std::vector<double>& parameters);
// A line of images.txt: QW QX QY QZ TX TY TZ map points of the world into the
// camera.
absl::StatusOr<geometry::Rigid3> WorldFromCameraOfColmap(
    double qw, double qx, double qy, double qz, geometry::Vec3 translation_m);

// The camera of OpenCV's calibrateCamera(): fx 0 cx 0 fy cy 0 0 1, row by row,
// and no distortion coefficients, or 4, 5 or 8 of them (k1, k2, p1, p2, k3, k4,
// k5, k6).
absl::StatusOr<camera::Camera> CameraFromOpenCv(
    const std::array<double, 9>& camera_matrix, int width_px, int height_px,
    const std::vector<double>& distortion = {});
// Of solvePnP's rvec (rad) and tvec, which map points of the world into the
// camera.
geometry::Rigid3 WorldFromCameraOfOpenCv(geometry::Vec3 rvec_rad,
                                         geometry::Vec3 tvec_m);

// ARCamera.intrinsics, by columns (fx, 0, 0, 0, fy, 0, ox, oy, 1), with
// ARCamera.imageResolution. ARKit counts from the picture's corner: half a
// pixel is subtracted.
absl::StatusOr<camera::Camera> CameraFromArKit(
    const std::array<double, 9>& intrinsics, int width_px, int height_px);
// ARCamera.transform, by columns.
absl::StatusOr<geometry::Rigid3> DeviceFromCameraOfArKit(
    const std::array<double, 16>& transform);

// ARCore's getImageIntrinsics(), which belong to the CPU image. ARCore does not
// say from where it counts the principal point; it is taken to be the picture's
// corner, as in ARKit: half a pixel is subtracted.
absl::StatusOr<camera::Camera> CameraFromArCore(
    const std::array<double, 2>& focal_length_px,
    const std::array<double, 2>& principal_point_px, int width_px,
    int height_px);
// Camera.getPose(), not getDisplayOrientedPose(): its rotation in ARCore's
// order.
absl::StatusOr<geometry::Rigid3> DeviceFromCameraOfArCore(
    geometry::Vec3 translation_m, double qx, double qy, double qz, double qw);

// XRView.projectionMatrix, by columns, for the picture that it describes:
//   fx = P0 w / 2,  cx = w (1 - P8) / 2 - 0.5,
//   fy = P5 h / 2,  cy = h (1 + P9) / 2 - 0.5.
absl::StatusOr<camera::Camera> CameraFromWebXr(
    const std::array<double, 16>& projection_matrix, int width_px,
    int height_px);
// XRView.transform.matrix, by columns.
absl::StatusOr<geometry::Rigid3> DeviceFromCameraOfWebXr(
    const std::array<double, 16>& view_transform);

// The same place with a camera of OpenGL's axes (x right, y up, z backwards),
// to draw what is seen from it; and back.
geometry::Rigid3 OpenGlFromCameraPose(const geometry::Rigid3& a_from_camera);
geometry::Rigid3 CameraFromOpenGlPose(const geometry::Rigid3& a_from_opengl);

// The same place with the axes of a body in ROS (x forward along the optical
// axis, y left, z up); and back.
geometry::Rigid3 BodyFromCameraPose(const geometry::Rigid3& a_from_camera);
geometry::Rigid3 CameraFromBodyPose(const geometry::Rigid3& a_from_body);

}  // namespace treeline::device_cameras

#endif  // CLIENT_DEVICE_CAMERAS_DEVICE_CAMERAS_H_
