#include "nav_agent/routes/route.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "absl/strings/str_cat.h"
#include "common/base/check_name.h"
#include "common/base/status_macros.h"

namespace treeline::routes {
namespace {

constexpr const char* kGoOnName = "go-on";
constexpr const char* kStopName = "stop";
// No building is larger (m); and no heading needs more turns (rad).
constexpr double kFarthest_m = 1e5;
constexpr double kMostYaw_rad = 1e3;

absl::Status CheckWaypoint(const Waypoint& waypoint, int levels) {
  const geometry::Vec2 at = waypoint.position_in_map;
  // Also for what is not a number.
  if (!(std::abs(at.x) <= kFarthest_m && std::abs(at.y) <= kFarthest_m)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "is at (", at.x, ", ", at.y, ") m: it must be finite, and on a map"));
  }
  if (waypoint.yaw_rad.has_value() &&
      !(std::abs(*waypoint.yaw_rad) <= kMostYaw_rad)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "looks to ", *waypoint.yaw_rad, " rad: that is no heading"));
  }
  if (waypoint.level < 0 || waypoint.level >= levels) {
    return absl::InvalidArgumentError(absl::StrCat(
        "is on level ", waypoint.level, "; the map has 0..", levels - 1));
  }
  if (!(waypoint.wait_s >= 0 && waypoint.wait_s <= kMaxWait_s)) {
    return absl::InvalidArgumentError(
        absl::StrCat("waits for ", waypoint.wait_s, " s; it must be 0..",
                     static_cast<int>(kMaxWait_s)));
  }
  if (waypoint.name.empty()) return absl::OkStatus();
  return base::CheckName(waypoint.name, "its", kMaxRouteNameBytes);
}

bool LeadsSomewhere(const Route& route) {
  const Waypoint& first = route.waypoints.front();
  double waits_s = 0;
  for (const Waypoint& waypoint : route.waypoints) {
    waits_s += waypoint.wait_s;
    if (waypoint.level != first.level) return true;
    if (geometry::Norm(waypoint.position_in_map - first.position_in_map) >=
        kMinLoop_m) {
      return true;
    }
  }
  return waits_s >= kMinLoopWait_s;
}

absl::Status CheckParts(const Route& route, int levels) {
  if (route.waypoints.empty() || route.waypoints.size() > kMaxWaypoints) {
    return absl::InvalidArgumentError(
        absl::StrCat("has ", route.waypoints.size(),
                     " waypoints; it needs 1 to ", kMaxWaypoints));
  }
  for (size_t i = 0; i < route.waypoints.size(); ++i) {
    const absl::Status checked = CheckWaypoint(route.waypoints[i], levels);
    if (!checked.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat(WaypointText(route, i), ": ", checked.message()));
    }
  }
  if (route.is_loop && !LeadsSomewhere(route)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "is a loop that leads nowhere: its waypoints must be ", kMinLoop_m,
        " m apart, or wait for ", kMinLoopWait_s, " s"));
  }
  return absl::OkStatus();
}

}  // namespace

const char* MissedPolicyName(MissedPolicy policy) {
  return policy == MissedPolicy::kStop ? kStopName : kGoOnName;
}

absl::StatusOr<MissedPolicy> ParseMissedPolicy(absl::string_view name) {
  if (name == kGoOnName) return MissedPolicy::kGoOn;
  if (name == kStopName) return MissedPolicy::kStop;
  return absl::InvalidArgumentError(
      absl::StrCat("when a waypoint is missed a route does '", name,
                   "'; there are ", kGoOnName, " and ", kStopName));
}

std::string WaypointText(const Route& route, size_t waypoint) {
  std::string text =
      absl::StrCat("waypoint ", waypoint + 1, " of ", route.waypoints.size());
  if (waypoint < route.waypoints.size() &&
      !route.waypoints[waypoint].name.empty()) {
    absl::StrAppend(&text, " '", route.waypoints[waypoint].name, "'");
  }
  return text;
}

absl::Status CheckRoute(const Route& route, int levels) {
  if (!route.name.empty()) {
    TL_RETURN_IF_ERROR(
        base::CheckName(route.name, "a route's", kMaxRouteNameBytes));
  }
  const absl::Status checked = CheckParts(route, levels);
  if (checked.ok()) return checked;
  return absl::InvalidArgumentError(absl::StrCat(
      route.name.empty() ? "the route"
                         : absl::StrCat("route '", route.name, "'"),
      ": ", checked.message()));
}

absl::Status CheckRoutes(std::span<const Route> routes, int levels) {
  if (routes.size() > kMaxRoutes) {
    return absl::InvalidArgumentError(absl::StrCat("there are ", routes.size(),
                                                   " routes; at most ",
                                                   kMaxRoutes, " are kept"));
  }
  std::set<std::string> names;
  for (const Route& route : routes) {
    TL_RETURN_IF_ERROR(
        base::CheckName(route.name, "a route's", kMaxRouteNameBytes));
    TL_RETURN_IF_ERROR(CheckRoute(route, levels));
    if (!names.insert(route.name).second) {
      return absl::InvalidArgumentError(
          absl::StrCat("two routes are called '", route.name, "'"));
    }
  }
  return absl::OkStatus();
}

}  // namespace treeline::routes
