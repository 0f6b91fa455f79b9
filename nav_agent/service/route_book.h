// The routes that are kept by name, over a restart, too.
#ifndef NAV_AGENT_SERVICE_ROUTE_BOOK_H_
#define NAV_AGENT_SERVICE_ROUTE_BOOK_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "nav_agent/routes/route.h"

namespace treeline::agent_service {

struct RouteBookContents {
  // Counts changes, from 1.
  uint64_t revision = 1;
  std::vector<routes::Route> routes;
};

// Thread-safe. Routes never get lost in silence: what cannot be read is an
// error of Open, and what cannot be kept is not put.
class RouteBook {
 public:
  // Of a map with so many levels. Nothing is kept for a restart.
  explicit RouteBook(int levels) : levels_(levels) {}

  // Makes the folder, and reads the file `routes` in it; an empty folder's
  // name: as above. DATA_LOSS: the file is not one of routes, or damaged.
  // INVALID_ARGUMENT: routes that mean nothing on this map. Others: it cannot
  // be read. Each says what to do.
  static absl::StatusOr<std::unique_ptr<RouteBook>> Open(
      int levels, const std::string& folder);

  // As NavigationService's PutRoutes and RemoveRoutes have it.
  absl::StatusOr<RouteBookContents> Put(
      const std::vector<routes::Route>& routes);
  absl::StatusOr<RouteBookContents> Remove(
      const std::vector<std::string>& names);

  // NOT_FOUND names those there are.
  absl::StatusOr<routes::Route> Find(const std::string& name) const;
  RouteBookContents contents() const;
  uint64_t revision() const;
  int levels() const { return levels_; }
  // OK: a restart finds what is kept; else why not.
  absl::Status keeping() const;

 private:
  using Edit = std::function<absl::Status(std::vector<routes::Route>& routes)>;

  absl::StatusOr<RouteBookContents> Change(const Edit& edit);
  absl::Status Load();
  std::string path() const { return folder_ + "/routes"; }

  const int levels_;
  std::string folder_;
  // One change at a time, from its beginning to its end.
  absl::Mutex changing_;
  mutable absl::Mutex mutex_;
  RouteBookContents contents_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_ROUTE_BOOK_H_
