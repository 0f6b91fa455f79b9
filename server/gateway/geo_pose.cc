#include "server/gateway/geo_pose.h"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/wire/geometry.h"

namespace treeline::gateway {
namespace {

constexpr double kRadPerDeg = std::numbers::pi / 180;

// WGS84.
constexpr double kSemiMajor_m = 6378137.0;
constexpr double kFlattening = 1 / 298.257223563;
constexpr double kSemiMinor_m = kSemiMajor_m * (1 - kFlattening);
// Squared eccentricities, first and second.
constexpr double kE2 = kFlattening * (2 - kFlattening);
constexpr double kEp2 = kE2 / (1 - kE2);

// 95 % of a chi-square distribution with three degrees of freedom.
constexpr double kChiSquare3Of95 = 7.814727903251179;

double Cube(double x) { return x * x * x; }

// Columns: the axes of `device` in `camera`.
geometry::Rotation3 CameraFromDevice() {
  return geometry::Rotation3::FromMatrix(
      geometry::Mat3{{1, 0, 0, 0, 0, -1, 0, 1, 0}});
}

}  // namespace

geometry::Vec3 EcefFromGeodetic(const GeodeticPosition& position) {
  const double latitude = position.latitude_deg * kRadPerDeg;
  const double longitude = position.longitude_deg * kRadPerDeg;
  const double sine = std::sin(latitude);
  // Radius of curvature across the meridian.
  const double normal_m = kSemiMajor_m / std::sqrt(1 - kE2 * sine * sine);
  const double from_axis_m =
      (normal_m + position.height_m) * std::cos(latitude);
  return {from_axis_m * std::cos(longitude), from_axis_m * std::sin(longitude),
          (normal_m * (1 - kE2) + position.height_m) * sine};
}

// Bowring's method (1976) on the reduced latitude; each step squares the error,
// and the first is already below a metre near the ellipsoid.
GeodeticPosition GeodeticFromEcef(geometry::Vec3 point_in_ecef_m) {
  const double from_axis_m = std::hypot(point_in_ecef_m.x, point_in_ecef_m.y);
  const double z_m = point_in_ecef_m.z;
  double reduced = std::atan2(z_m, (1 - kFlattening) * from_axis_m);
  double latitude = 0;
  for (int step = 0; step < 4; ++step) {
    latitude =
        std::atan2(z_m + kEp2 * kSemiMinor_m * Cube(std::sin(reduced)),
                   from_axis_m - kE2 * kSemiMajor_m * Cube(std::cos(reduced)));
    reduced =
        std::atan2((1 - kFlattening) * std::sin(latitude), std::cos(latitude));
  }
  const double sine = std::sin(latitude);
  // Well conditioned at every latitude, unlike from_axis / cos - normal.
  const double height_m = from_axis_m * std::cos(latitude) + z_m * sine -
                          kSemiMajor_m * std::sqrt(1 - kE2 * sine * sine);
  double longitude = std::atan2(point_in_ecef_m.y, point_in_ecef_m.x);
  if (longitude == -std::numbers::pi) longitude = std::numbers::pi;
  return {latitude / kRadPerDeg, longitude / kRadPerDeg, height_m};
}

geometry::Rotation3 EcefFromEnu(const GeodeticPosition& position) {
  const double sin_lat = std::sin(position.latitude_deg * kRadPerDeg);
  const double cos_lat = std::cos(position.latitude_deg * kRadPerDeg);
  const double sin_lon = std::sin(position.longitude_deg * kRadPerDeg);
  const double cos_lon = std::cos(position.longitude_deg * kRadPerDeg);
  return geometry::Rotation3::FromMatrix(
      geometry::Mat3{{-sin_lon, -sin_lat * cos_lon, cos_lat * cos_lon,  //
                      cos_lon, -sin_lat * sin_lon, cos_lat * sin_lon,   //
                      0, cos_lat, sin_lat}});
}

double HorizontalDistance_m(const GeodeticPosition& a,
                            const GeodeticPosition& b) {
  return geometry::Norm(EcefFromGeodetic({a.latitude_deg, a.longitude_deg, 0}) -
                        EcefFromGeodetic({b.latitude_deg, b.longitude_deg, 0}));
}

absl::Status CheckPosition(const GeodeticPosition& position,
                           absl::string_view field) {
  // Written so that NaN fails.
  if (!(std::abs(position.latitude_deg) <= 90)) {
    return wire::FieldError(field,
                            absl::StrCat("the latitude ", position.latitude_deg,
                                         " is outside -90..90 degrees"));
  }
  if (!(std::abs(position.longitude_deg) <= 180)) {
    return wire::FieldError(
        field, absl::StrCat("the longitude ", position.longitude_deg,
                            " is outside -180..180 degrees"));
  }
  if (!std::isfinite(position.height_m)) {
    return wire::FieldError(field, "the height is not a number");
  }
  return absl::OkStatus();
}

absl::StatusOr<GeoFrame> GeoFrame::Create(const v1::GeoAnchor& anchor,
                                          absl::string_view field) {
  const GeodeticPosition position{anchor.latitude_deg(), anchor.longitude_deg(),
                                  anchor.height_m()};
  TL_RETURN_IF_ERROR(CheckPosition(position, field));
  geometry::Rotation3 enu_from_world;
  if (anchor.has_enu_from_world()) {
    const v1::Quaternion& q = anchor.enu_from_world();
    const absl::StatusOr<geometry::Rigid3> rotation =
        geometry::RigidFromQuaternion(q.w(), q.x(), q.y(), q.z(), {});
    if (!rotation.ok()) {
      return base::Annotate(rotation.status(),
                            absl::StrCat(field, ".enu_from_world"));
    }
    enu_from_world = rotation->rotation;
  }
  return GeoFrame(position, {EcefFromEnu(position) * enu_from_world,
                             EcefFromGeodetic(position)});
}

GeoPose GeoFrame::ToGeoPose(const geometry::Rigid3& world_from_camera) const {
  const geometry::Rigid3 ecef_from_camera =
      ecef_from_world_ * world_from_camera;
  GeoPose pose;
  pose.position = GeodeticFromEcef(ecef_from_camera.translation);
  pose.enu_from_device =
      geometry::Normalized(EcefFromEnu(pose.position).Inverse() *
                           ecef_from_camera.rotation * CameraFromDevice());
  return pose;
}

geometry::Rigid3 GeoFrame::FromGeoPose(const GeoPose& pose) const {
  const geometry::Rigid3 ecef_from_camera{EcefFromEnu(pose.position) *
                                              pose.enu_from_device *
                                              CameraFromDevice().Inverse(),
                                          EcefFromGeodetic(pose.position)};
  // Subtracts the two large translations first.
  const geometry::Rotation3 world_from_ecef =
      ecef_from_world_.rotation.Inverse();
  return {geometry::Normalized(world_from_ecef * ecef_from_camera.rotation),
          world_from_ecef *
              (ecef_from_camera.translation - ecef_from_world_.translation)};
}

absl::StatusOr<GeoAccuracy> AccuracyOf(const double* covariance, int entries) {
  if (entries != 36) {
    return absl::InternalError(
        absl::StrCat("a covariance of ", entries, " entries instead of 36"));
  }
  const Eigen::Matrix<double, 6, 6> matrix =
      Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(
          covariance);
  if (!matrix.allFinite()) {
    return absl::InternalError("a covariance that is not finite");
  }
  const auto radius = [&](int first) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(
        matrix.block<3, 3>(first, first), Eigen::EigenvaluesOnly);
    return std::sqrt(kChiSquare3Of95 * solver.eigenvalues()(2));
  };
  GeoAccuracy accuracy{.position_m = radius(0),
                       .orientation_deg = radius(3) / kRadPerDeg};
  if (!(accuracy.position_m >= 0) || !(accuracy.orientation_deg >= 0)) {
    return absl::InternalError("a covariance with negative variances");
  }
  accuracy.orientation_deg = std::min(accuracy.orientation_deg, 180.0);
  return accuracy;
}

}  // namespace treeline::gateway
