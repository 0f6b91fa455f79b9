// A zone as somebody draws it: a polygon on one level of a map.
#ifndef NAV_AGENT_ZONES_ZONE_H_
#define NAV_AGENT_ZONES_ZONE_H_

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/geometry/rigid2.h"

namespace treeline::zones {

enum class ZoneKind : uint8_t {
  kKeepOut,  // no part of the robot may be in it
  kSpeed,    // it is at most so fast in it
  kOneWay    // its middle does not drive against the direction in it
};

// "keep-out", "speed", "one-way".
const char* ZoneKindName(ZoneKind kind);
// INVALID_ARGUMENT names those there are.
absl::StatusOr<ZoneKind> ParseZoneKind(absl::string_view name);

struct Zone {
  std::string name;
  ZoneKind kind = ZoneKind::kKeepOut;
  int level = 0;
  // In order, either way round; the last is joined to the first (map, m).
  std::vector<geometry::Vec2> corners_in_map;
  // Of kSpeed (m/s).
  double max_mps = 0;
  // Of kOneWay: counter-clockwise from the map's x axis (rad).
  double direction_rad = 0;

  bool operator==(const Zone&) const = default;
};

inline constexpr size_t kMaxZones = 1000;
inline constexpr size_t kMaxZoneCorners = 100;
inline constexpr size_t kMaxZoneNameBytes = 64;
// Slower than that a base hardly moves; and none is faster (m/s).
inline constexpr double kMinZoneSpeed_mps = 0.05;
inline constexpr double kMaxZoneSpeed_mps = 5;

// INVALID_ARGUMENT, with the zone's name, for a zone that means nothing: no
// name or one with control characters, a level that the map does not have,
// fewer than 3 corners or too many, corners that are not finite, absurdly far
// or the same, sides that cross or touch one another, a speed or direction that
// is none.
absl::Status CheckZone(const Zone& zone, int levels);

// The same for all, and INVALID_ARGUMENT for too many and for two of one name.
absl::Status CheckZones(std::span<const Zone> zones, int levels);

// Whether a point lies within the zone's corners.
bool Contains(const Zone& zone, geometry::Vec2 point_in_map);

}  // namespace treeline::zones

#endif  // NAV_AGENT_ZONES_ZONE_H_
