// How far a robot is on its route.
#ifndef NAV_AGENT_ROUTES_ROUTE_PROGRESS_H_
#define NAV_AGENT_ROUTES_ROUTE_PROGRESS_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "nav_agent/core/navigation_cause.h"
#include "nav_agent/routes/route.h"

namespace treeline::routes {

// A waypoint that could not be reached.
struct MissedWaypoint {
  size_t waypoint = 0;
  // From 0.
  int64_t lap = 0;
  core::NavigationCause cause = core::NavigationCause::kNone;
  // What was where, for people.
  std::string why;

  bool operator==(const MissedWaypoint&) const = default;
};

// Of those that were missed so many are listed, the newest.
inline constexpr size_t kListedMissed = 100;

// What a restart must know to go on.
struct RouteProgress {
  // Never null.
  std::shared_ptr<const Route> route = nullptr;
  // It drives to this one, or waits there; the last one at its end.
  size_t waypoint = 0;
  // Times that it began with the first one again.
  int64_t lap = 0;
  int64_t reached = 0;
  int64_t missed = 0;
  std::vector<MissedWaypoint> last_missed = {};
};

enum class RouteState : uint8_t {
  kDriving = 0,
  kWaiting = 1,  // at a waypoint, for as long as that says
  // The robot was stopped, or another goal took its place: it goes on when
  // somebody says so.
  kHeld = 2,
  // It was under way when the agent ended.
  kOffered = 3,
  kSucceeded = 4,  // at its end; some waypoints may have been missed
  kFailed = 5,
  kCancelled = 6
};
// "driving" and so on.
const char* RouteStateName(RouteState state);
// It ended.
bool IsOver(RouteState state);

struct RouteStatus {
  // Counts routes since the agent's start, from 1.
  uint64_t id = 0;
  RouteState state = RouteState::kDriving;
  // Of a route that is held, offered or over: why, for people.
  std::string why = {};
  RouteProgress progress = {};
  // The navigator's goal of this waypoint; 0: none yet.
  uint64_t goal_id = 0;
  // At the waypoint so far (s).
  double waited_s = 0;
};

}  // namespace treeline::routes

#endif  // NAV_AGENT_ROUTES_ROUTE_PROGRESS_H_
