#include "nav_agent/routes/route_runner.h"

#include <cmath>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/status_macros.h"

namespace treeline::routes {
namespace {

// A robot that stands farther from where it came to stand is somewhere else: an
// estimate of its place does not jump so far (m).
constexpr double kElsewhere_m = 0.5;
// Between looks at where a robot that waits stands (s).
constexpr double kLookEvery_s = 1;
// Nearer waypoints say no direction (m).
constexpr double kSamePlace_m = 0.05;

bool IsGoalOver(behavior::GoalState state) {
  return state == behavior::GoalState::kSucceeded ||
         state == behavior::GoalState::kFailed ||
         state == behavior::GoalState::kCancelled;
}

std::string NameText(const Route& route) {
  return route.name.empty() ? std::string("the route")
                            : absl::StrCat("route '", route.name, "'");
}

std::optional<double> DirectionOf(geometry::Vec2 way) {
  if (geometry::Norm(way) < kSamePlace_m) return std::nullopt;
  return std::atan2(way.y, way.x);
}

std::string MissedText(const RouteProgress& progress) {
  std::string text = absl::StrCat(progress.reached, " waypoints reached");
  if (progress.missed > 0) {
    absl::StrAppend(&text, ", ", progress.missed, " missed");
  }
  return text;
}

}  // namespace

const char* RouteStateName(RouteState state) {
  switch (state) {
    case RouteState::kDriving:
      return "driving";
    case RouteState::kWaiting:
      return "waiting";
    case RouteState::kHeld:
      return "held";
    case RouteState::kOffered:
      return "offered";
    case RouteState::kSucceeded:
      return "succeeded";
    case RouteState::kFailed:
      return "failed";
    case RouteState::kCancelled:
      return "cancelled";
  }
  return "unknown";
}

bool IsOver(RouteState state) {
  return state == RouteState::kSucceeded || state == RouteState::kFailed ||
         state == RouteState::kCancelled;
}

bool RouteRunner::IsUnderWay() const {
  return status_.has_value() && (status_->state == RouteState::kDriving ||
                                 status_->state == RouteState::kWaiting);
}

bool RouteRunner::IsHeld() const {
  return status_.has_value() && status_->state == RouteState::kHeld;
}

bool RouteRunner::IsOpen() const {
  return status_.has_value() && !IsOver(status_->state);
}

std::string RouteRunner::Here() const {
  return WaypointText(route(), status_->progress.waypoint);
}

// ---- what it is told ----

void RouteRunner::Begin(RouteProgress progress) {
  status_ = RouteStatus{.id = ++last_id_, .progress = std::move(progress)};
  missed_in_row_ = 0;
  target_.reset();
  stood_at_.reset();
  ++changes_;
}

absl::StatusOr<uint64_t> RouteRunner::Start(behavior::Navigator& navigator,
                                            Route route, size_t first) {
  if (first >= route.waypoints.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat("begins with waypoint ", first, " of ",
                     route.waypoints.size(), " (from 0)"));
  }
  if (const auto stop = navigator.Snapshot().stop) {
    return absl::FailedPreconditionError(
        absl::StrCat("the route is refused: the robot is stopped (", stop->why,
                     "); release it first"));
  }
  if (IsOpen()) End(RouteState::kCancelled, "another route took its place");
  events_.Add("route",
              absl::StrCat(NameText(route), " begins: ", route.waypoints.size(),
                           " waypoints", route.is_loop ? ", in a loop" : ""));
  Begin({.route = std::make_shared<const Route>(std::move(route)),
         .waypoint = first});
  TL_RETURN_IF_ERROR(Go(navigator));
  return status_->id;
}

void RouteRunner::Offer(RouteProgress progress, base::MonotonicTime now) {
  events_.SetTime(now);
  Begin(std::move(progress));
  status_->state = RouteState::kOffered;
  status_->why = "it was under way when the agent ended";
  events_.Add("route", absl::StrCat(NameText(route()), " was under way to ",
                                    Here(), ", and waits to be resumed"));
}

absl::Status RouteRunner::Resume(behavior::Navigator& navigator) {
  if (!IsOpen()) {
    return absl::NotFoundError("there is no route to go on with");
  }
  if (const auto stop = navigator.Snapshot().stop) {
    return absl::FailedPreconditionError(
        absl::StrCat("the route waits: the robot is stopped (", stop->why,
                     "); release it first"));
  }
  navigator.Resume();
  if (IsUnderWay()) return absl::OkStatus();
  events_.Add("route", absl::StrCat(NameText(route()), " goes on to ", Here()));
  return Go(navigator);
}

absl::Status RouteRunner::Cancel(behavior::Navigator& navigator) {
  if (!IsOpen()) return absl::NotFoundError("there is no route to cancel");
  // Of another goal's sender the goal stays.
  if (status_->state == RouteState::kDriving) {
    (void)navigator.CancelGoal(status_->goal_id);
  }
  End(RouteState::kCancelled, "somebody cancelled it");
  return absl::OkStatus();
}

// ---- from waypoint to waypoint ----

core::LevelPose RouteRunner::PoseOf(const behavior::Navigator& navigator,
                                    size_t index) const {
  const std::vector<Waypoint>& all = route().waypoints;
  const Waypoint& to = all[index];
  core::LevelPose pose{
      .map_from_base = {.translation = to.position_in_map, .yaw_rad = 0},
      .place = {.level = to.level, .height_m = 0}};
  if (to.yaw_rad.has_value()) {
    pose.map_from_base.yaw_rad = *to.yaw_rad;
    return pose;
  }
  // Where the way leads on; at its end, from where it came.
  std::optional<double> yaw_rad;
  if (index + 1 < all.size() || route().is_loop) {
    yaw_rad = DirectionOf(all[(index + 1) % all.size()].position_in_map -
                          to.position_in_map);
  }
  const std::optional<localization::TrackedPose> robot =
      navigator.Snapshot().pose;
  if (!yaw_rad.has_value() && robot.has_value()) {
    const geometry::Rigid2& at = robot->pose.map_from_base;
    yaw_rad =
        DirectionOf(to.position_in_map - at.translation).value_or(at.yaw_rad);
  }
  pose.map_from_base.yaw_rad = yaw_rad.value_or(0);
  return pose;
}

absl::Status RouteRunner::Go(behavior::Navigator& navigator) {
  for (;;) {
    const core::LevelPose pose = PoseOf(navigator, status_->progress.waypoint);
    const absl::StatusOr<uint64_t> goal = navigator.SetGoal({.poses = {pose}});
    if (goal.ok()) {
      status_->goal_id = *goal;
      status_->state = RouteState::kDriving;
      status_->why.clear();
      target_ = pose;
      return absl::OkStatus();
    }
    if (navigator.Snapshot().stop.has_value()) return goal.status();
    // It lies in a zone that the robot is kept out of, or on no map.
    const core::NavigationCause cause =
        absl::IsFailedPrecondition(goal.status())
            ? core::NavigationCause::kZone
            : core::NavigationCause::kGoalOutside;
    if (!Miss(cause, std::string(goal.status().message())) || !Next()) {
      return absl::OkStatus();
    }
  }
}

void RouteRunner::GoOrHold(behavior::Navigator& navigator) {
  const absl::Status sent = Go(navigator);
  if (!sent.ok()) Hold(std::string(sent.message()));
}

bool RouteRunner::Next() {
  RouteProgress& progress = status_->progress;
  status_->waited_s = 0;
  stood_at_.reset();
  ++changes_;
  if (progress.waypoint + 1 < route().waypoints.size()) {
    ++progress.waypoint;
    return true;
  }
  if (!route().is_loop) {
    if (progress.reached == 0) {
      End(RouteState::kFailed, "no waypoint could be reached");
    } else {
      End(RouteState::kSucceeded, MissedText(progress));
    }
    return false;
  }
  progress.waypoint = 0;
  ++progress.lap;
  return true;
}

bool RouteRunner::Miss(core::NavigationCause cause, const std::string& why) {
  RouteProgress& progress = status_->progress;
  ++progress.missed;
  progress.last_missed.push_back({.waypoint = progress.waypoint,
                                  .lap = progress.lap,
                                  .cause = cause,
                                  .why = why});
  if (progress.last_missed.size() > kListedMissed) {
    progress.last_missed.erase(progress.last_missed.begin());
  }
  const std::string text = absl::StrCat(
      Here(), " is missed (", core::NavigationCauseName(cause), "): ", why);
  events_.Add("route", text);
  if (route().when_missed == MissedPolicy::kStop) {
    End(RouteState::kFailed, text);
    return false;
  }
  if (++missed_in_row_ >= route().waypoints.size() && route().is_loop) {
    End(RouteState::kFailed, "no waypoint can be reached any more");
    return false;
  }
  return true;
}

void RouteRunner::Hold(const std::string& why) {
  status_->state = RouteState::kHeld;
  status_->why = why;
  target_.reset();
  events_.Add("route", absl::StrCat(NameText(route()), " is held at ", Here(),
                                    ": ", why));
}

void RouteRunner::End(RouteState state, const std::string& why) {
  status_->state = state;
  status_->why = why;
  target_.reset();
  ++changes_;
  const char* what = state == RouteState::kSucceeded   ? " is over: "
                     : state == RouteState::kCancelled ? " is given up: "
                                                       : " failed: ";
  events_.Add("route", absl::StrCat(NameText(route()), what, why));
}

void RouteRunner::Reach(behavior::Navigator& navigator,
                        base::MonotonicTime now) {
  const double left_s = waypoint().wait_s - status_->waited_s;
  // One that is come back to is counted already.
  if (!stood_at_.has_value()) {
    ++status_->progress.reached;
    missed_in_row_ = 0;
    events_.Add("route", left_s > 0
                             ? absl::StrFormat("%s reached; waits for %.0f s",
                                               Here(), left_s)
                             : absl::StrCat(Here(), " reached"));
  }
  if (left_s <= 0) {
    if (Next()) GoOrHold(navigator);
    return;
  }
  const auto robot = navigator.Snapshot().pose;
  stood_at_ = robot.has_value() ? robot->pose.map_from_base.translation
                                : waypoint().position_in_map;
  status_->state = RouteState::kWaiting;
  waited_until_.reset();
  looked_ = now;
}

// ---- one step ----

void RouteRunner::Step(behavior::Navigator& navigator,
                       base::MonotonicTime now) {
  events_.SetTime(now);
  if (is_halted_ || !IsUnderWay()) return;
  const std::optional<behavior::GoalStatus> goal = navigator.goal();
  if (!goal.has_value() || goal->id != status_->goal_id) {
    Hold("another goal took its place");
  } else if (status_->state == RouteState::kWaiting) {
    StepWaiting(navigator, now);
  } else if (goal->state == behavior::GoalState::kSucceeded) {
    Reach(navigator, now);
  } else if (IsGoalOver(goal->state)) {
    StepDriving(navigator);
  }
}

void RouteRunner::StepDriving(behavior::Navigator& navigator) {
  const behavior::GoalStatus goal = *navigator.goal();
  if (goal.cause == core::NavigationCause::kStopped) {
    Hold(goal.why);
  } else if (goal.state == behavior::GoalState::kCancelled) {
    End(RouteState::kCancelled, goal.why);
  } else if (Miss(goal.cause, goal.why) && Next()) {
    GoOrHold(navigator);
  }
}

void RouteRunner::StepWaiting(behavior::Navigator& navigator,
                              base::MonotonicTime now) {
  const behavior::NavigatorMode mode = navigator.mode();
  if (mode == behavior::NavigatorMode::kStopped) {
    Hold("the robot was stopped");
    return;
  }
  // As with a goal: who drove it by hand says when it goes on.
  if (mode == behavior::NavigatorMode::kManual) navigator.Pause();
  if (mode != behavior::NavigatorMode::kIdle) {
    waited_until_.reset();
    return;
  }
  if (waited_until_.has_value()) {
    status_->waited_s += base::SecondsBetween(*waited_until_, now);
  } else {
    // Whatever it did in between, it may be elsewhere.
    looked_.reset();
  }
  waited_until_ = now;
  const bool is_over = status_->waited_s >= waypoint().wait_s;
  if (is_over || !looked_.has_value() ||
      base::SecondsBetween(*looked_, now) >= kLookEvery_s) {
    looked_ = now;
    const auto robot = navigator.Snapshot().pose;
    if (robot.has_value() &&
        geometry::Norm(robot->pose.map_from_base.translation - *stood_at_) >
            kElsewhere_m) {
      events_.Add("route", absl::StrCat("it is elsewhere: drives to ", Here(),
                                        " again"));
      GoOrHold(navigator);
      return;
    }
  }
  if (is_over && Next()) GoOrHold(navigator);
}

}  // namespace treeline::routes
