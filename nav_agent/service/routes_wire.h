// Routes, proto <-> C++. Text that is not UTF-8 gets U+FFFD.
#ifndef NAV_AGENT_SERVICE_ROUTES_WIRE_H_
#define NAV_AGENT_SERVICE_ROUTES_WIRE_H_

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "nav_agent/routes/route_progress.h"
#include "treeline/v1/routes.pb.h"

namespace treeline::agent_service {

// INVALID_ARGUMENT: no policy that there is. What else it means, CheckRoute
// says.
absl::StatusOr<routes::Route> FromProto(const v1::Route& proto);

v1::Route ToProto(const routes::Route& route);
// keeping: RouteDesk's.
v1::RouteStatus ToProto(const routes::RouteStatus& status,
                        const absl::Status& keeping);

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_ROUTES_WIRE_H_
