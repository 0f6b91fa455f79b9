// A navigator of parts that a test moves by hand.
#ifndef NAV_AGENT_BEHAVIOR_TESTING_NAVIGATOR_H_
#define NAV_AGENT_BEHAVIOR_TESTING_NAVIGATOR_H_

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "gtest/gtest.h"
#include "nav_agent/behavior/testing_devices.h"
#include "nav_agent/behavior/testing_parts.h"

namespace treeline::behavior {

class NavigatorFixture : public testing::Test {
 protected:
  static constexpr double kStep_s = 0.025;

  void Make(const NavigatorOptions& options = {}) {
    NavigatorParts parts;
    parts.map = OpenMap();
    auto planner_part = std::make_unique<FakePlannerWorker>();
    auto controller_part = std::make_unique<FakeController>();
    auto tracker_part = std::make_unique<FakeTracker>();
    auto lost_part = std::make_unique<FakeLost>();
    planner = planner_part.get();
    controller = controller_part.get();
    tracker = tracker_part.get();
    lost = lost_part.get();
    parts.planner = std::move(planner_part);
    parts.controller = std::move(controller_part);
    parts.tracker = std::move(tracker_part);
    parts.lost = std::move(lost_part);
    auto made =
        AssembleNavigator(std::move(parts), core::RobotModel{},
                          {.laser = laser,
                           .odometry = odometry,
                           .base = base,
                           .rear_laser = has_rear_laser ? &rear_laser : nullptr,
                           .camera = &camera,
                           .server = nullptr},
                          options, clock);
    ASSERT_TRUE(made.ok()) << made.status();
    navigator = *std::move(made);
  }
  // Told where it is, with sensors that run.
  void MakePlaced(const NavigatorOptions& options = {}) {
    Make(options);
    ASSERT_TRUE(navigator->SetPose(PoseAtPoint(2, 2), {}).ok());
    Run(0.1);
  }

  void Measure() {
    if (laser_runs) {
      core::LaserScan scan;
      scan.stamp = clock.Now();
      // Never twice the same, as of a real one.
      scan.ranges_m.assign(
          31, laser_range_m + 1e-4f * static_cast<float>(++scans_));
      laser.waiting.push_back(std::move(scan));
    }
    if (rear_laser_runs) {
      core::LaserScan scan;
      scan.stamp = clock.Now();
      scan.ranges_m.assign(31, 4.0f + 1e-4f * static_cast<float>(++scans_));
      rear_laser.waiting.push_back(std::move(scan));
    }
    if (odometry_runs) {
      reading.stamp = clock.Now();
      reading.pitch_rad = 1e-4 * static_cast<double>(++readings_ % 7) + pitch;
      odometry.waiting.push_back(reading);
    }
  }
  void Run(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds / kStep_s + 0.5); ++i) {
      clock.Advance_s(kStep_s);
      Measure();
      navigator->Step();
      for (NavigatorEvent& event : navigator->TakeEvents()) {
        events.push_back(std::move(event));
      }
    }
  }
  uint64_t Send(std::vector<core::LevelPose> poses) {
    const absl::StatusOr<uint64_t> id =
        navigator->SetGoal({.poses = std::move(poses)});
    EXPECT_TRUE(id.ok()) << id.status();
    return id.value_or(0);
  }
  GoalStatus Goal() { return navigator->goal().value_or(GoalStatus{}); }
  NavigatorMode mode() { return navigator->mode(); }
  core::VelocityCommand Last() {
    return base.commands.empty() ? core::VelocityCommand{}
                                 : base.commands.back();
  }
  int Count(const std::string& kind, const std::string& part) {
    int count = 0;
    for (const NavigatorEvent& event : events) {
      count +=
          event.kind == kind && absl::StrContains(event.text, part) ? 1 : 0;
    }
    return count;
  }

  ManualClock clock;
  FakeLaser laser;
  FakeLaser rear_laser;
  FakeOdometry odometry;
  FakeBase base;
  FakeCamera camera;
  FakePlannerWorker* planner = nullptr;
  FakeController* controller = nullptr;
  FakeTracker* tracker = nullptr;
  FakeLost* lost = nullptr;
  std::unique_ptr<Navigator> navigator;
  std::vector<NavigatorEvent> events;
  core::BaseReading reading;
  double pitch = 0;
  bool has_rear_laser = false;
  float laser_range_m = 3;
  bool laser_runs = true;
  bool rear_laser_runs = true;
  bool odometry_runs = true;

 private:
  int scans_ = 0;
  int readings_ = 0;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_TESTING_NAVIGATOR_H_
