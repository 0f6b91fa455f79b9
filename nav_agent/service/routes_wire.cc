#include "nav_agent/service/routes_wire.h"

#include <utility>

#include "common/wire/geometry.h"
#include "nav_agent/core/navigation_cause.h"
#include "nav_agent/service/utf8_text.h"

namespace treeline::agent_service {
namespace {

routes::Waypoint FromProto(const v1::Waypoint& proto) {
  routes::Waypoint waypoint = {.position_in_map = {proto.x_m(), proto.y_m()},
                               .level = proto.level(),
                               .wait_s = proto.wait_s(),
                               .name = proto.name()};
  if (proto.has_yaw_rad()) waypoint.yaw_rad = proto.yaw_rad();
  return waypoint;
}

// Numbers of the proto are one higher: 0 is "unspecified" there.
v1::RouteState ToProto(routes::RouteState state) {
  return static_cast<v1::RouteState>(static_cast<int>(state) + 1);
}

}  // namespace

absl::StatusOr<routes::Route> FromProto(const v1::Route& proto) {
  if (proto.when_missed() < v1::MISSED_POLICY_UNSPECIFIED ||
      proto.when_missed() > v1::MISSED_POLICY_STOP) {
    return wire::FieldError("when_missed", "is none that there is");
  }
  routes::Route route = {
      .name = proto.name(),
      .is_loop = proto.loop(),
      .when_missed = proto.when_missed() == v1::MISSED_POLICY_STOP
                         ? routes::MissedPolicy::kStop
                         : routes::MissedPolicy::kGoOn};
  for (const v1::Waypoint& waypoint : proto.waypoints()) {
    route.waypoints.push_back(FromProto(waypoint));
  }
  return route;
}

v1::Route ToProto(const routes::Route& route) {
  v1::Route proto;
  proto.set_name(Utf8(route.name));
  proto.set_loop(route.is_loop);
  proto.set_when_missed(route.when_missed == routes::MissedPolicy::kStop
                            ? v1::MISSED_POLICY_STOP
                            : v1::MISSED_POLICY_GO_ON);
  for (const routes::Waypoint& waypoint : route.waypoints) {
    v1::Waypoint& one = *proto.add_waypoints();
    one.set_x_m(waypoint.position_in_map.x);
    one.set_y_m(waypoint.position_in_map.y);
    one.set_level(waypoint.level);
    if (waypoint.yaw_rad.has_value()) one.set_yaw_rad(*waypoint.yaw_rad);
    one.set_wait_s(waypoint.wait_s);
    one.set_name(Utf8(waypoint.name));
  }
  return proto;
}

v1::RouteStatus ToProto(const routes::RouteStatus& status,
                        const absl::Status& keeping) {
  const routes::RouteProgress& progress = status.progress;
  const routes::Route& route = *progress.route;
  const routes::Waypoint& waypoint = route.waypoints[progress.waypoint];
  v1::RouteStatus proto;
  proto.set_id(status.id);
  proto.set_name(Utf8(route.name));
  proto.set_state(ToProto(status.state));
  proto.set_why(Utf8(status.why));
  proto.set_waypoint(static_cast<int32_t>(progress.waypoint));
  proto.set_waypoints(static_cast<int32_t>(route.waypoints.size()));
  proto.set_waypoint_name(Utf8(waypoint.name));
  proto.set_loop(route.is_loop);
  proto.set_lap(progress.lap);
  proto.set_waited_s(status.waited_s);
  proto.set_wait_s(waypoint.wait_s);
  proto.set_reached(progress.reached);
  proto.set_missed(progress.missed);
  for (const routes::MissedWaypoint& missed : progress.last_missed) {
    v1::MissedWaypoint& one = *proto.add_last_missed();
    one.set_waypoint(static_cast<int32_t>(missed.waypoint));
    one.set_lap(missed.lap);
    one.set_cause(core::NavigationCauseName(missed.cause));
    one.set_why(Utf8(missed.why));
  }
  proto.set_goal_id(status.goal_id);
  proto.set_survives_restart(keeping.ok());
  proto.set_warning(std::string(keeping.message()));
  return proto;
}

}  // namespace treeline::agent_service
