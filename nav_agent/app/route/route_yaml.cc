#include "nav_agent/app/route/route_yaml.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/json_text.h"
#include "common/base/status_macros.h"
#include "common/yaml/yaml_node.h"

namespace treeline::route_app {
namespace {

constexpr double kFarthest_m = 1e5;
constexpr double kMostYaw_rad = 1e3;
constexpr int kMostLevels = 1000;

absl::StatusOr<routes::Waypoint> ReadWaypoint(const yaml::YamlNode& node) {
  TL_RETURN_IF_ERROR(
      node.CheckKeys({"x", "y", "yaw", "level", "wait", "name"}));
  routes::Waypoint waypoint;
  TL_ASSIGN_OR_RETURN(waypoint.position_in_map.x,
                      node.Number("x", -kFarthest_m, kFarthest_m));
  TL_ASSIGN_OR_RETURN(waypoint.position_in_map.y,
                      node.Number("y", -kFarthest_m, kFarthest_m));
  if (node.Has("yaw")) {
    TL_ASSIGN_OR_RETURN(waypoint.yaw_rad,
                        node.Number("yaw", -kMostYaw_rad, kMostYaw_rad));
  }
  TL_ASSIGN_OR_RETURN(const int64_t level,
                      node.IntegerOr("level", 0, 0, kMostLevels));
  waypoint.level = static_cast<int>(level);
  TL_ASSIGN_OR_RETURN(waypoint.wait_s,
                      node.NumberOr("wait", 0, 0, routes::kMaxWait_s));
  TL_ASSIGN_OR_RETURN(waypoint.name, node.TextOr("name", ""));
  return waypoint;
}

absl::StatusOr<routes::Route> ReadRoute(const yaml::YamlNode& node) {
  TL_RETURN_IF_ERROR(
      node.CheckKeys({"name", "loop", "when_missed", "waypoints"}));
  routes::Route route;
  TL_ASSIGN_OR_RETURN(route.name, node.Text("name"));
  TL_ASSIGN_OR_RETURN(route.is_loop, node.BooleanOr("loop", false));
  if (node.Has("when_missed")) {
    TL_ASSIGN_OR_RETURN(const int choice,
                        node.Choice("when_missed", {"go-on", "stop"}));
    if (choice == 1) route.when_missed = routes::MissedPolicy::kStop;
  }
  TL_ASSIGN_OR_RETURN(const std::vector<yaml::YamlNode> waypoints,
                      node.Items("waypoints"));
  if (waypoints.empty()) return node.Error("a route needs waypoints");
  for (const yaml::YamlNode& item : waypoints) {
    TL_ASSIGN_OR_RETURN(routes::Waypoint waypoint, ReadWaypoint(item));
    route.waypoints.push_back(std::move(waypoint));
  }
  return route;
}

std::string WaypointLine(const routes::Waypoint& waypoint) {
  std::string line =
      absl::StrFormat("      - {x: %.10g, y: %.10g", waypoint.position_in_map.x,
                      waypoint.position_in_map.y);
  if (waypoint.yaw_rad.has_value()) {
    absl::StrAppendFormat(&line, ", yaw: %.10g", *waypoint.yaw_rad);
  }
  if (waypoint.level != 0) absl::StrAppend(&line, ", level: ", waypoint.level);
  if (waypoint.wait_s != 0) {
    absl::StrAppendFormat(&line, ", wait: %.10g", waypoint.wait_s);
  }
  if (!waypoint.name.empty()) {
    absl::StrAppend(&line, ", name: ", base::JsonQuoted(waypoint.name));
  }
  return absl::StrCat(line, "}\n");
}

}  // namespace

absl::StatusOr<std::vector<routes::Route>> ParseRoutes(absl::string_view text,
                                                       absl::string_view name) {
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode root,
                      yaml::YamlNode::Parse(text, name));
  TL_RETURN_IF_ERROR(root.CheckKeys({"routes"}));
  TL_ASSIGN_OR_RETURN(const std::vector<yaml::YamlNode> items,
                      root.Items("routes"));
  std::vector<routes::Route> routes;
  for (const yaml::YamlNode& item : items) {
    TL_ASSIGN_OR_RETURN(routes::Route route, ReadRoute(item));
    routes.push_back(std::move(route));
  }
  if (routes.empty()) return root.Error("there are no routes in it");
  return routes;
}

std::string RoutesText(const std::vector<routes::Route>& routes) {
  if (routes.empty()) return "routes: []\n";
  std::string text = "routes:\n";
  for (const routes::Route& route : routes) {
    absl::StrAppend(&text, "  - name: ", base::JsonQuoted(route.name), "\n");
    if (route.is_loop) absl::StrAppend(&text, "    loop: true\n");
    if (route.when_missed == routes::MissedPolicy::kStop) {
      absl::StrAppend(&text, "    when_missed: stop\n");
    }
    absl::StrAppend(&text, "    waypoints:\n");
    for (const routes::Waypoint& waypoint : route.waypoints) {
      absl::StrAppend(&text, WaypointLine(waypoint));
    }
  }
  return text;
}

}  // namespace treeline::route_app
