#include "nav_agent/service/agent_commands.h"

#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/geometry/planar_pose.h"
#include "nav_agent/behavior/parameters.h"

namespace treeline::agent_service {
namespace {

// No building is larger (m).
constexpr double kFarthest_m = 1e5;
// How far from a pose its ground is looked for (m).
constexpr double kNearGround_m = 1.0;

// The ground's height nearest to a point; nullopt: none is near.
std::optional<double> HeightNear(const traversability::TraversableLevel& level,
                                 geometry::Vec2 point_in_map) {
  const core::OccupancyGrid& grid = level.grid;
  const core::CellIndex middle = grid.CellOf(point_in_map);
  const int reach =
      static_cast<int>(std::ceil(kNearGround_m / grid.resolution_m));
  std::optional<double> height;
  int64_t nearest = std::numeric_limits<int64_t>::max();
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const core::CellIndex cell{middle.x + dx, middle.y + dy};
      const int64_t distance = int64_t{dx} * dx + int64_t{dy} * dy;
      if (distance >= nearest || !grid.Contains(cell)) continue;
      const float found = level.height_m[grid.IndexOf(cell)];
      if (std::isnan(found)) continue;
      nearest = distance;
      height = found;
    }
  }
  return height;
}

bool HasGoal(const behavior::Navigator& navigator) {
  const std::optional<behavior::GoalStatus> goal = navigator.goal();
  return goal.has_value() && (goal->state == behavior::GoalState::kAccepted ||
                              goal->state == behavior::GoalState::kActive);
}

double LowestOf(const traversability::TraversableLevel& level) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const float height : level.height_m) {
    if (height < lowest) lowest = height;
  }
  return std::isfinite(lowest) ? lowest : 0;
}

}  // namespace

absl::StatusOr<core::LevelPose> AgentCommands::OnLevel(
    const RequestedPose& pose, const std::string& what) const {
  if (!std::isfinite(pose.x_m) || !std::isfinite(pose.y_m) ||
      !std::isfinite(pose.yaw_rad)) {
    return absl::InvalidArgumentError(
        absl::StrCat(what, " has a NaN or an infinity"));
  }
  if (std::abs(pose.x_m) > kFarthest_m || std::abs(pose.y_m) > kFarthest_m) {
    return absl::InvalidArgumentError(absl::StrCat(
        what, " is ", pose.x_m, ", ", pose.y_m, " m: no map reaches that far"));
  }
  const auto& levels = info_.map->levels.levels;
  if (pose.level < 0 || static_cast<size_t>(pose.level) >= levels.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat(what, " is on level ", pose.level, "; the map has 0..",
                     levels.size() - 1));
  }
  const traversability::TraversableLevel& level =
      levels[static_cast<size_t>(pose.level)];
  const geometry::Vec2 position{pose.x_m, pose.y_m};
  const std::optional<double> height_m = HeightNear(level, position);
  return core::LevelPose{
      .map_from_base = {position, geometry::NormalizedAngle_rad(pose.yaw_rad)},
      .place = {pose.level,
                height_m.has_value() ? *height_m : LowestOf(level)}};
}

core::LevelPose AgentCommands::NearestLevel(
    const geometry::Rigid3& map_from_base) const {
  const geometry::Vec3& at = map_from_base.translation;
  core::LevelPose pose{.map_from_base = geometry::PlanarPose(map_from_base),
                       .place = {0, at.z}};
  const auto& levels = info_.map->levels.levels;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < levels.size(); ++i) {
    const auto height_m = HeightNear(levels[i], {at.x, at.y});
    if (!height_m.has_value()) continue;
    if (std::abs(*height_m - at.z) >= nearest_m) continue;
    nearest_m = std::abs(*height_m - at.z);
    pose.place = {static_cast<int>(i), *height_m};
  }
  return pose;
}

absl::StatusOr<uint64_t> AgentCommands::SetGoalNow(
    behavior::Navigator& navigator, const std::vector<RequestedPose>& poses) {
  if (poses.empty()) {
    return absl::InvalidArgumentError("a goal needs a pose at least");
  }
  if (poses.size() > kMaxGoalPoses) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the goal has ", poses.size(), " poses; at most ", kMaxGoalPoses));
  }
  behavior::NavigationGoal goal;
  for (size_t i = 0; i < poses.size(); ++i) {
    TL_ASSIGN_OR_RETURN(core::LevelPose pose,
                        OnLevel(poses[i], absl::StrCat("poses[", i, "]")));
    goal.poses.push_back(pose);
  }
  TL_ASSIGN_OR_RETURN(const uint64_t id, navigator.SetGoal(goal));
  const absl::MutexLock lock(&mutex_);
  goal_id_ = id;
  goal_poses_ = std::move(goal.poses);
  return id;
}

absl::StatusOr<uint64_t> AgentCommands::SetGoal(
    const std::vector<RequestedPose>& poses) {
  uint64_t id = 0;
  TL_RETURN_IF_ERROR(
      hub_.Do([&](behavior::Navigator& navigator) -> absl::Status {
        TL_ASSIGN_OR_RETURN(id, SetGoalNow(navigator, poses));
        return absl::OkStatus();
      }));
  return id;
}

std::vector<core::LevelPose> AgentCommands::PosesOf(uint64_t goal_id) const {
  const absl::MutexLock lock(&mutex_);
  if (goal_id != goal_id_) return {};
  return goal_poses_;
}

absl::Status AgentCommands::Cancel(uint64_t goal_id) {
  return hub_.Do([&](behavior::Navigator& navigator) {
    routes::RouteRunner& runner = routes_.runner();
    docking::DockPilot& pilot = docks_.pilot();
    if (pilot.IsUnderWay() && (goal_id == 0 || goal_id == pilot.goal_id())) {
      return pilot.Cancel(navigator);
    }
    if (runner.IsUnderWay() &&
        (goal_id == 0 || goal_id == runner.status()->goal_id)) {
      return runner.Cancel(navigator);
    }
    const absl::Status cancelled = navigator.CancelGoal(goal_id);
    if (goal_id == 0 && absl::IsNotFound(cancelled) &&
        pilot.Cancel(navigator).ok()) {
      return absl::OkStatus();
    }
    const bool may_be_route =
        goal_id == 0 && absl::IsNotFound(cancelled) && runner.IsOpen();
    return may_be_route ? runner.Cancel(navigator) : cancelled;
  });
}

absl::Status AgentCommands::Pause() {
  return hub_.Do([](behavior::Navigator& navigator) {
    navigator.Pause();
    return absl::OkStatus();
  });
}

absl::Status AgentCommands::Resume() {
  return hub_.Do([this](behavior::Navigator& navigator) -> absl::Status {
    navigator.Resume();
    docks_.keeper().Resume();
    if (!routes_.runner().IsHeld() || HasGoal(navigator) ||
        docks_.pilot().IsUnderWay()) {
      return absl::OkStatus();
    }
    return routes_.runner().Resume(navigator);
  });
}

absl::StatusOr<uint64_t> AgentCommands::RunRoute(routes::Route route,
                                                 size_t first_waypoint) {
  TL_RETURN_IF_ERROR(routes::CheckRoute(route, routes_.book().levels()));
  uint64_t id = 0;
  TL_RETURN_IF_ERROR(
      hub_.Do([&](behavior::Navigator& navigator) -> absl::Status {
        TL_ASSIGN_OR_RETURN(id,
                            routes_.runner().Start(navigator, std::move(route),
                                                   first_waypoint));
        return absl::OkStatus();
      }));
  return id;
}

absl::Status AgentCommands::ResumeRoute() {
  return hub_.Do([this](behavior::Navigator& navigator) {
    return routes_.runner().Resume(navigator);
  });
}

absl::Status AgentCommands::CancelRoute(uint64_t route_id) {
  return hub_.Do([&](behavior::Navigator& navigator) -> absl::Status {
    const std::optional<routes::RouteStatus>& status =
        routes_.runner().status();
    if (route_id != 0 && (!status.has_value() || status->id != route_id)) {
      return absl::NotFoundError(
          absl::StrCat("route ", route_id, " is not under way"));
    }
    return routes_.runner().Cancel(navigator);
  });
}

void AgentCommands::StepRoute(behavior::Navigator& navigator,
                              base::MonotonicTime now) {
  routes_.Step(navigator, now);
  const std::optional<core::LevelPose>& target = routes_.runner().target();
  if (!target.has_value()) return;
  NoteTarget(routes_.runner().status()->goal_id, *target);
}

void AgentCommands::StepDocks(behavior::Navigator& navigator,
                              base::MonotonicTime now,
                              const std::optional<core::Battery>& battery) {
  docks_.Step(navigator, routes_.runner(), now, battery);
  const docking::DockPilot& pilot = docks_.pilot();
  if (pilot.goal_id() != 0) NoteTarget(pilot.goal_id(), pilot.target());
}

void AgentCommands::NoteTarget(uint64_t goal_id,
                               const core::LevelPose& target) {
  const absl::MutexLock lock(&mutex_);
  if (goal_id_ == goal_id) return;
  goal_id_ = goal_id;
  goal_poses_ = {target};
}

absl::StatusOr<uint64_t> AgentCommands::DockNow(behavior::Navigator& navigator,
                                                const std::string& name) {
  docking::Dock dock;
  if (name.empty()) {
    const auto pose = navigator.Snapshot().pose;
    TL_ASSIGN_OR_RETURN(
        dock, docking::NearestOf(
                  docks_.book().contents().things,
                  pose.has_value() ? std::optional(pose->pose) : std::nullopt));
  } else {
    TL_ASSIGN_OR_RETURN(dock, docks_.book().Find(name));
  }
  docks_.FollowBook();
  TL_RETURN_IF_ERROR(docking::DockPilot::Check(navigator, dock));
  if (routes_.runner().IsUnderWay()) {
    routes_.runner().Hold("somebody sent the robot to a dock");
  }
  return docks_.pilot().Begin(navigator, dock);
}

absl::StatusOr<uint64_t> AgentCommands::Dock(const std::string& name) {
  uint64_t id = 0;
  TL_RETURN_IF_ERROR(
      hub_.Do([&](behavior::Navigator& navigator) -> absl::Status {
        TL_ASSIGN_OR_RETURN(id, DockNow(navigator, name));
        return absl::OkStatus();
      }));
  return id;
}

absl::Status AgentCommands::Undock() {
  return hub_.Do([this](behavior::Navigator& navigator) {
    docks_.FollowBook();
    return docks_.pilot().DriveOut(navigator);
  });
}

absl::Status AgentCommands::CancelDocking(uint64_t id) {
  return hub_.Do([this, id](behavior::Navigator& navigator) -> absl::Status {
    docking::DockPilot& pilot = docks_.pilot();
    if (id != 0 && pilot.status().id != id) {
      return absl::NotFoundError(
          absl::StrCat("docking ", id, " is not under way"));
    }
    return pilot.Cancel(navigator);
  });
}

absl::StatusOr<core::LevelPose> AgentCommands::WhereItStands() const {
  const std::shared_ptr<const AgentState> state = hub_.Latest();
  if (state == nullptr || !state->snapshot.pose.has_value()) {
    return absl::FailedPreconditionError("the robot does not know where it is");
  }
  const behavior::NavigatorMode mode = state->snapshot.mode;
  if (state->snapshot.pose->in_doubt ||
      mode == behavior::NavigatorMode::kLost ||
      mode == behavior::NavigatorMode::kRelocalizing ||
      mode == behavior::NavigatorMode::kNeedHelp) {
    return absl::FailedPreconditionError(
        "the robot is not sure where it is; tell it, or let it find itself");
  }
  return state->snapshot.pose->pose;
}

void AgentCommands::ShowRoute(AgentState& state) {
  state.route = routes_.runner().status();
  state.route_keeping = routes_.keeping();
  state.routes_revision = routes_.book().revision() +
                          (state.route.has_value() ? state.route->id : 0);
  state.docks = docks_.Report();
}

absl::StatusOr<StopKeeping> AgentCommands::Stop(const std::string& why) {
  if (why.size() > kMaxWhyBytes) {
    return absl::InvalidArgumentError(
        absl::StrCat("why has ", why.size(), " bytes; at most ", kMaxWhyBytes));
  }
  const std::string said = why.empty() ? "somebody stopped it" : why;
  ++stopped_;
  const absl::Status done = hub_.Do(
      [&](behavior::Navigator& navigator) {
        navigator.Stop(said);
        return absl::OkStatus();
      },
      /*is_urgent=*/true);
  // Kept even if no step took it: a restart finds it then.
  StopKeeping keeping = {.status = stops_.Hold(said)};
  TL_RETURN_IF_ERROR(done);
  return keeping;
}

absl::StatusOr<StopKeeping> AgentCommands::Release() {
  const int64_t stopped = stopped_;
  StopKeeping keeping = {.status = stops_.Release()};
  const absl::Status done =
      hub_.Do([&](behavior::Navigator& navigator) -> absl::Status {
        if (stopped_ != stopped) {
          return absl::FailedPreconditionError(
              "the robot was stopped again meanwhile");
        }
        navigator.Release();
        return absl::OkStatus();
      });
  if (done.ok()) return keeping;
  // It is stopped still, and so it is after a restart.
  (void)stops_.Hold("a release that no step took");
  return done;
}

void AgentCommands::StopAsKept(behavior::Navigator& navigator) {
  if (const std::optional<std::string> why = stops_.why()) navigator.Stop(*why);
}

absl::Status AgentCommands::Drive(const core::VelocityCommand& wanted,
                                  const std::string& driver,
                                  uint64_t sequence) {
  const base::MonotonicTime came = real_clock_.Now();
  TL_RETURN_IF_ERROR(seat_.Take(driver, sequence, came));
  return hub_.Do([&](behavior::Navigator& navigator) -> absl::Status {
    if (base::SecondsBetween(came, real_clock_.Now()) >
        behavior::kManualLease_s) {
      return absl::DeadlineExceededError(
          "the control loop took the command when it was stale");
    }
    return navigator.Drive(wanted);
  });
}

absl::Status AgentCommands::ApplyZones(
    const std::shared_ptr<const zones::ZoneMap>& zones) {
  return hub_.Do([zones](behavior::Navigator& navigator) {
    return navigator.SetZones(zones);
  });
}

absl::StatusOr<ZoneBookContents> AgentCommands::PutZones(
    const std::vector<zones::Zone>& zones) {
  return zones_.Put(zones, [this](const auto& map) { return ApplyZones(map); });
}

absl::StatusOr<ZoneBookContents> AgentCommands::RemoveZones(
    const std::vector<std::string>& names) {
  return zones_.Remove(names,
                       [this](const auto& map) { return ApplyZones(map); });
}

absl::Status AgentCommands::SetPoseNow(behavior::Navigator& navigator,
                                       const core::LevelPose& pose,
                                       double std_m, double std_rad) {
  constexpr double kMax = 100;
  if (!(std_m > 0) || !(std_rad > 0) || !(std_m <= kMax) ||
      !(std_rad <= kMax)) {
    return absl::InvalidArgumentError(
        absl::StrCat("standard deviations are ", std_m, " m and ", std_rad,
                     " rad; they must be above 0 and at most ", kMax));
  }
  localization::PoseCovariance2 covariance{};
  covariance[0] = std_m * std_m;
  covariance[4] = std_m * std_m;
  covariance[8] = std_rad * std_rad;
  return navigator.SetPose(pose, covariance);
}

absl::Status AgentCommands::SetPose(const RequestedPose& pose, double std_m,
                                    double std_rad) {
  TL_ASSIGN_OR_RETURN(const core::LevelPose on_level,
                      OnLevel(pose, "the pose"));
  return hub_.Do([&](behavior::Navigator& navigator) {
    return SetPoseNow(navigator, on_level, std_m, std_rad);
  });
}

absl::Status AgentCommands::FindYourself() {
  return hub_.Do([](behavior::Navigator& navigator) {
    navigator.FindYourself();
    return absl::OkStatus();
  });
}

absl::Status AgentCommands::CheckSimulated() const {
  if (simulation_ != nullptr) return absl::OkStatus();
  return absl::UnimplementedError(
      "this robot is real: only a simulated one (run --simulate WORLD) can be "
      "kidnapped, and its world changed");
}

absl::StatusOr<geometry::Rigid3> AgentCommands::DoKidnap(
    const std::function<absl::StatusOr<geometry::Rigid3>(SimulationControl&)>&
        kidnap) {
  TL_RETURN_IF_ERROR(CheckSimulated());
  geometry::Rigid3 map_from_base;
  TL_RETURN_IF_ERROR(
      hub_.Do([&](behavior::Navigator& /*navigator*/) -> absl::Status {
        TL_ASSIGN_OR_RETURN(map_from_base, kidnap(*simulation_));
        return absl::OkStatus();
      }));
  return map_from_base;
}

absl::StatusOr<geometry::Rigid3> AgentCommands::Kidnap(
    const RequestedPose& pose) {
  TL_ASSIGN_OR_RETURN(const core::LevelPose on_level,
                      OnLevel(pose, "the pose"));
  return DoKidnap([&](SimulationControl& simulation) {
    return simulation.Kidnap(on_level);
  });
}

absl::StatusOr<geometry::Rigid3> AgentCommands::KidnapTo(
    const std::string& place) {
  return DoKidnap([&](SimulationControl& simulation) {
    return simulation.KidnapTo(place);
  });
}

absl::StatusOr<geometry::Rigid3> AgentCommands::KidnapAnywhere() {
  return DoKidnap([](SimulationControl& simulation) {
    return simulation.KidnapAnywhere();
  });
}

absl::StatusOr<std::string> AgentCommands::AddObstacle(
    const RequestedPose& pose, double size_m) {
  TL_RETURN_IF_ERROR(CheckSimulated());
  if (!(size_m >= 0.1 && size_m <= 3)) {
    return absl::InvalidArgumentError(
        absl::StrCat("the obstacle is ", size_m, " m wide; it must be 0.1..3"));
  }
  TL_ASSIGN_OR_RETURN(const core::LevelPose on_level,
                      OnLevel(pose, "the obstacle"));
  std::string name;
  TL_RETURN_IF_ERROR(
      hub_.Do([&](behavior::Navigator& /*navigator*/) -> absl::Status {
        TL_ASSIGN_OR_RETURN(name, simulation_->AddObstacle(on_level, size_m));
        return absl::OkStatus();
      }));
  return name;
}

absl::Status AgentCommands::RemoveObstacle(const std::string& name) {
  TL_RETURN_IF_ERROR(CheckSimulated());
  return hub_.Do([&](behavior::Navigator& /*navigator*/) {
    return simulation_->RemoveObstacle(name);
  });
}

absl::Status AgentCommands::InjectFault(const RequestedFault& fault) {
  TL_RETURN_IF_ERROR(CheckSimulated());
  return hub_.Do([&](behavior::Navigator& /*navigator*/) {
    return simulation_->InjectFault(fault);
  });
}

}  // namespace treeline::agent_service
