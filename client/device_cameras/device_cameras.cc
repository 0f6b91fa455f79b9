#include "client/device_cameras/device_cameras.h"

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline::device_cameras {
namespace {

// From a picture's corner to the centre of its first pixel.
constexpr double kCorner_px = 0.5;

// Half a turn about x: its own inverse.
constexpr geometry::Rotation3 kOpenGlFromCamera = {0, 1, 0, 0};
// Forward, left and up of right, down and forward.
constexpr geometry::Rotation3 kBodyFromCamera = {0.5, -0.5, 0.5, -0.5};

absl::StatusOr<camera::Camera> Create(camera::CameraModel model, int width_px,
                                      int height_px,
                                      const std::vector<double>& parameters) {
  return camera::Camera::Create(model, width_px, height_px, parameters.data(),
                                static_cast<int>(parameters.size()));
}

// a_from_b, of which columns come first.
absl::StatusOr<geometry::Rigid3> RigidFromColumns(
    const std::array<double, 16>& columns) {
  std::array<double, 16> rows{};
  for (size_t i = 0; i < rows.size(); ++i) {
    rows[i] = columns[i % 4 * 4 + i / 4];
  }
  return geometry::RigidFromMatrix4(rows);
}

absl::StatusOr<geometry::Rigid3> CameraPoseOfColumns(
    const std::array<double, 16>& columns) {
  TL_ASSIGN_OR_RETURN(const geometry::Rigid3 device_from_opengl,
                      RigidFromColumns(columns));
  return CameraFromOpenGlPose(device_from_opengl);
}

geometry::Rigid3 Turned(const geometry::Rigid3& pose,
                        const geometry::Rotation3& turn) {
  return {geometry::Normalized(pose.rotation * turn), pose.translation};
}

}  // namespace

absl::StatusOr<camera::Camera> CameraFromColmap(
    absl::string_view model, int width_px, int height_px,
    const std::vector<double>& parameters) {
  TL_ASSIGN_OR_RETURN(const camera::CameraModel known,
                      camera::ParseCameraModel(model));
  std::vector<double> moved = parameters;
  const auto at = static_cast<size_t>(camera::CameraPrincipalPointIndex(known));
  if (moved.size() >= at + 2) {
    moved[at] -= kCorner_px;
    moved[at + 1] -= kCorner_px;
  }
  return Create(known, width_px, height_px, moved);
}

absl::StatusOr<geometry::Rigid3> WorldFromCameraOfColmap(
    double qw, double qx, double qy, double qz, geometry::Vec3 translation_m) {
  TL_ASSIGN_OR_RETURN(
      const geometry::Rigid3 camera_from_world,
      geometry::RigidFromQuaternion(qw, qx, qy, qz, translation_m));
  return camera_from_world.Inverse();
}

absl::StatusOr<camera::Camera> CameraFromOpenCv(
    const std::array<double, 9>& camera_matrix, int width_px, int height_px,
    const std::vector<double>& distortion) {
  std::vector<double> parameters = {camera_matrix[0], camera_matrix[4],
                                    camera_matrix[2], camera_matrix[5]};
  parameters.insert(parameters.end(), distortion.begin(), distortion.end());
  switch (distortion.size()) {
    case 0:
      return Create(camera::CameraModel::kPinhole, width_px, height_px,
                    parameters);
    case 4:
      return Create(camera::CameraModel::kOpenCv, width_px, height_px,
                    parameters);
    case 5:
      parameters.resize(parameters.size() + 3);
      [[fallthrough]];
    case 8:
      return Create(camera::CameraModel::kFullOpenCv, width_px, height_px,
                    parameters);
    default:
      return absl::InvalidArgumentError(
          absl::StrCat("there is no model with ", distortion.size(),
                       " distortion coefficients; 0, 4, 5 or 8 are known"));
  }
}

geometry::Rigid3 WorldFromCameraOfOpenCv(geometry::Vec3 rvec_rad,
                                         geometry::Vec3 tvec_m) {
  const geometry::Rigid3 camera_from_world = {
      geometry::Rotation3::FromAxisAngle(rvec_rad), tvec_m};
  return camera_from_world.Inverse();
}

absl::StatusOr<camera::Camera> CameraFromArKit(
    const std::array<double, 9>& intrinsics, int width_px, int height_px) {
  return Create(camera::CameraModel::kPinhole, width_px, height_px,
                {intrinsics[0], intrinsics[4], intrinsics[6] - kCorner_px,
                 intrinsics[7] - kCorner_px});
}

absl::StatusOr<geometry::Rigid3> DeviceFromCameraOfArKit(
    const std::array<double, 16>& transform) {
  return CameraPoseOfColumns(transform);
}

absl::StatusOr<camera::Camera> CameraFromArCore(
    const std::array<double, 2>& focal_length_px,
    const std::array<double, 2>& principal_point_px, int width_px,
    int height_px) {
  return Create(
      camera::CameraModel::kPinhole, width_px, height_px,
      {focal_length_px[0], focal_length_px[1],
       principal_point_px[0] - kCorner_px, principal_point_px[1] - kCorner_px});
}

absl::StatusOr<geometry::Rigid3> DeviceFromCameraOfArCore(
    geometry::Vec3 translation_m, double qx, double qy, double qz, double qw) {
  TL_ASSIGN_OR_RETURN(
      const geometry::Rigid3 device_from_opengl,
      geometry::RigidFromQuaternion(qw, qx, qy, qz, translation_m));
  return CameraFromOpenGlPose(device_from_opengl);
}

absl::StatusOr<camera::Camera> CameraFromWebXr(
    const std::array<double, 16>& projection_matrix, int width_px,
    int height_px) {
  const std::array<double, 16>& p = projection_matrix;
  if (p[11] != -1 || p[15] != 0) {
    return absl::InvalidArgumentError(
        "the matrix is no perspective projection");
  }
  return Create(camera::CameraModel::kPinhole, width_px, height_px,
                {p[0] * width_px / 2, p[5] * height_px / 2,
                 width_px * (1 - p[8]) / 2 - kCorner_px,
                 height_px * (1 + p[9]) / 2 - kCorner_px});
}

absl::StatusOr<geometry::Rigid3> DeviceFromCameraOfWebXr(
    const std::array<double, 16>& view_transform) {
  return CameraPoseOfColumns(view_transform);
}

geometry::Rigid3 OpenGlFromCameraPose(const geometry::Rigid3& a_from_camera) {
  return Turned(a_from_camera, kOpenGlFromCamera.Inverse());
}

geometry::Rigid3 CameraFromOpenGlPose(const geometry::Rigid3& a_from_opengl) {
  return Turned(a_from_opengl, kOpenGlFromCamera);
}

geometry::Rigid3 BodyFromCameraPose(const geometry::Rigid3& a_from_camera) {
  return Turned(a_from_camera, kBodyFromCamera.Inverse());
}

geometry::Rigid3 CameraFromBodyPose(const geometry::Rigid3& a_from_body) {
  return Turned(a_from_body, kBodyFromCamera);
}

}  // namespace treeline::device_cameras
