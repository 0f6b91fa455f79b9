// Drives a navigator from waypoint to waypoint.
#ifndef NAV_AGENT_ROUTES_ROUTE_RUNNER_H_
#define NAV_AGENT_ROUTES_ROUTE_RUNNER_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "nav_agent/behavior/event_log.h"
#include "nav_agent/behavior/navigator.h"
#include "nav_agent/routes/route_progress.h"

namespace treeline::routes {

// Above the navigator: each waypoint is a goal of its own, so that safe stops,
// recoveries, a kidnap and zones are the navigator's business. A robot that
// somebody stops, or sends elsewhere, holds its route until Resume; one that is
// driven by hand while it waits at a waypoint is paused. A waypoint at which
// the robot is not any more, however it came away, is driven to again. Not
// thread-safe: everything is called by the thread that steps the navigator.
class RouteRunner {
 public:
  // Drives to a waypoint of the route, which must have passed CheckRoute, and
  // from there on. One that was under way, held or offered ends as cancelled.
  // FAILED_PRECONDITION: the robot is stopped. INVALID_ARGUMENT: there is no
  // waypoint `first`.
  absl::StatusOr<uint64_t> Start(behavior::Navigator& navigator, Route route,
                                 size_t first);
  // A route that was under way before the program began: it waits for Resume.
  void Offer(RouteProgress progress, base::MonotonicTime now);
  // Goes on to the waypoint that it was at, and ends a pause. OK also where it
  // drives already. NOT_FOUND: there is none to go on with.
  // FAILED_PRECONDITION: the robot is stopped.
  absl::Status Resume(behavior::Navigator& navigator);
  // One that is under way waits for Resume, and its goal may be replaced: for
  // who has something more urgent for the robot to do.
  void Hold(const std::string& why);
  // NOT_FOUND: there is none.
  absl::Status Cancel(behavior::Navigator& navigator);
  // Nothing happens any more, and the route stays what it is: for the end of
  // the program, before the navigator halts.
  void Halt() { is_halted_ = true; }

  // After each step of the navigator.
  void Step(behavior::Navigator& navigator, base::MonotonicTime now);

  // The last one; nullopt: there never was any.
  const std::optional<RouteStatus>& status() const { return status_; }
  // It drives or waits at a waypoint.
  bool IsUnderWay() const;
  bool IsHeld() const;
  // Under way, held or offered.
  bool IsOpen() const;
  // Where the goal of this waypoint leads; nullopt: there is none.
  const std::optional<core::LevelPose>& target() const { return target_; }
  // Counts what a restart must know: changes with each waypoint.
  uint64_t changes() const { return changes_; }
  // "route", since the last call.
  std::vector<behavior::NavigatorEvent> TakeEvents() { return events_.Take(); }

 private:
  void Begin(RouteProgress progress);
  // Sends the goal of the current waypoint, or of the next that is taken.
  // FAILED_PRECONDITION: the robot is stopped; the route is as it was.
  absl::Status Go(behavior::Navigator& navigator);
  void StepDriving(behavior::Navigator& navigator);
  void StepWaiting(behavior::Navigator& navigator, base::MonotonicTime now);
  void Reach(behavior::Navigator& navigator, base::MonotonicTime now);
  // False: that ended the route.
  bool Miss(core::NavigationCause cause, const std::string& why);
  bool Next();
  void GoOrHold(behavior::Navigator& navigator);
  void End(RouteState state, const std::string& why);
  core::LevelPose PoseOf(const behavior::Navigator& navigator,
                         size_t waypoint) const;
  const Route& route() const { return *status_->progress.route; }
  const Waypoint& waypoint() const {
    return route().waypoints[status_->progress.waypoint];
  }
  std::string Here() const;

  behavior::EventLog events_;
  std::optional<RouteStatus> status_;
  std::optional<core::LevelPose> target_;
  uint64_t last_id_ = 0;
  uint64_t changes_ = 0;
  bool is_halted_ = false;
  // Waypoints that were missed since one was reached.
  size_t missed_in_row_ = 0;
  // ---- at a waypoint ----
  std::optional<geometry::Vec2> stood_at_;
  std::optional<base::MonotonicTime> waited_until_;
  // nullopt: to look at once.
  std::optional<base::MonotonicTime> looked_;
};

}  // namespace treeline::routes

#endif  // NAV_AGENT_ROUTES_ROUTE_RUNNER_H_
