// The routes that are kept by name, over a restart, too.
#ifndef NAV_AGENT_SERVICE_ROUTE_BOOK_H_
#define NAV_AGENT_SERVICE_ROUTE_BOOK_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "nav_agent/routes/route.h"
#include "nav_agent/service/kept_by_name.h"

namespace treeline::agent_service {

// As NavigationService's PutRoutes and RemoveRoutes have it.
class RouteBook final : public KeptByName<routes::Route> {
 public:
  // Of a map with so many levels. folder: as KeptByName's, unread.
  explicit RouteBook(int levels, const std::string& folder = "");

  // With the file `routes` read, as KeptByName's Load.
  static absl::StatusOr<std::unique_ptr<RouteBook>> Open(
      int levels, const std::string& folder);

  int levels() const { return levels_; }

 private:
  const int levels_;
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_ROUTE_BOOK_H_
