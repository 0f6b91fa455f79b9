// Routes, and how far the robot is on one, as bytes that outlive the program.
#ifndef NAV_AGENT_ROUTES_ROUTE_FILE_H_
#define NAV_AGENT_ROUTES_ROUTE_FILE_H_

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "nav_agent/routes/route_progress.h"

namespace treeline::routes {

// Lines as base::CheckedLinesText has them: a line for each route, followed by
// one for each of its waypoints. YAW_RAD is "-" where there is none.
//
//   treeline-routes 1
//   route WAYPOINTS once|loop go-on|stop NAME
//   waypoint LEVEL X_M Y_M YAW_RAD WAIT_S NAME
std::string RouteFileText(std::span<const Route> routes);
// Routes as they were written, bit for bit. INVALID_ARGUMENT says which line is
// wrong, or that the file was cut off or changed. Safe on any bytes.
absl::StatusOr<std::vector<Route>> ParseRouteFile(absl::string_view text);

// The same of a route that is under way, with two kinds of lines before it; no
// lines: there is none.
//
//   treeline-route-progress 1
//   progress WAYPOINT LAP REACHED MISSED
//   missed WAYPOINT LAP CAUSE WHY
std::string ProgressFileText(const std::optional<RouteProgress>& progress);
absl::StatusOr<std::optional<RouteProgress>> ParseProgressFile(
    absl::string_view text);

}  // namespace treeline::routes

#endif  // NAV_AGENT_ROUTES_ROUTE_FILE_H_
