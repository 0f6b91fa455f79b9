// What people say about a scene: its scene.json.
#ifndef SERVER_REPOSITORY_SCENE_METADATA_H_
#define SERVER_REPOSITORY_SCENE_METADATA_H_

#include <cstddef>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"

namespace treeline::repository {

inline constexpr size_t kMaxSceneJsonBytes = 64 << 10;
inline constexpr size_t kMaxDisplayNameBytes = 256;

// Where a scene lies on the Earth: the origin of its world frame at the
// position, and
//   direction_in_enu = enu_from_world * direction_in_world
// with x, y, z of `enu` to the East, to the North and up there.
struct GeoAnchor {
  // WGS84: -90..90 and -180..180.
  double latitude_deg = 0;
  double longitude_deg = 0;
  // Above the WGS84 ellipsoid: -12000..100000.
  double height_m = 0;
  geometry::Rotation3 enu_from_world;

  bool operator==(const GeoAnchor&) const = default;
};

struct SceneMetadata {
  // UTF-8 without control characters, at most kMaxDisplayNameBytes; may be
  // empty.
  std::string display_name = {};
  std::optional<GeoAnchor> geo_anchor = {};
  // The colour camera of queries that bring none.
  std::optional<camera::Camera> camera = {};

  bool operator==(const SceneMetadata&) const = default;
};

// enu_from_world of a world whose z axis points up and whose y axis points
// `heading_deg` clockwise from North, seen from above (0 North, 90 East): a
// rotation about z by -heading. With heading h,
//   x_world = (cos h, -sin h, 0)   y_world = (sin h, cos h, 0)   in enu.
geometry::Rotation3 EnuFromWorldOfHeading(double heading_deg);

// The text of a scene.json; docs/reference/scene-repository.md specifies it.
// INVALID_ARGUMENT, starting with "scene.json: " and the key, for what is not
// JSON, for unknown and repeated keys, for values of another type or out of
// range. Safe on hostile text.
absl::StatusOr<SceneMetadata> ParseSceneMetadata(absl::string_view text);

}  // namespace treeline::repository

#endif  // SERVER_REPOSITORY_SCENE_METADATA_H_
