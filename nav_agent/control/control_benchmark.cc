// What a control step costs: one core has 25 ms for each at 40 Hz.
#include <cmath>
#include <memory>

#include "benchmark/benchmark.h"
#include "nav_agent/control/local_controller.h"
#include "nav_agent/control/local_costmap.h"
#include "nav_agent/control/testing_floor.h"

namespace treeline::control {
namespace {

core::RangeSensorInfo FullLaser() {
  return {.angle_min_rad = -0.75 * std::numbers::pi,
          .angle_increment_rad = 1.5 * std::numbers::pi / 1080,
          .beams = 1081,
          .range_min_m = 0.1,
          .range_max_m = 30,
          .beam_interval_s = 0.025 / 1440,
          .scan_interval_s = 0.025};
}

// A room of 4 x 5 m with a crate in it.
bool IsSolid(geometry::Vec2 at) {
  return at.x < 4 || at.x > 9 || at.y < 4 || at.y > 8 ||
         TestingBox({6.8, 5.7}, {7.3, 6.1})(at);
}

core::LaserScan FullScan(const ControlPose& pose) {
  const core::RangeSensorInfo laser = FullLaser();
  core::LaserScan scan;
  scan.stamp = pose.stamp;
  const geometry::Rigid2 map_from_laser =
      pose.pose.map_from_base *
      geometry::Rigid2{.translation = {0.22, 0}, .yaw_rad = 0};
  for (int beam = 0; beam < laser.beams; ++beam) {
    const double angle_rad = laser.AngleOf_rad(beam);
    double range_m = 0.1;
    while (!IsSolid(map_from_laser *
                    geometry::Vec2{range_m * std::cos(angle_rad),
                                   range_m * std::sin(angle_rad)})) {
      range_m += 0.005;
    }
    scan.ranges_m.push_back(static_cast<float>(range_m));
  }
  return scan;
}

TestingFloor Room() {
  TestingFloor floor;
  floor.Fill({0, 0}, {4, 12}, core::Occupancy::kOccupied)
      .Fill({9, 0}, {12, 12}, core::Occupancy::kOccupied)
      .Fill({0, 0}, {12, 4}, core::Occupancy::kOccupied)
      .Fill({0, 8}, {12, 12}, core::Occupancy::kOccupied);
  return floor;
}

// One scan taken in.
void BM_AddScan(benchmark::State& state) {
  LocalCostmap costmap = *LocalCostmap::Make(Room().Map(), core::RobotModel(),
                                             {.front = FullLaser()}, {});
  const ControlPose pose = TestingPose(5.5, 6);
  const core::LaserScan scan = FullScan(pose);
  costmap.MoveTo(pose);
  for (auto _ : state) benchmark::DoNotOptimize(costmap.AddScan(pose, scan));
}
BENCHMARK(BM_AddScan)->Unit(benchmark::kMicrosecond);

// Exact distances of all cells.
void BM_Distances(benchmark::State& state) {
  LocalCostmap costmap = *LocalCostmap::Make(Room().Map(), core::RobotModel(),
                                             {.front = FullLaser()}, {});
  const ControlPose pose = TestingPose(5.5, 6);
  costmap.MoveTo(pose);
  for (auto _ : state) costmap.Update(pose.stamp);
}
BENCHMARK(BM_Distances)->Unit(benchmark::kMicrosecond);

// The window rolls by a cell: the ground is spread anew.
void BM_Roll(benchmark::State& state) {
  LocalCostmap costmap = *LocalCostmap::Make(Room().Map(), core::RobotModel(),
                                             {.front = FullLaser()}, {});
  bool is_odd = false;
  for (auto _ : state) {
    is_odd = !is_odd;
    costmap.MoveTo(TestingPose(is_odd ? 5.55 : 5.5, 6));
  }
}
BENCHMARK(BM_Roll)->Unit(benchmark::kMicrosecond);

// Everything that happens in a step: a full scan, the window's rolling at
// 0.5 m/s, distances, the band past a crate, speeds, the guard.
void BM_ControlStep(benchmark::State& state) {
  auto controller = *LocalController::Make(Room().Map(), core::RobotModel(),
                                           {.front = FullLaser()}, {});
  std::vector<ControlPose> poses;
  std::vector<core::LaserScan> scans;
  for (int i = 0; i < 64; ++i) {
    const double y = 6.35 + 0.1 * std::sin(0.1 * i);
    poses.push_back(TestingPose(5 + 0.0125 * i, y, 0, 0));
    poses.back().forward_mps = 0.5;
    scans.push_back(FullScan(poses.back()));
  }
  core::LevelPose goal;
  goal.map_from_base.translation = {8.3, 6};
  double time_s = 0;
  size_t i = 0;
  for (auto _ : state) {
    if (i == 0) controller->SetPath({poses[0].pose, goal});
    time_s += 0.025;
    poses[i].stamp = TestingTime(time_s);
    benchmark::DoNotOptimize(controller->AddScan(poses[i], scans[i]));
    benchmark::DoNotOptimize(controller->Step(poses[i]));
    i = (i + 1) % poses.size();
  }
}
BENCHMARK(BM_ControlStep)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace treeline::control

BENCHMARK_MAIN();
