#include "tests/robot/testing_mission.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/geometry/planar_pose.h"
#include "gtest/gtest.h"
#include "simulation/runs/localize_world.h"

namespace treeline {
namespace {

constexpr simulator::SimTime kStep = std::chrono::milliseconds(25);
constexpr double kLevelGap_m = 1.0;

}  // namespace

std::vector<core::RgbdFrame> BlankCamera::TakeFrames() {
  core::RgbdFrame frame;
  frame.stamp = clock_.Now();
  frame.sequence = frames_++;
  return {frame};
}

core::DeviceHealth BlankCamera::Health() const {
  core::DeviceHealth health;
  health.state = core::DeviceState::kRunning;
  return health;
}

void TestMission::MakeServer() {
  camera_ = std::make_unique<BlankCamera>(simulator_->clock());
  server_ = std::make_unique<ScriptedServer>(simulator_->clock());
  server_->answers = [this](const core::RgbdFrame& frame) {
    core::RelocalizationAnswer answer;
    answer.stamp = frame.stamp;
    answer.localized = true;
    answer.confidence = 0.97;
    answer.inliers = 200;
    answer.samples = 300;
    const simulator::SimTime at =
        std::chrono::duration_cast<simulator::SimTime>(
            frame.stamp - simulator::SimClock::StampOf(simulator::SimTime(0)));
    answer.map_from_camera = simulator_->WorldFromBaseAt(at) *
                             simulator_->options().robot.base_from_camera;
    for (size_t i = 0; i < 36; i += 7) {
      answer.covariance[i] = i < 21 ? 9e-4 : 2e-4;
    }
    return ScriptedServer::Answer(answer);
  };
}

TestMission::TestMission(const TestMissionOptions& options) {
  worlds::WorldOptions world_options;
  world_options.with_people = false;
  world_options.paint = false;
  auto world = worlds::MakeWorld(options.world, world_options);
  EXPECT_TRUE(world.ok()) << world.status();
  if (!world.ok()) return;
  auto voxels = runs::VoxelsOfWorld(*world, 0.05);
  EXPECT_TRUE(voxels.ok()) << voxels.status();
  if (!voxels.ok()) return;
  simulator::SimulatorOptions simulation;
  simulation.errors = options.errors;
  simulation.start = {.position = options.start, .yaw_rad = options.yaw_rad};
  simulation.seed = options.seed;
  auto levels = traversability::ExtractTraversableMap(
      *voxels, traversability::TraversabilityOptions::For(simulation.robot));
  EXPECT_TRUE(levels.ok()) << levels.status();
  if (!levels.ok()) return;
  auto simulator = simulator::Simulator::Create(*std::move(world), simulation);
  EXPECT_TRUE(simulator.ok()) << simulator.status();
  if (!simulator.ok()) return;
  simulator_ = *std::move(simulator);
  auto map =
      traversability::NavigationMap::Make(*levels, options.navigator.map);
  EXPECT_TRUE(map.ok()) << map.status();
  if (!map.ok()) return;
  map_ = std::make_shared<const traversability::NavigationMap>(*std::move(map));
  if (options.has_server) MakeServer();
  const behavior::NavigatorDevices devices = {
      .laser = simulator_->laser(),
      .odometry = simulator_->odometry(),
      .base = simulator_->base(),
      .camera = camera_.get(),
      .server = server_.get()};
  auto navigator = behavior::Navigator::Create(
      {*std::move(voxels), *std::move(levels)}, simulation.robot, devices,
      options.navigator, simulator_->clock());
  EXPECT_TRUE(navigator.ok()) << navigator.status();
  if (!navigator.ok()) return;
  navigator_ = *std::move(navigator);
  if (options.is_told_its_pose) {
    const absl::Status told = navigator_->SetPose(
        At(options.start.x, options.start.y, options.yaw_rad),
        {0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.01});
    EXPECT_TRUE(told.ok()) << told;
  }
}

core::LevelPose TestMission::At(double x_m, double y_m, double yaw_rad,
                                int level) const {
  return {
      .map_from_base = {{x_m, y_m}, yaw_rad},
      .place = map_->GroundOf({x_m, y_m}, level)
                   .value_or(core::LevelPlace{.level = level, .height_m = 0})};
}

core::LevelPose TestMission::Near(double x_m, double y_m, double yaw_rad,
                                  double height_m) const {
  core::LevelPose nearest = At(x_m, y_m, yaw_rad);
  for (int level = 0; level < map_->levels(); ++level) {
    const core::LevelPose pose = At(x_m, y_m, yaw_rad, level);
    if (map_->GroundOf({x_m, y_m}, level).has_value() &&
        std::abs(pose.place.height_m - height_m) <
            std::abs(nearest.place.height_m - height_m)) {
      nearest = pose;
    }
  }
  EXPECT_LT(std::abs(nearest.place.height_m - height_m), kLevelGap_m);
  return nearest;
}

void TestMission::Run(double seconds, const std::function<void()>& each) {
  const simulator::SimTime end =
      simulator_->now() + simulator::FromSeconds(seconds);
  while (simulator_->now() < end) {
    simulator_->Step(kStep);
    navigator_->Step();
    for (behavior::NavigatorEvent& event : navigator_->TakeEvents()) {
      events_.push_back(std::move(event));
    }
    for (simulator::SimEvent& event : simulator_->TakeEvents()) {
      if (event.kind == simulator::SimEventKind::kCollision ||
          event.kind == simulator::SimEventKind::kFall ||
          event.kind == simulator::SimEventKind::kStairs ||
          event.kind == simulator::SimEventKind::kTipped) {
        mishaps_.push_back(std::move(event));
      }
    }
    top_speed_mps_ =
        std::max(top_speed_mps_, std::abs(simulator_->state().forward_mps));
    if (each) each();
  }
}

bool TestMission::RunUntil(const std::function<bool()>& done, double max_s) {
  const simulator::SimTime end =
      simulator_->now() + simulator::FromSeconds(max_s);
  while (simulator_->now() < end) {
    if (done()) return true;
    Run(0.025);
  }
  return done();
}

behavior::GoalStatus TestMission::RunToEnd(double max_s,
                                           const std::function<void()>& each) {
  const simulator::SimTime end =
      simulator_->now() + simulator::FromSeconds(max_s);
  while (simulator_->now() < end) {
    Run(0.025, each);
    const std::optional<behavior::GoalStatus> goal = navigator_->goal();
    if (goal.has_value() && goal->state != behavior::GoalState::kAccepted &&
        goal->state != behavior::GoalState::kActive) {
      return *goal;
    }
  }
  return navigator_->goal().value_or(behavior::GoalStatus{});
}

uint64_t TestMission::Send(std::vector<core::LevelPose> poses) {
  const absl::StatusOr<uint64_t> id =
      navigator_->SetGoal({.poses = std::move(poses)});
  EXPECT_TRUE(id.ok()) << id.status();
  return id.ok() ? *id : 0;
}

geometry::Rigid2 TestMission::Truth() const {
  return geometry::PlanarPose(simulator_->state().world_from_base);
}

double TestMission::Error_m() const {
  const std::optional<localization::TrackedPose> pose =
      navigator_->Snapshot().pose;
  if (!pose.has_value()) return 1e9;
  return Norm(pose->pose.map_from_base.translation - Truth().translation);
}

bool TestMission::HasEvent(const std::string& kind,
                           const std::string& part) const {
  return std::ranges::any_of(
      events_, [&](const behavior::NavigatorEvent& event) {
        return event.kind == kind && absl::StrContains(event.text, part);
      });
}

std::string TestMission::Story() const {
  std::string story;
  for (const behavior::NavigatorEvent& event : events_) {
    absl::StrAppendFormat(
        &story, "%7.2f %s: %s\n",
        std::chrono::duration<double>(event.stamp.time_since_epoch()).count(),
        event.kind, event.text);
  }
  for (const simulator::SimEvent& event : mishaps_) {
    absl::StrAppendFormat(&story, "%7.2f %s %s%s\n",
                          simulator::Seconds(event.time),
                          simulator::SimEventName(event.kind), event.what,
                          event.caused_by_robot ? " by the robot" : "");
  }
  return story;
}

double TestMission::TakeTopSpeed_mps() {
  return std::exchange(top_speed_mps_, 0);
}

}  // namespace treeline
