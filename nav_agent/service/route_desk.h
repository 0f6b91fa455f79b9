// Routes of one agent: those that are kept, the one under way, and what a
// restart finds of that.
#ifndef NAV_AGENT_SERVICE_ROUTE_DESK_H_
#define NAV_AGENT_SERVICE_ROUTE_DESK_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "nav_agent/behavior/navigator.h"
#include "nav_agent/routes/route_runner.h"
#include "nav_agent/service/route_book.h"
#include "nav_agent/service/route_keeper.h"

namespace treeline::agent_service {

class RouteDesk {
 public:
  // Nothing is kept.
  explicit RouteDesk(int levels)
      : RouteDesk(std::make_unique<RouteBook>(levels), "") {}
  // As RouteBook's.
  static absl::StatusOr<std::unique_ptr<RouteDesk>> Open(
      int levels, const std::string& folder);

  // ---- any thread ----
  RouteBook& book() { return *book_; }
  const RouteBook& book() const { return *book_; }
  // Of the route under way: RouteKeeper's.
  absl::Status keeping() const { return keeper_.keeping(); }

  // ---- the thread that steps ----
  // Before the first step: what was under way when the agent ended. An error
  // says why that is not known; there is none to resume then.
  absl::Status Offer(base::MonotonicTime now);
  // After each step of the navigator.
  void Step(behavior::Navigator& navigator, base::MonotonicTime now);
  routes::RouteRunner& runner() { return runner_; }

 private:
  RouteDesk(std::unique_ptr<RouteBook> book, const std::string& folder)
      : book_(std::move(book)), keeper_(folder) {}
  void KeepProgress();

  std::unique_ptr<RouteBook> book_;
  RouteKeeper keeper_;
  routes::RouteRunner runner_;
  uint64_t kept_changes_ = 0;
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_ROUTE_DESK_H_
