#include "nav_agent/app/route/route_yaml.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/json_text.h"
#include "common/base/status_macros.h"
#include "common/yaml/yaml_node.h"
#include "nav_agent/routes/route.h"

namespace treeline::route_app {
namespace {

constexpr double kFarthest_m = 1e5;
constexpr double kMostYaw_rad = 1e3;
constexpr int kMostLevels = 1000;

absl::StatusOr<v1::Waypoint> ReadWaypoint(const yaml::YamlNode& node) {
  TL_RETURN_IF_ERROR(
      node.CheckKeys({"x", "y", "yaw", "level", "wait", "name"}));
  v1::Waypoint waypoint;
  TL_ASSIGN_OR_RETURN(const double x_m,
                      node.Number("x", -kFarthest_m, kFarthest_m));
  TL_ASSIGN_OR_RETURN(const double y_m,
                      node.Number("y", -kFarthest_m, kFarthest_m));
  waypoint.set_x_m(x_m);
  waypoint.set_y_m(y_m);
  if (node.Has("yaw")) {
    TL_ASSIGN_OR_RETURN(const double yaw_rad,
                        node.Number("yaw", -kMostYaw_rad, kMostYaw_rad));
    waypoint.set_yaw_rad(yaw_rad);
  }
  TL_ASSIGN_OR_RETURN(const int64_t level,
                      node.IntegerOr("level", 0, 0, kMostLevels));
  waypoint.set_level(static_cast<int32_t>(level));
  TL_ASSIGN_OR_RETURN(const double wait_s,
                      node.NumberOr("wait", 0, 0, routes::kMaxWait_s));
  waypoint.set_wait_s(wait_s);
  TL_ASSIGN_OR_RETURN(std::string name, node.TextOr("name", ""));
  waypoint.set_name(std::move(name));
  return waypoint;
}

absl::StatusOr<v1::Route> ReadRoute(const yaml::YamlNode& node) {
  TL_RETURN_IF_ERROR(
      node.CheckKeys({"name", "loop", "when_missed", "waypoints"}));
  v1::Route route;
  TL_ASSIGN_OR_RETURN(std::string name, node.Text("name"));
  route.set_name(std::move(name));
  TL_ASSIGN_OR_RETURN(const bool is_loop, node.BooleanOr("loop", false));
  route.set_loop(is_loop);
  route.set_when_missed(v1::MISSED_POLICY_GO_ON);
  if (node.Has("when_missed")) {
    TL_ASSIGN_OR_RETURN(const int choice,
                        node.Choice("when_missed", {"go-on", "stop"}));
    if (choice == 1) route.set_when_missed(v1::MISSED_POLICY_STOP);
  }
  TL_ASSIGN_OR_RETURN(const std::vector<yaml::YamlNode> waypoints,
                      node.Items("waypoints"));
  if (waypoints.empty()) return node.Error("a route needs waypoints");
  for (const yaml::YamlNode& item : waypoints) {
    TL_ASSIGN_OR_RETURN(*route.add_waypoints(), ReadWaypoint(item));
  }
  return route;
}

std::string WaypointLine(const v1::Waypoint& waypoint) {
  std::string line = absl::StrFormat("      - {x: %.10g, y: %.10g",
                                     waypoint.x_m(), waypoint.y_m());
  if (waypoint.has_yaw_rad()) {
    absl::StrAppendFormat(&line, ", yaw: %.10g", waypoint.yaw_rad());
  }
  if (waypoint.level() != 0) {
    absl::StrAppend(&line, ", level: ", waypoint.level());
  }
  if (waypoint.wait_s() != 0) {
    absl::StrAppendFormat(&line, ", wait: %.10g", waypoint.wait_s());
  }
  if (!waypoint.name().empty()) {
    absl::StrAppend(&line, ", name: ", base::JsonQuoted(waypoint.name()));
  }
  return absl::StrCat(line, "}\n");
}

}  // namespace

absl::StatusOr<std::vector<v1::Route>> ParseRoutes(absl::string_view text,
                                                   absl::string_view name) {
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode root,
                      yaml::YamlNode::Parse(text, name));
  TL_RETURN_IF_ERROR(root.CheckKeys({"routes"}));
  TL_ASSIGN_OR_RETURN(const std::vector<yaml::YamlNode> items,
                      root.Items("routes"));
  std::vector<v1::Route> routes;
  for (const yaml::YamlNode& item : items) {
    TL_ASSIGN_OR_RETURN(v1::Route route, ReadRoute(item));
    routes.push_back(std::move(route));
  }
  if (routes.empty()) return root.Error("there are no routes in it");
  return routes;
}

std::string RoutesText(const std::vector<v1::Route>& routes) {
  if (routes.empty()) return "routes: []\n";
  std::string text = "routes:\n";
  for (const v1::Route& route : routes) {
    absl::StrAppend(&text, "  - name: ", base::JsonQuoted(route.name()), "\n");
    if (route.loop()) absl::StrAppend(&text, "    loop: true\n");
    if (route.when_missed() == v1::MISSED_POLICY_STOP) {
      absl::StrAppend(&text, "    when_missed: stop\n");
    }
    absl::StrAppend(&text, "    waypoints:\n");
    for (const v1::Waypoint& waypoint : route.waypoints()) {
      absl::StrAppend(&text, WaypointLine(waypoint));
    }
  }
  return text;
}

}  // namespace treeline::route_app
