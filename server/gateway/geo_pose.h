// Where a scene lies on the Earth: WGS84, East-North-Up and OGC GeoPose.
//
// Frames beside those of docs/frames.md:
//   ecef    Earth-centred, Earth-fixed: x to latitude 0, longitude 0; z to the
//           north pole; metres
//   enu     East, North, Up of the ellipsoid at one position, which the name
//           or the comment says; at the poles by the longitude of the position
//   device  what a GeoPose turns: x to the right of the picture, y forward
//           along the optical axis, z to the top of the picture. A camera held
//           level that looks north has the identity. It is `camera` (x right,
//           y down, z forward) with other names for its axes, and the frame
//           that Open AR Cloud's clients assume.
#ifndef SERVER_GATEWAY_GEO_POSE_H_
#define SERVER_GATEWAY_GEO_POSE_H_

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/geometry/rigid3.h"
#include "common/geometry/vector3.h"
#include "treeline/v1/geometry.pb.h"

namespace treeline::gateway {

// On the WGS84 ellipsoid.
struct GeodeticPosition {
  // -90..90.
  double latitude_deg = 0;
  // (-180, 180] where computed here.
  double longitude_deg = 0;
  // Above the ellipsoid, not above the sea.
  double height_m = 0;

  bool operator==(const GeodeticPosition&) const = default;
};

// OGC GeoPose 1.0 (21-056r11), Basic-Quaternion.
struct GeoPose {
  GeodeticPosition position;
  // Into East-North-Up at `position`.
  geometry::Rotation3 enu_from_device;
};

geometry::Vec3 EcefFromGeodetic(const GeodeticPosition& position);
// The inverse, to better than a micrometre for points within 50 km of the
// ellipsoid. On the axis of the Earth the longitude is 0.
GeodeticPosition GeodeticFromEcef(geometry::Vec3 point_in_ecef_m);

// Columns East, North, Up at `position`.
geometry::Rotation3 EcefFromEnu(const GeodeticPosition& position);

// Straight-line distance (m) of the feet of two positions on the ellipsoid;
// heights do not count.
double HorizontalDistance_m(const GeodeticPosition& a,
                            const GeodeticPosition& b);

// INVALID_ARGUMENT naming `field`: not finite, or latitude or longitude outside
// -90..90 and -180..180.
absl::Status CheckPosition(const GeodeticPosition& position,
                           absl::string_view field);

// The world frame of a scene, tied to the Earth. Immutable.
class GeoFrame {
 public:
  // INVALID_ARGUMENT naming `field`: a position or a rotation that is none.
  static absl::StatusOr<GeoFrame> Create(const v1::GeoAnchor& anchor,
                                         absl::string_view field);

  const GeodeticPosition& anchor() const { return anchor_; }

  //   ecef_from_world = (ecef_from_enu * enu_from_world, position of the
  //   anchor) enu_from_device = enu_from_ecef(at the camera) * ecef_from_world
  //                     * world_from_camera * camera_from_device
  // East, North and Up at the camera are not those at the anchor: 1 km away
  // they differ by about 0.009 degrees, and near the poles by any angle.
  GeoPose ToGeoPose(const geometry::Rigid3& world_from_camera) const;
  // The inverse: world_from_camera.
  geometry::Rigid3 FromGeoPose(const GeoPose& pose) const;

 private:
  GeoFrame(const GeodeticPosition& anchor,
           const geometry::Rigid3& ecef_from_world)
      : anchor_(anchor), ecef_from_world_(ecef_from_world) {}

  GeodeticPosition anchor_;
  geometry::Rigid3 ecef_from_world_;
};

// How far the truth may be from a pose: with a probability of at least 95 %
// (of the error that the covariance describes) not farther.
struct GeoAccuracy {
  double position_m = 0;
  double orientation_deg = 0;
};

// From a pose's covariance as LocalizeResponse has it (36 entries). Each is
// sqrt(7.815 * largest eigenvalue) of its 3x3 block: the longest half axis of
// the ellipsoid that holds 95 % of a normal distribution in three dimensions,
// so the ball around the answer holds at least as much. The angle is at most
// 180 degrees. INTERNAL: not 36 finite entries, or not a covariance.
absl::StatusOr<GeoAccuracy> AccuracyOf(const double* covariance, int entries);

}  // namespace treeline::gateway

#endif  // SERVER_GATEWAY_GEO_POSE_H_
