// The tracker in the simulator; nav_agent/localization knows no simulator.
#include "nav_agent/localization/robot_tracker.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "simulation/runs/localize_world.h"
#include "simulation/simulator/scenario.h"
#include "simulation/simulator/scenario_player.h"
#include "simulation/simulator/simulator.h"
#include "simulation/worlds/world.h"

namespace treeline {
namespace {

constexpr simulator::SimTime kStep = std::chrono::milliseconds(25);
constexpr localization::PoseCovariance2 kTold = {0.01, 0, 0, 0,     0.01,
                                                 0,    0, 0, 0.0025};

// A world with its map, made once for all tests.
struct Place {
  octree::VoxelMap voxels;
  traversability::TraversableMap levels;
};

Place MakePlace(const std::string& name) {
  const worlds::World world = *worlds::MakeWorld(
      name, {.with_people = false, .threads = 1, .paint = false});
  Place place;
  place.voxels = *runs::VoxelsOfWorld(world, 0.05);
  place.levels = *traversability::ExtractTraversableMap(place.voxels);
  return place;
}

core::LevelPose TruthOf(const simulator::Simulator& simulator) {
  const geometry::Rigid3 pose = simulator.state().world_from_base;
  const geometry::Vec3 ahead = pose.rotation * geometry::Vec3{1, 0, 0};
  return {.map_from_base = {{pose.translation.x, pose.translation.y},
                            std::atan2(ahead.y, ahead.x)},
          .place = {.level = 0, .height_m = pose.translation.z}};
}

// A robot with a tracker in a world.
class Tracked {
 public:
  Tracked(const std::string& world_name, const Place& place, uint64_t seed) {
    simulator::Scenario scenario;
    scenario.world = world_name;
    scenario.options.seed = seed;
    worlds::World world = *worlds::MakeWorld(
        world_name, {.with_people = false, .threads = 1, .paint = false});
    scenario.options.start = *simulator::StartOf(scenario, world);
    simulator_ =
        *simulator::Simulator::Create(std::move(world), scenario.options);
    simulator_->Step(std::chrono::milliseconds(200));
    tracker_ = *localization::RobotTracker::Create(
        place.voxels, place.levels, simulator_->options().robot,
        simulator_->laser().Info(), {}, seed);
    player_ = std::make_unique<simulator::ScenarioPlayer>(simulator::Scenario(),
                                                          *simulator_);
  }

  simulator::Simulator& simulator() { return *simulator_; }
  localization::RobotTracker& tracker() { return *tracker_; }
  simulator::ScenarioPlayer& player() { return *player_; }

  void Feed() {
    for (const core::BaseReading& reading :
         simulator_->odometry().TakeReadings()) {
      EXPECT_TRUE(tracker_->AddReading(reading).ok());
    }
    for (const core::LaserScan& scan : simulator_->laser().TakeScans()) {
      EXPECT_TRUE(tracker_->AddScan(scan).ok());
    }
  }
  void TellTruth() {
    Feed();
    const absl::Status told = tracker_->SetPose(TruthOf(*simulator_), kTold,
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
  std::unique_ptr<simulator::Simulator> simulator_;
  std::unique_ptr<localization::RobotTracker> tracker_;
  std::unique_ptr<simulator::ScenarioPlayer> player_;
};

const Place& TheLab() {
  static const Place place = MakePlace("lab");
  return place;
}

TEST(RobotTracker, FollowsATourOnSlopesWithinATenthOfAMetre) {
  Tracked robot("lab", TheLab(), 1001);
  robot.TellTruth();
  robot.player().DriveTour({});
  double worst_m = 0;
  double highest = 0;
  for (int i = 0; i < 40 * 20; ++i) {
    robot.Step();
    worst_m = std::max(worst_m, robot.Error_m());
    highest = std::max(highest, robot.tracker().verdict().probability);
  }
  EXPECT_LT(worst_m, 0.1);
  EXPECT_LT(highest, 0.5);
  const auto pose = robot.tracker().Pose();
  ASSERT_TRUE(pose.has_value());
  const auto fit = robot.tracker().FitAt(pose->pose);
  ASSERT_TRUE(fit.has_value());
  EXPECT_GT(fit->explained, 0.8);
  EXPECT_LT(fit->contradicted, 0.1);
  core::LevelPose elsewhere = pose->pose;
  elsewhere.map_from_base.translation.x += 1;
  elsewhere.map_from_base.yaw_rad += 1;
  EXPECT_LT(robot.tracker().FitAt(elsewhere)->explained, 0.7);
  EXPECT_LE(robot.tracker().Particles(100).size(), 100u);
  EXPECT_GT(robot.tracker().Candidates(3).at(0).share, 0.9);
}

TEST(RobotTracker, GoesOverARampToAnotherLevelWithoutAFalseAlarm) {
  const Place place = MakePlace("two-storey");
  Tracked robot("two-storey", place, 1002);
  // On the last metres of the ramp to the upper floor.
  std::optional<simulator::RobotPlacement> start;
  const std::vector<worlds::Float3>& tour = robot.simulator().world().tour;
  for (size_t i = 0; i + 1 < tour.size() && !start.has_value(); ++i) {
    const double from_m = tour[i].z;
    const double to_m = tour[i + 1].z;
    if (from_m >= 2.3 || to_m <= 2.3) continue;
    const double t = (2.3 - from_m) / (to_m - from_m);
    const geometry::Vec2 from = {tour[i].x, tour[i].y};
    const geometry::Vec2 way =
        geometry::Vec2{tour[i + 1].x, tour[i + 1].y} - from;
    start = simulator::RobotPlacement{.position = from + t * way,
                                      .yaw_rad = std::atan2(way.y, way.x),
                                      .height_m = 2.3};
  }
  ASSERT_TRUE(start.has_value());
  ASSERT_TRUE(robot.simulator().Kidnap(*start).ok());
  robot.TellTruth();
  robot.player().DriveTour({});
  double worst_m = 0;
  double highest = 0;
  double height_off_m = 0;
  std::vector<int> levels;
  for (int i = 0; i < 40 * 12; ++i) {
    robot.Step();
    worst_m = std::max(worst_m, robot.Error_m());
    highest = std::max(highest, robot.tracker().verdict().probability);
    const core::LevelPlace ground = robot.tracker().Pose()->pose.place;
    height_off_m = std::max(
        height_off_m,
        std::abs(ground.height_m - TruthOf(robot.simulator()).place.height_m));
    if (levels.empty() || levels.back() != ground.level) {
      levels.push_back(ground.level);
    }
  }
  EXPECT_EQ(levels, (std::vector<int>{0, 1}));
  EXPECT_LT(worst_m, 0.2);
  EXPECT_LT(height_off_m, 0.15);
  EXPECT_LT(highest, 0.5);
}

TEST(RobotTracker, DeclaresAKidnapWithinThreeSeconds) {
  Tracked robot("lab", TheLab(), 1003);
  robot.TellTruth();
  for (int i = 0; i < 40 * 3; ++i) robot.Step();
  EXPECT_LT(robot.tracker().verdict().probability, 0.1);
  const core::LevelPose truth = TruthOf(robot.simulator());
  core::LevelPose wrong = truth;
  wrong.map_from_base.yaw_rad += 1.5;
  // The robot is turned by 90 degrees.
  ASSERT_TRUE(robot.simulator()
                  .Kidnap({.position = truth.map_from_base.translation,
                           .yaw_rad = wrong.map_from_base.yaw_rad,
                           .height_m = truth.place.height_m})
                  .ok());
  for (int i = 0; i < 40 * 3; ++i) robot.Step();
  EXPECT_EQ(robot.tracker().verdict().state, localization::LostState::kLost);
  // Told its place, it knows it again at once.
  robot.TellTruth();
  EXPECT_NE(robot.tracker().verdict().state, localization::LostState::kLost);
  EXPECT_LT(robot.Error_m(), 0.1);
  for (int i = 0; i < 40; ++i) robot.Step();
  EXPECT_LT(robot.tracker().verdict().probability, 0.1);
}

TEST(RobotTracker, KnowsWhereItWasAndDropsWhatIsOlderThanItWasTold) {
  Tracked robot("lab", TheLab(), 1004);
  EXPECT_FALSE(robot.tracker().Pose().has_value());
  robot.Step();
  EXPECT_FALSE(robot.tracker().Pose().has_value());
  EXPECT_TRUE(robot.tracker().Motion().has_value());
  robot.TellTruth();
  robot.player().DriveTour({});
  for (int i = 0; i < 80; ++i) robot.Step();
  const base::MonotonicTime now = robot.simulator().clock().Now();
  const auto before =
      robot.tracker().PoseAt(now - std::chrono::milliseconds(400));
  ASSERT_TRUE(before.has_value());
  const geometry::Rigid3 truth = robot.simulator().WorldFromBaseAt(
      robot.simulator().now() - std::chrono::milliseconds(400));
  EXPECT_LT(Norm(before->pose.map_from_base.translation -
                 geometry::Vec2{truth.translation.x, truth.translation.y}),
            0.1);
  EXPECT_FALSE(
      robot.tracker().PoseAt(now - std::chrono::seconds(10)).has_value());
  const int64_t dropped = robot.tracker().dropped();
  robot.TellTruth();
  core::LaserScan old;
  old.stamp = now - std::chrono::seconds(1);
  old.ranges_m.assign(
      static_cast<size_t>(robot.simulator().laser().Info().beams), 1.0f);
  EXPECT_TRUE(robot.tracker().AddScan(old).ok());
  EXPECT_EQ(robot.tracker().dropped(), dropped + 1);
  old.ranges_m.pop_back();
  EXPECT_EQ(robot.tracker().AddScan(old).code(),
            absl::StatusCode::kInvalidArgument);
  core::LevelPose outside;
  outside.map_from_base.translation = {-100, 0};
  EXPECT_EQ(robot.tracker().SetPose(outside, kTold, now).code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace treeline
