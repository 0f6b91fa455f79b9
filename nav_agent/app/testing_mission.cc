#include "nav_agent/app/testing_mission.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "gtest/gtest.h"
#include "nav_agent/app/localize_world.h"

namespace treeline {
namespace {

constexpr SimTime kStep = std::chrono::milliseconds(25);
constexpr double kLevelGap_m = 1.0;

double YawOf(const Rigid3& pose) {
  const Vec3 ahead = pose.rotation * Vec3{1, 0, 0};
  return std::atan2(ahead.y, ahead.x);
}

}  // namespace

TestMission::TestMission(const TestMissionOptions& options) {
  WorldOptions world_options;
  world_options.with_people = false;
  world_options.paint = false;
  auto world = MakeWorld(options.world, world_options);
  EXPECT_TRUE(world.ok()) << world.status();
  if (!world.ok()) return;
  auto voxels = VoxelsOfWorld(*world, 0.05);
  EXPECT_TRUE(voxels.ok()) << voxels.status();
  if (!voxels.ok()) return;
  SimulatorOptions simulation;
  simulation.errors = options.errors;
  simulation.start = {.position = options.start, .yaw_rad = options.yaw_rad};
  simulation.seed = options.seed;
  auto levels = ExtractTraversableMap(
      *voxels, TraversabilityOptions::For(simulation.robot));
  EXPECT_TRUE(levels.ok()) << levels.status();
  if (!levels.ok()) return;
  auto simulator = Simulator::Create(*std::move(world), simulation);
  EXPECT_TRUE(simulator.ok()) << simulator.status();
  if (!simulator.ok()) return;
  simulator_ = *std::move(simulator);
  auto map = NavigationMap::Make(*levels, options.navigator.map);
  EXPECT_TRUE(map.ok()) << map.status();
  if (!map.ok()) return;
  map_ = std::make_shared<const NavigationMap>(*std::move(map));
  const NavigatorDevices devices = {.laser = simulator_->laser(),
                                    .odometry = simulator_->odometry(),
                                    .base = simulator_->base(),
                                    .camera = options.camera,
                                    .server = options.server};
  auto navigator = Navigator::Create({*std::move(voxels), *std::move(levels)},
                                     simulation.robot, devices,
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

LevelPose TestMission::At(double x_m, double y_m, double yaw_rad,
                          int level) const {
  return {.map_from_base = {{x_m, y_m}, yaw_rad},
          .place = map_->GroundOf({x_m, y_m}, level)
                       .value_or(LevelPlace{.level = level, .height_m = 0})};
}

LevelPose TestMission::Near(double x_m, double y_m, double yaw_rad,
                            double height_m) const {
  LevelPose nearest = At(x_m, y_m, yaw_rad);
  for (int level = 0; level < map_->levels(); ++level) {
    const LevelPose pose = At(x_m, y_m, yaw_rad, level);
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
  const SimTime end = simulator_->now() + FromSeconds(seconds);
  while (simulator_->now() < end) {
    simulator_->Step(kStep);
    navigator_->Step();
    for (NavigatorEvent& event : navigator_->TakeEvents()) {
      events_.push_back(std::move(event));
    }
    for (SimEvent& event : simulator_->TakeEvents()) {
      if (event.kind == SimEventKind::kCollision ||
          event.kind == SimEventKind::kFall ||
          event.kind == SimEventKind::kStairs ||
          event.kind == SimEventKind::kTipped) {
        mishaps_.push_back(std::move(event));
      }
    }
    top_speed_mps_ =
        std::max(top_speed_mps_, std::abs(simulator_->state().forward_mps));
    if (each) each();
  }
}

bool TestMission::RunUntil(const std::function<bool()>& done, double most_s) {
  const SimTime end = simulator_->now() + FromSeconds(most_s);
  while (simulator_->now() < end) {
    if (done()) return true;
    Run(0.025);
  }
  return done();
}

GoalStatus TestMission::RunToEnd(double most_s,
                                 const std::function<void()>& each) {
  const SimTime end = simulator_->now() + FromSeconds(most_s);
  while (simulator_->now() < end) {
    Run(0.025, each);
    const std::optional<GoalStatus> goal = navigator_->goal();
    if (goal.has_value() && goal->state != GoalState::kAccepted &&
        goal->state != GoalState::kActive) {
      return *goal;
    }
  }
  return navigator_->goal().value_or(GoalStatus{});
}

uint64_t TestMission::Send(std::vector<LevelPose> poses) {
  const absl::StatusOr<uint64_t> id =
      navigator_->SetGoal({.poses = std::move(poses)});
  EXPECT_TRUE(id.ok()) << id.status();
  return id.ok() ? *id : 0;
}

Rigid2 TestMission::Truth() const {
  const Rigid3 pose = simulator_->state().world_from_base;
  return {{pose.translation.x, pose.translation.y}, YawOf(pose)};
}

double TestMission::Error_m() const {
  const std::optional<TrackedPose> pose = navigator_->Snapshot().pose;
  if (!pose.has_value()) return 1e9;
  return Norm(pose->pose.map_from_base.translation - Truth().translation);
}

bool TestMission::HasEvent(const std::string& kind,
                           const std::string& part) const {
  return std::ranges::any_of(events_, [&](const NavigatorEvent& event) {
    return event.kind == kind && absl::StrContains(event.text, part);
  });
}

std::string TestMission::Story() const {
  std::string story;
  for (const NavigatorEvent& event : events_) {
    absl::StrAppendFormat(
        &story, "%7.2f %s: %s\n",
        std::chrono::duration<double>(event.stamp.time_since_epoch()).count(),
        event.kind, event.text);
  }
  for (const SimEvent& event : mishaps_) {
    absl::StrAppendFormat(&story, "%7.2f %s %s%s\n", Seconds(event.time),
                          SimEventName(event.kind), event.what,
                          event.caused_by_robot ? " by the robot" : "");
  }
  return story;
}

double TestMission::TakeTopSpeed_mps() {
  return std::exchange(top_speed_mps_, 0);
}

}  // namespace treeline
