#include "server/tools/capture/conventions.h"

#include <array>
#include <numbers>

#include "absl/strings/str_cat.h"

namespace treeline::capture {
namespace {

// A half turn about x: y and z change their signs.
constexpr geometry::Rotation3 kOpenGlFromCamera{0, 1, 0, 0};

}  // namespace

absl::StatusOr<geometry::Rotation3> ZUpFromAxis(const std::string& axis) {
  constexpr double kQuarter = std::numbers::pi / 2;
  struct Turn {
    const char* axis;
    geometry::Vec3 axis_angle_rad;
  };
  constexpr Turn kTurns[] = {
      {"x", {0, -kQuarter, 0}}, {"-x", {0, kQuarter, 0}},
      {"y", {kQuarter, 0, 0}},  {"-y", {-kQuarter, 0, 0}},
      {"z", {0, 0, 0}},         {"-z", {2 * kQuarter, 0, 0}},
  };
  for (const Turn& turn : kTurns) {
    if (axis == turn.axis) {
      return geometry::Rotation3::FromAxisAngle(turn.axis_angle_rad);
    }
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "up is '", axis, "'; it must be one of x, -x, y, -y, z and -z"));
}

absl::StatusOr<geometry::Rotation3> ZUpFrom(const std::string& option,
                                            const std::string& format_axis) {
  return ZUpFromAxis(option.empty() ? format_axis : option);
}

geometry::Rigid3 FromOpenGlCamera(const geometry::Rigid3& world_from_opengl) {
  return world_from_opengl * geometry::Rigid3{kOpenGlFromCamera, {}};
}

geometry::Rigid3 Rotated(const geometry::Rotation3& rotation,
                         const geometry::Rigid3& pose) {
  return geometry::Rigid3{rotation, {}} * pose;
}

absl::StatusOr<camera::Camera> PinholeFromCorner(image::ImageSize size,
                                                 double fx, double fy,
                                                 double cx, double cy) {
  if (!(cx > 0) || !(cy > 0) || cx >= size.width || cy >= size.height) {
    return absl::InvalidArgumentError(
        absl::StrCat("its principal point (", cx, ", ", cy,
                     ") is outside of the picture of ", size.width, " x ",
                     size.height, " pixels"));
  }
  const std::array<double, 4> parameters{fx, fy, cx - 0.5, cy - 0.5};
  return camera::Camera::Create(camera::CameraModel::kPinhole, size.width,
                                size.height, parameters.data(), 4);
}

absl::StatusOr<camera::Camera> ScaledTo(const camera::Camera& camera,
                                        image::ImageSize size) {
  const double sx = static_cast<double>(size.width) / camera.width();
  const double sy = static_cast<double>(size.height) / camera.height();
  std::array<double, camera::Camera::kMaxParameters> p = camera.parameters();
  p[0] *= sx;
  p[1] *= sy;
  p[2] = (p[2] + 0.5) * sx - 0.5;
  p[3] = (p[3] + 0.5) * sy - 0.5;
  return camera::Camera::Create(camera.model(), size.width, size.height,
                                p.data(),
                                camera::CameraParameterCount(camera.model()));
}

}  // namespace treeline::capture
