#include "nav_agent/zones/zone.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/base/check_name.h"
#include "common/base/status_macros.h"

namespace treeline::zones {
namespace {

constexpr std::array<const char*, 3> kKindNames = {"keep-out", "speed",
                                                   "one-way"};
// No building is larger (m).
constexpr double kFarthest_m = 1e5;
// Nearer corners are one (m).
constexpr double kSameCorner_m = 1e-6;

// Of the corner c about the line from a to b: left of it, right of it, on it.
int SideOf(geometry::Vec2 a, geometry::Vec2 b, geometry::Vec2 c) {
  const double cross = geometry::Cross(b - a, c - a);
  const double scale = geometry::Norm(b - a) * geometry::Norm(c - a);
  if (std::abs(cross) <= 1e-12 * scale) return 0;
  return cross > 0 ? 1 : -1;
}

bool IsBetween(geometry::Vec2 a, geometry::Vec2 b, geometry::Vec2 c) {
  return c.x >= std::min(a.x, b.x) && c.x <= std::max(a.x, b.x) &&
         c.y >= std::min(a.y, b.y) && c.y <= std::max(a.y, b.y);
}

// Whether two lines have a point in common.
bool Meet(geometry::Vec2 a, geometry::Vec2 b, geometry::Vec2 c,
          geometry::Vec2 d) {
  // Most are far from one another.
  if (std::max(a.x, b.x) < std::min(c.x, d.x) ||
      std::max(c.x, d.x) < std::min(a.x, b.x) ||
      std::max(a.y, b.y) < std::min(c.y, d.y) ||
      std::max(c.y, d.y) < std::min(a.y, b.y)) {
    return false;
  }
  const int c_side = SideOf(a, b, c);
  const int d_side = SideOf(a, b, d);
  const int a_side = SideOf(c, d, a);
  const int b_side = SideOf(c, d, b);
  if (c_side * d_side < 0 && a_side * b_side < 0) return true;
  return (c_side == 0 && IsBetween(a, b, c)) ||
         (d_side == 0 && IsBetween(a, b, d)) ||
         (a_side == 0 && IsBetween(c, d, a)) ||
         (b_side == 0 && IsBetween(c, d, b));
}

// Two sides that have a point in common which is no corner of both.
std::optional<std::pair<size_t, size_t>> SidesThatMeet(
    const std::vector<geometry::Vec2>& corners) {
  const size_t n = corners.size();
  for (size_t i = 0; i < n; ++i) {
    const geometry::Vec2 a = corners[i];
    const geometry::Vec2 b = corners[(i + 1) % n];
    const geometry::Vec2 c = corners[(i + 2) % n];
    // The next side folds back onto this one.
    if (SideOf(a, b, c) == 0 && geometry::Dot(b - a, c - b) < 0) {
      return std::pair{i, (i + 1) % n};
    }
    for (size_t k = i + 2; k < n; ++k) {
      if ((k + 1) % n == i) continue;
      if (Meet(a, b, corners[k], corners[(k + 1) % n])) return std::pair{i, k};
    }
  }
  return std::nullopt;
}

absl::Status CheckCorners(const std::vector<geometry::Vec2>& corners) {
  if (corners.size() < 3 || corners.size() > kMaxZoneCorners) {
    return absl::InvalidArgumentError(absl::StrCat(
        "has ", corners.size(), " corners; it needs 3 to ", kMaxZoneCorners));
  }
  for (size_t i = 0; i < corners.size(); ++i) {
    const geometry::Vec2 at = corners[i];
    // Also for what is not a number.
    if (!(std::abs(at.x) <= kFarthest_m && std::abs(at.y) <= kFarthest_m)) {
      return absl::InvalidArgumentError(
          absl::StrCat("has corner ", i + 1, " at (", at.x, ", ", at.y,
                       ") m: it must be finite, and on a map"));
    }
    const size_t next = (i + 1) % corners.size();
    if (geometry::Norm(corners[next] - at) < kSameCorner_m) {
      return absl::InvalidArgumentError(absl::StrCat(
          "has corners ", i + 1, " and ", next + 1, " at the same place"));
    }
  }
  if (const auto sides = SidesThatMeet(corners)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "crosses itself: the sides from corners ", sides->first + 1, " and ",
        sides->second + 1, " meet; draw its corners in their order"));
  }
  return absl::OkStatus();
}

absl::Status CheckMeaning(const Zone& zone, int levels) {
  if (zone.level < 0 || zone.level >= levels) {
    return absl::InvalidArgumentError(absl::StrCat(
        "is on level ", zone.level, "; the map has 0..", levels - 1));
  }
  if (zone.kind == ZoneKind::kSpeed && !(zone.max_mps >= kMinZoneSpeed_mps &&
                                         zone.max_mps <= kMaxZoneSpeed_mps)) {
    return absl::InvalidArgumentError(
        absl::StrCat("allows ", zone.max_mps, " m/s; a speed zone allows ",
                     kMinZoneSpeed_mps, " to ", kMaxZoneSpeed_mps));
  }
  if (zone.kind == ZoneKind::kOneWay &&
      !(std::abs(zone.direction_rad) <= 1e3)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "has the direction ", zone.direction_rad, " rad, which is none"));
  }
  return CheckCorners(zone.corners_in_map);
}

}  // namespace

const char* ZoneKindName(ZoneKind kind) {
  return kKindNames.at(static_cast<size_t>(kind));
}

absl::StatusOr<ZoneKind> ParseZoneKind(absl::string_view name) {
  for (size_t i = 0; i < kKindNames.size(); ++i) {
    if (name == kKindNames.at(i)) return static_cast<ZoneKind>(i);
  }
  return absl::InvalidArgumentError(
      absl::StrCat("there are no zones of kind '", name, "'; there are ",
                   absl::StrJoin(kKindNames, ", ")));
}

absl::Status CheckZone(const Zone& zone, int levels) {
  TL_RETURN_IF_ERROR(base::CheckName(zone.name, "a zone's", kMaxZoneNameBytes));
  const absl::Status meaning = CheckMeaning(zone, levels);
  if (meaning.ok()) return meaning;
  return absl::InvalidArgumentError(
      absl::StrCat("zone '", zone.name, "' ", meaning.message()));
}

absl::Status CheckZones(std::span<const Zone> zones, int levels) {
  if (zones.size() > kMaxZones) {
    return absl::InvalidArgumentError(absl::StrCat(
        zones.size(), " zones; at most ", kMaxZones,
        " can be drawn (a mask file may have as many areas as it likes)"));
  }
  std::set<absl::string_view> names;
  for (const Zone& zone : zones) {
    TL_RETURN_IF_ERROR(CheckZone(zone, levels));
    if (!names.insert(zone.name).second) {
      return absl::InvalidArgumentError(
          absl::StrCat("two zones are called '", zone.name, "'"));
    }
  }
  return absl::OkStatus();
}

bool Contains(const Zone& zone, geometry::Vec2 point_in_map) {
  const std::vector<geometry::Vec2>& corners = zone.corners_in_map;
  bool is_inside = false;
  for (size_t i = 0; i < corners.size(); ++i) {
    const geometry::Vec2 a = corners[i];
    const geometry::Vec2 b = corners[(i + 1) % corners.size()];
    if ((a.y > point_in_map.y) == (b.y > point_in_map.y)) continue;
    const double x = a.x + (b.x - a.x) * (point_in_map.y - a.y) / (b.y - a.y);
    if (point_in_map.x < x) is_inside = !is_inside;
  }
  return is_inside;
}

}  // namespace treeline::zones
