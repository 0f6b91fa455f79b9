// Files of routes that people write.
#ifndef NAV_AGENT_APP_ROUTE_ROUTE_YAML_H_
#define NAV_AGENT_APP_ROUTE_ROUTE_YAML_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "nav_agent/routes/route.h"

namespace treeline::route_app {

// As docs/reference/routes.md has it. INVALID_ARGUMENT: "FILE:LINE: ..."; what
// a route means on a map the agent says. Safe on any bytes.
absl::StatusOr<std::vector<routes::Route>> ParseRoutes(absl::string_view text,
                                                       absl::string_view name);

// What ParseRoutes reads.
std::string RoutesText(const std::vector<routes::Route>& routes);

}  // namespace treeline::route_app

#endif  // NAV_AGENT_APP_ROUTE_ROUTE_YAML_H_
