#include "nav_agent/service/testing_navigator.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"

namespace treeline::agent_service {

void FakeNavigator::Step() {
  ++snapshot.steps;
  if (!snapshot.goal.has_value() ||
      snapshot.goal->state != behavior::GoalState::kActive ||
      snapshot.mode == behavior::NavigatorMode::kPaused ||
      snapshot.stop.has_value()) {
    return;
  }
  if (!snapshot.pose.has_value()) snapshot.pose = localization::TrackedPose{};
  behavior::GoalStatus& goal = *snapshot.goal;
  const core::LevelPose& target = last_goal.poses.back();
  geometry::Vec2& at = snapshot.pose->pose.map_from_base.translation;
  const geometry::Vec2 way = target.map_from_base.translation - at;
  goal.to_go_m = geometry::Norm(way);
  constexpr double kStride_m = 0.1;
  if (goal.to_go_m <= kStride_m && !may_arrive) return;
  if (goal.to_go_m <= kStride_m) {
    snapshot.pose->pose = target;
    goal.to_go_m = 0;
    goal.state = behavior::GoalState::kSucceeded;
    snapshot.mode = behavior::NavigatorMode::kIdle;
    return;
  }
  snapshot.mode = behavior::NavigatorMode::kDriving;
  at = at + (kStride_m / goal.to_go_m) * way;
  goal.driven_m += kStride_m;
}

void FakeNavigator::Stop(const std::string& why) {
  snapshot.stop = {.why = why, .since = snapshot.stamp};
  snapshot.mode = behavior::NavigatorMode::kStopped;
  snapshot.command = {};
  if (snapshot.goal.has_value() &&
      snapshot.goal->state == behavior::GoalState::kActive) {
    snapshot.goal->state = behavior::GoalState::kCancelled;
    snapshot.goal->cause = core::NavigationCause::kStopped;
    snapshot.goal->why = "the robot was stopped: " + why;
  }
}

void FakeNavigator::Release() {
  snapshot.stop.reset();
  snapshot.mode = behavior::NavigatorMode::kIdle;
}

absl::Status FakeNavigator::Drive(const core::VelocityCommand& wanted) {
  if (snapshot.stop.has_value()) {
    return absl::FailedPreconditionError("it is stopped");
  }
  snapshot.command = wanted;
  snapshot.mode = behavior::NavigatorMode::kManual;
  return absl::OkStatus();
}

absl::Status FakeNavigator::Steer(const behavior::SteeringCommand& steering) {
  if (snapshot.stop.has_value()) {
    return absl::FailedPreconditionError("it is stopped");
  }
  snapshot.command = steering.wanted;
  snapshot.mode = behavior::NavigatorMode::kDriving;
  if (!snapshot.pose.has_value()) snapshot.pose = localization::TrackedPose{};
  constexpr double kStep_s = 0.1;
  geometry::Rigid2& at = snapshot.pose->pose.map_from_base;
  at = at * geometry::Rigid2{{kStep_s * steering.wanted.forward_mps, 0},
                             kStep_s * steering.wanted.yaw_rate_radps};
  return absl::OkStatus();
}

absl::StatusOr<uint64_t> FakeNavigator::SetGoal(
    const behavior::NavigationGoal& goal) {
  if (snapshot.stop.has_value()) {
    return absl::FailedPreconditionError("it is stopped");
  }
  last_goal = goal;
  behavior::GoalStatus status;
  status.id = ++goals_;
  status.state = behavior::GoalState::kActive;
  snapshot.goal = status;
  return goals_;
}

absl::Status FakeNavigator::CancelGoal(uint64_t id) {
  if (!snapshot.goal.has_value() || (id != 0 && id != snapshot.goal->id) ||
      snapshot.goal->state != behavior::GoalState::kActive) {
    return absl::NotFoundError(absl::StrCat("goal ", id, " is not driven to"));
  }
  snapshot.goal->state = behavior::GoalState::kCancelled;
  snapshot.goal->cause = core::NavigationCause::kCancelled;
  return absl::OkStatus();
}

absl::Status FakeNavigator::SetPose(
    const core::LevelPose& pose,
    const localization::PoseCovariance2& covariance) {
  snapshot.pose.emplace();
  snapshot.pose->pose = pose;
  snapshot.pose->covariance = covariance;
  return absl::OkStatus();
}

absl::StatusOr<geometry::Rigid3> FakeSimulation::Kidnap(
    const core::LevelPose& pose) {
  const geometry::Vec2& at = pose.map_from_base.translation;
  calls.push_back(absl::StrCat("kidnap ", at.x, " ", at.y, " on ",
                               pose.place.level, " at ", pose.place.height_m));
  return geometry::Rigid3{.rotation = {}, .translation = {at.x, at.y, 0}};
}

absl::StatusOr<geometry::Rigid3> FakeSimulation::KidnapTo(
    const std::string& place) {
  if (place != "kitchen") {
    return absl::NotFoundError("no such place; there are: kitchen");
  }
  calls.push_back("kidnap to " + place);
  return geometry::Rigid3{.rotation = {}, .translation = {3, 2, 0}};
}

absl::StatusOr<geometry::Rigid3> FakeSimulation::KidnapAnywhere() {
  calls.emplace_back("kidnap anywhere");
  return geometry::Rigid3{};
}

absl::StatusOr<std::string> FakeSimulation::AddObstacle(
    const core::LevelPose& pose, double size_m) {
  calls.push_back(
      absl::StrCat("obstacle of ", size_m, " on ", pose.place.level));
  return "box-1";
}

absl::Status FakeSimulation::RemoveObstacle(const std::string& name) {
  if (name != "box-1") return absl::NotFoundError("no such obstacle");
  calls.push_back("remove " + name);
  return absl::OkStatus();
}

absl::Status FakeSimulation::InjectFault(const RequestedFault& fault) {
  calls.push_back(absl::StrCat("fault ", fault.target, " ", fault.kind, " ",
                               fault.duration_s, " ", fault.amount));
  return absl::OkStatus();
}

std::shared_ptr<const behavior::NavigatorMap> TwoLevelMap() {
  constexpr int kWidth = 8;
  constexpr int kHeight = 6;
  auto map = std::make_shared<behavior::NavigatorMap>();
  for (int i = 0; i < 2; ++i) {
    traversability::TraversableLevel level;
    level.grid = core::OccupancyGrid::Filled(
        kWidth, kHeight, 0.5, {{-1, -1}, 0}, core::Occupancy::kFree);
    const auto cells = static_cast<size_t>(kWidth * kHeight);
    level.height_m.assign(cells, static_cast<float>(i));
    level.slope_rad.assign(cells, 0);
    level.clearance_m.assign(cells, 2);
    map->levels.levels.push_back(std::move(level));
  }
  traversability::TraversableLevel& lower = map->levels.levels[0];
  for (int y = 0; y < kHeight; ++y)
    lower.grid.Set({4, y}, core::Occupancy::kOccupied);
  map->voxels = octree::VoxelMap::Make(0.5, {-2, -2, 0}, {8, 6, 3}).value();
  map->voxels.Set({0, 0, 0}, octree::Voxel::kOccupied);
  map->voxels.Set({7, 5, 2}, octree::Voxel::kOccupied);
  return map;
}

AgentInfo TestInfo() {
  return {.version = "1.2.3",
          .robot = {},
          .map_name = "house",
          .map = TwoLevelMap(),
          .is_simulated = true,
          .world = "cafe",
          .places = {"kitchen"},
          .server = "localhost:50051"};
}

SteppingAgent::SteppingAgent(bool is_simulated, const AgentHubOptions& options)
    : hub(options),
      commands(hub, info, is_simulated ? &simulation : nullptr),
      thread_([this](const std::stop_token& stop) {
        while (!stop.stop_requested()) {
          hub.RunCommands(navigator);
          navigator.Step();
          commands.StepRoute(navigator, clock_.Now());
          commands.StepDocks(navigator, clock_.Now(), std::nullopt);
          AgentState state;
          state.snapshot = navigator.Snapshot();
          if (state.snapshot.goal.has_value()) {
            state.goal_poses = commands.PosesOf(state.snapshot.goal->id);
          }
          commands.ShowRoute(state);
          hub.Publish(std::move(state));
          // Not to burn a core; nothing depends on it.
          absl::SleepFor(absl::Milliseconds(1));
        }
      }) {}

SteppingAgent::~SteppingAgent() { Close(); }

void SteppingAgent::Close() {
  hub.Close();
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
}

}  // namespace treeline::agent_service
