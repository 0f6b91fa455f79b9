#include "nav_agent/control/dynamic_obstacle_tracker.h"

#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "gtest/gtest.h"

namespace treeline::control {
namespace {

constexpr double kInterval_s = 0.025;
// 270 degrees at 0.5 degrees, as a UTM-30LX with every second beam.
const core::RangeSensorInfo kLaser = {
    .angle_min_rad = -0.75 * std::numbers::pi,
    .angle_increment_rad = std::numbers::pi / 360,
    .beams = 541,
    .range_min_m = 0.1,
    .range_max_m = 30,
    .beam_interval_s = 0,
    .scan_interval_s = kInterval_s};

// An empty hall in which one walks, a disc of 15 cm. The laser is at the map's
// origin and looks along x.
class Hall {
 public:
  explicit Hall(DynamicObstacleTrackerOptions options = {})
      : tracks_(options) {}

  // A scan; somebody at `at`, if anybody.
  void Scan(std::optional<geometry::Vec2> at,
            std::optional<geometry::Vec2> wall = std::nullopt) {
    time_s_ += kInterval_s;
    core::LaserScan scan;
    scan.stamp = base::MonotonicTime() +
                 std::chrono::microseconds(std::llround(1e6 * time_s_));
    scan.ranges_m.assign(541, core::kNoReturn);
    std::vector<ObservedPoint> points;
    for (int beam = 0; beam < kLaser.beams; ++beam) {
      const double angle = kLaser.AngleOf_rad(beam);
      const geometry::Vec2 way = {std::cos(angle), std::sin(angle)};
      for (const auto& [middle, moves] :
           {std::pair(at, true), std::pair(wall, false)}) {
        if (!middle.has_value()) continue;
        const double along_m = geometry::Dot(*middle, way);
        const double beside_m = std::abs(geometry::Cross(way, *middle));
        float& range_m = scan.ranges_m[static_cast<size_t>(beam)];
        if (along_m <= 0 || beside_m > 0.15 || along_m > range_m) continue;
        range_m = static_cast<float>(along_m - 0.15);
        points.push_back({.in_map = (along_m - 0.15) * way,
                          .is_moving = moves,
                          .is_new = true});
      }
    }
    const TrackedScan look = {
        .laser = kLaser, .map_from_laser = {}, .scan = scan, .points = points};
    tracks_.AddLooks(scan.stamp, {&look, 1});
  }
  std::vector<DynamicObstacle> DynamicObstacles() const {
    return tracks_.DynamicObstacles();
  }
  DynamicObstacleTracker& tracks() { return tracks_; }

 private:
  DynamicObstacleTracker tracks_;
  double time_s_ = 0;
};

TEST(DynamicObstacleTracker, FollowsOneWhoWalksAndKnowsItsSpeed) {
  Hall hall;
  geometry::Vec2 at = {1.5, -1.5};
  for (int scan = 0; scan < 80; ++scan) {
    hall.Scan(at);
    at.y += 1.0 * kInterval_s;
  }
  const std::vector<DynamicObstacle> movers = hall.DynamicObstacles();
  ASSERT_EQ(movers.size(), 1u);
  EXPECT_EQ(movers[0].unseen_s, 0);
  EXPECT_EQ(movers[0].position_uncertainty_m, 0);
  EXPECT_NEAR(geometry::Norm(movers[0].in_map - at), 0.15, 0.1);
  EXPECT_NEAR(movers[0].velocity_mps.y, 1.0, 0.1);
  EXPECT_NEAR(movers[0].velocity_mps.x, 0, 0.1);
}

// Behind the first laser, before a second one that looks back.
TEST(DynamicObstacleTracker, IsFollowedBySecondLaserToo) {
  DynamicObstacleTracker tracks({});
  const geometry::Rigid3 back = {
      .rotation = geometry::Rotation3::FromAxisAngle({0, 0, std::numbers::pi}),
      .translation = {-0.4, 0, 0}};
  core::LaserScan empty;
  empty.ranges_m.assign(541, core::kNoReturn);
  geometry::Vec2 at = {-2.5, 0};
  for (int scan = 1; scan <= 60; ++scan) {
    const ObservedPoint point = {
        .in_map = at, .is_moving = true, .is_new = true};
    core::LaserScan rear = empty;
    // Straight ahead of it.
    rear.ranges_m[270] = static_cast<float>(-0.4 - at.x);
    const TrackedScan looks[] = {
        {.laser = kLaser, .map_from_laser = {}, .scan = empty, .points = {}},
        {.laser = kLaser,
         .map_from_laser = back,
         .scan = rear,
         .points = {&point, 1}}};
    tracks.AddLooks(
        base::MonotonicTime() + std::chrono::milliseconds(25 * scan), looks);
    at.x += 0.8 * kInterval_s;
  }
  ASSERT_EQ(tracks.DynamicObstacles().size(), 1u);
  EXPECT_EQ(tracks.DynamicObstacles()[0].unseen_s, 0);
  EXPECT_NEAR(tracks.DynamicObstacles()[0].velocity_mps.x, 0.8, 0.1);
  // It goes, and the laser that looks there shows that it is gone.
  for (int scan = 61; scan <= 80; ++scan) {
    const TrackedScan looks[] = {
        {.laser = kLaser, .map_from_laser = {}, .scan = empty, .points = {}},
        {.laser = kLaser, .map_from_laser = back, .scan = empty, .points = {}}};
    tracks.AddLooks(
        base::MonotonicTime() + std::chrono::milliseconds(25 * scan), looks);
  }
  EXPECT_TRUE(tracks.DynamicObstacles().empty());
}

// It walks past on the left and turns in behind; there it goes on.
TEST(DynamicObstacleTracker, WalksOnBehindTheLaserAndIsDoubtedMoreAndMore) {
  Hall hall;
  geometry::Vec2 at = {1.5, 0.8};
  double unseen_s = 0;
  for (int scan = 0; scan < 130; ++scan) {
    hall.Scan(at);
    at.x -= 1.0 * kInterval_s;
    // The middle of it is behind the last beam.
    if (at.x < -0.8) unseen_s += kInterval_s;
  }
  const std::vector<DynamicObstacle> movers = hall.DynamicObstacles();
  ASSERT_EQ(movers.size(), 1u);
  EXPECT_NEAR(movers[0].unseen_s, unseen_s, 0.3);
  EXPECT_GT(movers[0].unseen_s, 0.5);
  EXPECT_NEAR(movers[0].position_uncertainty_m, 0.35 * movers[0].unseen_s,
              1e-9);
  EXPECT_LT(geometry::Norm(movers[0].in_map - at),
            0.15 + movers[0].position_uncertainty_m);
}

TEST(DynamicObstacleTracker, WhoCrossesBehindIsOneAndTheSameOnTheOtherSide) {
  Hall hall;
  geometry::Vec2 at = {-0.9, 2.0};
  for (int scan = 0; scan < 160; ++scan) {
    hall.Scan(at);
    at.y -= 1.0 * kInterval_s;
  }
  const std::vector<DynamicObstacle> movers = hall.DynamicObstacles();
  ASSERT_EQ(movers.size(), 1u);
  EXPECT_EQ(movers[0].unseen_s, 0);
  EXPECT_LT(geometry::Norm(movers[0].in_map - at), 0.35);
}

TEST(DynamicObstacleTracker, ForgetsWhoIsNotWhereTheLaserLooks) {
  Hall hall;
  for (int scan = 0; scan < 40; ++scan) {
    hall.Scan(geometry::Vec2{1.5, -0.5 + scan * kInterval_s});
  }
  ASSERT_EQ(hall.DynamicObstacles().size(), 1u);
  for (int scan = 0; scan < 10; ++scan) hall.Scan(std::nullopt);
  EXPECT_TRUE(hall.DynamicObstacles().empty());
}

TEST(DynamicObstacleTracker, KeepsWhoIsHiddenByAnother) {
  Hall hall;
  for (int scan = 0; scan < 40; ++scan) {
    hall.Scan(geometry::Vec2{2.0 - 0.1 * kInterval_s * scan, 0});
  }
  // Something stands in between.
  for (int scan = 0; scan < 20; ++scan)
    hall.Scan(std::nullopt, geometry::Vec2{1.0, 0});
  ASSERT_EQ(hall.DynamicObstacles().size(), 1u);
  EXPECT_NEAR(hall.DynamicObstacles()[0].unseen_s, 0.5, 1e-6);
}

TEST(DynamicObstacleTracker, ForgetsWhoHasBeenAwayForLong) {
  Hall hall({.memory_s = 1.0});
  geometry::Vec2 at = {-0.9, 1.5};
  // Slowly: it stays behind.
  for (int scan = 0; scan < 100; ++scan) {
    hall.Scan(at);
    at.y -= 0.4 * kInterval_s;
  }
  for (int scan = 0; scan < 60; ++scan) hall.Scan(std::nullopt);
  EXPECT_TRUE(hall.DynamicObstacles().empty());
}

TEST(DynamicObstacleTracker, AFlickerIsNobody) {
  Hall hall;
  for (int scan = 0; scan < 30; ++scan) {
    hall.Scan(scan % 5 < 2 ? std::optional(geometry::Vec2{1.5, 0})
                           : std::nullopt);
    EXPECT_TRUE(hall.DynamicObstacles().empty());
  }
}

TEST(DynamicObstacleTracker, APauseOfTheLaserEndsAll) {
  Hall hall;
  for (int scan = 0; scan < 40; ++scan) {
    hall.Scan(geometry::Vec2{1.5, -0.5 + scan * kInterval_s});
  }
  core::LaserScan late;
  late.stamp = base::MonotonicTime() + std::chrono::seconds(10);
  late.ranges_m.assign(541, core::kNoReturn);
  hall.tracks().AddLooks(late.stamp, {});
  EXPECT_TRUE(hall.DynamicObstacles().empty());
}

}  // namespace
}  // namespace treeline::control
