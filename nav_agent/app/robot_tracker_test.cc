// The tracker in the simulator; nav_agent/localization knows no simulator.
#include "nav_agent/localization/robot_tracker.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/synthetic/world.h"
#include "gtest/gtest.h"
#include "nav_agent/app/localize_world.h"
#include "nav_agent/sim/scenario.h"
#include "nav_agent/sim/simulator.h"

namespace treeline {
namespace {

constexpr SimTime kStep = std::chrono::milliseconds(25);
constexpr PoseCovariance2 kTold = {0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.0025};

// A world with its map, made once for all tests.
struct Place {
  VoxelMap voxels;
  TraversableMap levels;
};

Place MakePlace(const std::string& name) {
  const World world =
      *MakeWorld(name, {.with_people = false, .threads = 1, .paint = false});
  Place place;
  place.voxels = *VoxelsOfWorld(world, 0.05);
  place.levels = *ExtractTraversableMap(place.voxels);
  return place;
}

LevelPose TruthOf(const Simulator& simulator) {
  const Rigid3 pose = simulator.state().world_from_base;
  const Vec3 ahead = pose.rotation * Vec3{1, 0, 0};
  return {.map_from_base = {{pose.translation.x, pose.translation.y},
                            std::atan2(ahead.y, ahead.x)},
          .place = {.level = 0, .height_m = pose.translation.z}};
}

// A robot with a tracker in a world.
class Tracked {
 public:
  Tracked(const std::string& world_name, const Place& place, uint64_t seed) {
    Scenario scenario;
    scenario.world = world_name;
    scenario.options.seed = seed;
    World world = *MakeWorld(
        world_name, {.with_people = false, .threads = 1, .paint = false});
    scenario.options.start = *StartOf(scenario, world);
    simulator_ = *Simulator::Create(std::move(world), scenario.options);
    simulator_->Step(std::chrono::milliseconds(200));
    tracker_ = *RobotTracker::Create(
        place.voxels, place.levels, simulator_->options().robot,
        simulator_->laser().Info(), {}, seed);
    player_ = std::make_unique<ScenarioPlayer>(Scenario(), *simulator_);
  }

  Simulator& simulator() { return *simulator_; }
  RobotTracker& tracker() { return *tracker_; }
  ScenarioPlayer& player() { return *player_; }

  void Feed() {
    for (const BaseReading& reading : simulator_->odometry().TakeReadings()) {
      EXPECT_TRUE(tracker_->AddReading(reading).ok());
    }
    for (const LaserScan& scan : simulator_->laser().TakeScans()) {
      EXPECT_TRUE(tracker_->AddScan(scan).ok());
    }
  }
  void TellTruth() {
    Feed();
    const absl::Status told =
        tracker_->SetPose(TruthOf(*simulator_), kTold,
                          simulator_->clock().Now());
    EXPECT_TRUE(told.ok()) << told;
  }
  void Step() {
    player_->Step(kStep);
    Feed();
  }
  double Error_m() const {
    const auto pose = tracker_->Pose();
    if (!pose.has_value()) return 1e9;
    return Norm(pose->pose.map_from_base.translation -
                TruthOf(*simulator_).map_from_base.translation);
  }

 private:
  std::unique_ptr<Simulator> simulator_;
  std::unique_ptr<RobotTracker> tracker_;
  std::unique_ptr<ScenarioPlayer> player_;
};

TEST(RobotTracker, FollowsATourOverARampToAnotherLevel) {
  const Place place = MakePlace("two-storey");
  Tracked robot("two-storey", place, 1001);
  robot.TellTruth();
  robot.player().DriveTour({});
  double worst_m = 0;
  double highest = 0;
  double rise_m = 0;
  std::vector<int> levels;
  for (int i = 0; i < 40 * 200; ++i) {
    robot.Step();
    worst_m = std::max(worst_m, robot.Error_m());
    if (highest < robot.tracker().verdict().probability) {
      std::printf("t %.2f p %.3f err %.3f h %.2f\n", i * 0.025,
                  robot.tracker().verdict().probability, robot.Error_m(),
                  TruthOf(robot.simulator()).place.height_m);
    }
    highest = std::max(highest, robot.tracker().verdict().probability);
    const auto pose = robot.tracker().Pose();
    ASSERT_TRUE(pose.has_value());
    rise_m = std::max(rise_m, std::abs(pose->pose.place.height_m -
                                       TruthOf(robot.simulator()).place.height_m));
    if (levels.empty() || levels.back() != pose->pose.place.level) {
      levels.push_back(pose->pose.place.level);
      std::printf("t %.2f level %d\n", i * 0.025, levels.back());
    }
  }
  std::printf("worst %.3f highest %.3f rise %.3f\n", worst_m, highest, rise_m);
}

}  // namespace
}  // namespace treeline
