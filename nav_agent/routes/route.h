// A route as somebody sets it up: waypoints in their order.
#ifndef NAV_AGENT_ROUTES_ROUTE_H_
#define NAV_AGENT_ROUTES_ROUTE_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/geometry/rigid2.h"

namespace treeline::routes {

struct Waypoint {
  // In the map (m).
  geometry::Vec2 position_in_map = {};
  int level = 0;
  // Counter-clockwise from the map's x axis (rad); nullopt: where the way leads
  // on from there.
  std::optional<double> yaw_rad = std::nullopt;
  // How long the robot stands there (s).
  double wait_s = 0;
  // For people; may be empty.
  std::string name = {};

  bool operator==(const Waypoint&) const = default;
};

// What becomes of a route when a waypoint cannot be reached.
enum class MissedPolicy : uint8_t {
  kGoOn,  // to the next one
  kStop   // it ends
};
// "go-on", "stop".
const char* MissedPolicyName(MissedPolicy policy);
// INVALID_ARGUMENT names those there are.
absl::StatusOr<MissedPolicy> ParseMissedPolicy(absl::string_view name);

struct Route {
  // Empty: it is driven once, and not kept.
  std::string name = {};
  std::vector<Waypoint> waypoints = {};
  // From the last to the first, again and again.
  bool is_loop = false;
  MissedPolicy when_missed = MissedPolicy::kGoOn;

  bool operator==(const Route&) const = default;
};

inline constexpr size_t kMaxRoutes = 1000;
inline constexpr size_t kMaxWaypoints = 100;
inline constexpr size_t kMaxRouteNameBytes = 64;
// A day (s).
inline constexpr double kMaxWait_s = 86400;
// A loop leads as far away as this, or waits as long: else a robot would spin
// on the spot (m, s).
inline constexpr double kMinLoop_m = 0.5;
inline constexpr double kMinLoopWait_s = 1;

// INVALID_ARGUMENT, with the route's name, for one that means nothing: no
// waypoints or too many, names with control characters, positions or headings
// that are not finite, or absurdly far, levels that the map does not have,
// waits outside of [0, kMaxWait_s], a loop that leads nowhere. An empty name
// passes.
absl::Status CheckRoute(const Route& route, int levels);

// The same for all that are kept, and INVALID_ARGUMENT for too many, for none
// of a name and for two of one name.
absl::Status CheckRoutes(std::span<const Route> routes, int levels);

// "waypoint 2 of 5 'door'".
std::string WaypointText(const Route& route, size_t waypoint);

}  // namespace treeline::routes

#endif  // NAV_AGENT_ROUTES_ROUTE_H_
