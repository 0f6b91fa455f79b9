#include "nav_agent/mapless/mover_tracker.h"

#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>

#include "gtest/gtest.h"

namespace treeline::mapless {
namespace {

constexpr double kScan_s = 0.025;

struct Disc {
  geometry::Vec2 center;
  double radius_m = 0.5;
};

base::MonotonicTime At(double time_s) {
  return base::MonotonicTime() +
         std::chrono::duration_cast<base::MonotonicTime::duration>(
             std::chrono::duration<double>(time_s));
}

// From the discs' near sides, else from a wall 9 m away, 270 degrees of it.
std::vector<GridBeam> Look(geometry::Vec2 from,
                           const std::vector<Disc>& discs) {
  std::vector<GridBeam> beams;
  for (int i = 0; i < 720; ++i) {
    const double angle_rad = (i / 720.0 - 0.5) * 1.5 * std::numbers::pi;
    const geometry::Vec2 way = {std::cos(angle_rad), std::sin(angle_rad)};
    double range_m = 9;
    for (const Disc& disc : discs) {
      const geometry::Vec2 to = disc.center - from;
      const double along_m = to.x * way.x + to.y * way.y;
      const double aside_m = std::abs(to.x * way.y - to.y * way.x);
      if (along_m > 0 && aside_m < disc.radius_m) {
        range_m = std::min(range_m,
                           along_m - std::sqrt(disc.radius_m * disc.radius_m -
                                               aside_m * aside_m));
      }
    }
    beams.push_back({.from = from, .to = from + range_m * way});
  }
  return beams;
}

// Scans of somebody at `from`, who moves, of a disc that moves.
class Watch {
 public:
  Watch(geometry::Vec2 from, geometry::Vec2 own_mps, Disc disc,
        geometry::Vec2 disc_mps)
      : from_(from), own_mps_(own_mps), disc_(disc), disc_mps_(disc_mps) {}

  void For_s(double seconds, const std::vector<Disc>& standing = {}) {
    for (const double end_s = now_s_ + seconds; now_s_ < end_s;
         now_s_ += kScan_s) {
      std::vector<Disc> discs = standing;
      discs.push_back(disc_);
      beams_ = Look(from_, discs);
      tracker_.Add(At(now_s_), beams_, map_);
      map_.AddScan(beams_);
      disc_.center = disc_.center + kScan_s * disc_mps_;
      from_ = from_ + kScan_s * own_mps_;
    }
  }

  void Stop() { disc_mps_ = {}; }
  std::vector<Mover> Movers() const { return tracker_.MoversAt(At(now_s_)); }
  const std::vector<GridBeam>& beams() const { return beams_; }
  const EvidenceGrid& map() const { return map_; }
  const Disc& disc() const { return disc_; }

 private:
  geometry::Vec2 from_;
  geometry::Vec2 own_mps_;
  Disc disc_;
  geometry::Vec2 disc_mps_;
  double now_s_ = 0;
  std::vector<GridBeam> beams_;
  MoverTracker tracker_;
  EvidenceGrid map_;
};

TEST(MoverTracker, WhatCrossesIsForetoldAndIsNoPartOfTheMap) {
  Watch watch({0, 0}, {0, 0}, {.center = {4, -3}}, {0, 1.5});
  watch.For_s(1.5);
  const std::vector<Mover> movers = watch.Movers();
  ASSERT_EQ(movers.size(), 1u);
  EXPECT_NEAR(movers[0].velocity_mps.x, 0, 0.05);
  EXPECT_NEAR(movers[0].velocity_mps.y, 1.5, 0.05);
  EXPECT_NEAR(movers[0].radius_m, 0.5, 0.05);
  EXPECT_LT(geometry::Norm(movers[0].in_map - watch.disc().center), 0.05);
  EXPECT_LT(geometry::Norm(movers[0].After(1) - watch.disc().center -
                           geometry::Vec2{0, 1.5}),
            0.1);
  // Neither where it is nor on the way that it came.
  for (double y = -3.5; y < 0; y += 0.04) {
    EXPECT_NE(watch.map().At(watch.map().CellOf({3.6, y})),
              core::Occupancy::kOccupied)
        << y;
  }
  EXPECT_TRUE(watch.beams()[360].is_on_mover || watch.beams()[350].is_on_mover);
}

TEST(MoverTracker, WhatStandsIsTheMapsHoweverOnePassesIt) {
  // Past a post, and past one that another hides a part of.
  Watch watch({0, 0}, {1.8, 0}, {.center = {2.5, 0.9}, .radius_m = 0.4},
              {0, 0});
  for (int i = 0; i < 20; ++i) {
    watch.For_s(0.1, {{.center = {1.6, 0.7}, .radius_m = 0.1}});
    EXPECT_TRUE(watch.Movers().empty()) << i;
  }
  EXPECT_EQ(watch.map().At(watch.map().CellOf({2.5, 0.51})),
            core::Occupancy::kOccupied);
}

TEST(MoverTracker, TwoThatTouchAreTwo) {
  // They go beside each other, and beams see no gap between them.
  const geometry::Vec2 velocity_mps = {-0.2, 1.2};
  Watch watch({0, 0}, {0, 0}, {.center = {4, -2.5}}, velocity_mps);
  const geometry::Vec2 to_other = {0.3, 0.75};
  for (double now_s = 0; now_s < 2; now_s += kScan_s) {
    watch.For_s(0.9 * kScan_s, {{.center = watch.disc().center + to_other}});
  }
  const std::vector<Mover> movers = watch.Movers();
  ASSERT_EQ(movers.size(), 2u);
  for (const Mover& mover : movers) {
    EXPECT_LT(geometry::Norm(mover.velocity_mps - velocity_mps), 0.2);
    EXPECT_NEAR(mover.radius_m, 0.5, 0.1);
    EXPECT_LT(
        std::min(geometry::Norm(mover.in_map - watch.disc().center),
                 geometry::Norm(mover.in_map - watch.disc().center - to_other)),
        0.15);
  }
  EXPECT_GT(geometry::Norm(movers[0].in_map - movers[1].in_map), 0.6);
}

TEST(MoverTracker, WhatPassesBeforeAnotherDoesNotTakeItsTrack) {
  // The first one is hidden for a moment.
  Watch watch({0, 0}, {0, 0}, {.center = {3.8, -1.5}}, {0, 1.2});
  geometry::Vec2 other = {3.4, 1.8};
  for (double now_s = 0; now_s < 1.6; now_s += kScan_s) {
    watch.For_s(0.9 * kScan_s, {{.center = other}});
    other = other + kScan_s * geometry::Vec2{0, -1.2};
  }
  const std::vector<Mover> movers = watch.Movers();
  ASSERT_EQ(movers.size(), 2u);
  for (const Mover& mover : movers) {
    const bool is_other = mover.velocity_mps.y < 0;
    EXPECT_LT(
        geometry::Norm(mover.in_map - (is_other ? other : watch.disc().center)),
        0.2);
    EXPECT_NEAR(mover.velocity_mps.y, is_other ? -1.2 : 1.2, 0.25);
  }
}

TEST(MoverTracker, WhatStopsBecomesAPartOfTheMap) {
  Watch watch({0, 0}, {0, 0}, {.center = {4, -2}}, {0, 1});
  watch.For_s(1);
  ASSERT_EQ(watch.Movers().size(), 1u);
  watch.Stop();
  watch.For_s(1);
  EXPECT_TRUE(watch.Movers().empty());
  int on_map = 0;
  int on_disc = 0;
  for (const GridBeam& beam : watch.beams()) {
    if (geometry::Norm(beam.to - watch.disc().center) > 0.51) continue;
    ++on_disc;
    on_map += watch.map().At(watch.map().CellOf(beam.to)) ==
                      core::Occupancy::kOccupied
                  ? 1
                  : 0;
  }
  EXPECT_GT(on_disc, 20);
  EXPECT_EQ(on_map, on_disc);
}

TEST(MoverTracker, OutOfSightItGoesOnAndIsForgotten) {
  // To where the beams do not look: behind.
  Watch watch({0, 0}, {0, 0}, {.center = {-1, 3}}, {-1, 0});
  watch.For_s(1);
  ASSERT_EQ(watch.Movers().size(), 1u);
  watch.For_s(1.5);
  const std::vector<Mover> movers = watch.Movers();
  ASSERT_EQ(movers.size(), 1u);
  EXPECT_LT(geometry::Norm(movers[0].in_map - watch.disc().center), 0.3);
  watch.For_s(3);
  EXPECT_TRUE(watch.Movers().empty());
}

}  // namespace
}  // namespace treeline::mapless
