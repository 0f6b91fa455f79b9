// The docks that are kept by name, over a restart, too.
#ifndef NAV_AGENT_SERVICE_DOCK_BOOK_H_
#define NAV_AGENT_SERVICE_DOCK_BOOK_H_

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "nav_agent/behavior/navigator.h"
#include "nav_agent/docking/dock.h"
#include "nav_agent/service/kept_by_name.h"

namespace treeline::agent_service {

// As DockingService's PutDocks and RemoveDocks have it.
class DockBook final : public KeptByName<docking::Dock> {
 public:
  // folder: as KeptByName's, unread.
  explicit DockBook(std::shared_ptr<const behavior::NavigatorMap> map,
                    const std::string& folder = "");

  // With the file `docks` read, as KeptByName's Load.
  static absl::StatusOr<std::unique_ptr<DockBook>> Open(
      std::shared_ptr<const behavior::NavigatorMap> map,
      const std::string& folder);
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_DOCK_BOOK_H_
