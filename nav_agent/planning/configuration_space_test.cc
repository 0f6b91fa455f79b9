#include "nav_agent/planning/configuration_space.h"

#include <cmath>
#include <numbers>

#include "common/base/random.h"
#include "gmock/gmock.h"
#include "nav_agent/planning/testing_maps.h"

namespace treeline::planning {
namespace {

constexpr int kSide = 60;

// A field of single blocked cells.
std::shared_ptr<const GroundIndex> Field(uint64_t seed) {
  std::vector<std::string> rows(kSide, std::string(kSide, '.'));
  base::Random random(seed, 0);
  for (int i = 0; i < 40; ++i) {
    rows[random.NextBelow(kSide)][random.NextBelow(kSide)] = '#';
  }
  return std::make_shared<const GroundIndex>(DrawnMap(rows, 1));
}

// Whether two convex polygons have area in common, by separating axes.
bool Overlap(const std::vector<geometry::Vec2>& a,
             const std::vector<geometry::Vec2>& b) {
  for (const auto* shape : {&a, &b}) {
    for (size_t i = 0; i < shape->size(); ++i) {
      const geometry::Vec2 side =
          (*shape)[(i + 1) % shape->size()] - (*shape)[i];
      const geometry::Vec2 axis = {-side.y, side.x};
      double a_low = 1e9, a_high = -1e9, b_low = 1e9, b_high = -1e9;
      for (const geometry::Vec2& p : a) {
        a_low = std::min(a_low, geometry::Dot(p, axis));
        a_high = std::max(a_high, geometry::Dot(p, axis));
      }
      for (const geometry::Vec2& p : b) {
        b_low = std::min(b_low, geometry::Dot(p, axis));
        b_high = std::max(b_high, geometry::Dot(p, axis));
      }
      const double touch = 1e-6 * geometry::Norm(axis);
      if (a_high <= b_low + touch || b_high <= a_low + touch) return false;
    }
  }
  return true;
}

bool BoxIsFreeBySquares(const GroundIndex& ground, const OrientedBox& box) {
  std::vector<geometry::Vec2> corners;
  for (const geometry::Vec2& corner :
       {geometry::Vec2{box.back_m, -box.half_width_m},
        geometry::Vec2{box.front_m, -box.half_width_m},
        geometry::Vec2{box.front_m, box.half_width_m},
        geometry::Vec2{box.back_m, box.half_width_m}}) {
    corners.push_back(
        box.origin +
        geometry::Vec2{box.cos_yaw * corner.x - box.sin_yaw * corner.y,
                       box.sin_yaw * corner.x + box.cos_yaw * corner.y});
  }
  const double r = ground.resolution_m();
  // Two rings of cells around the map are blocked, too.
  for (int y = -2; y < kSide + 2; ++y) {
    for (int x = -2; x < kSide + 2; ++x) {
      if (ground.Clearance_m(0, {x, y}) > 0) continue;
      if (Overlap(corners, {{r * x, r * y},
                            {r * (x + 1), r * y},
                            {r * (x + 1), r * (y + 1)},
                            {r * x, r * (y + 1)}})) {
        return false;
      }
    }
  }
  return true;
}

TEST(DriveSpaceTest, BoxesAreFreeExactlyWhereTheyCoverNoBlockedSquare) {
  int free = 0;
  for (uint64_t seed = 0; seed < 10; ++seed) {
    const auto ground = Field(seed);
    for (uint64_t i = 0; i < 300; ++i) {
      base::Random random(seed, 100 + i);
      // A third lie along the axes, and some on borders of cells.
      const double yaw_rad = i % 3 == 0
                                 ? std::numbers::pi / 2 * random.NextBelow(4)
                                 : random.NextUniform(-4, 4);
      geometry::Vec2 origin = {random.NextUniform(0.2, 2.8),
                               random.NextUniform(0.2, 2.8)};
      if (i % 6 == 0) {
        origin = {0.05 * std::round(origin.x / 0.05),
                  0.05 * std::round(origin.y / 0.05)};
      }
      const OrientedBox box = {.origin = origin,
                               .cos_yaw = std::cos(yaw_rad),
                               .sin_yaw = std::sin(yaw_rad),
                               .back_m = -0.15,
                               .front_m = random.NextUniform(0.0, 0.5),
                               .half_width_m = 0.1};
      const bool is_free = ground->IsFree(0, box);
      ASSERT_EQ(is_free, BoxIsFreeBySquares(*ground, box))
          << "seed " << seed << ", box " << i;
      free += is_free ? 1 : 0;
    }
  }
  EXPECT_GT(free, 300);
  EXPECT_LT(free, 2700);
}

ConfigurationSpace SpaceOf(const std::vector<std::string>& rows,
                           std::vector<Disc> discs = {}) {
  return ConfigurationSpace(std::make_shared<const GroundIndex>(DrawnMap(rows)),
                            Footprint::Of(core::RobotModel(), 0),
                            std::move(discs));
}

TEST(DriveSpaceTest, TurnsWhereCornersHaveRoom) {
  // A corridor of 0.8 m; the footprint's corners reach 0.431 m.
  const ConfigurationSpace narrow = SpaceOf(RoomRows(60, 10));
  EXPECT_TRUE(narrow.Fits({{3, 0.5}, 0}, 0));
  EXPECT_FALSE(narrow.CanTurn({{3, 0.5}, 0}, 0, std::numbers::pi / 2));
  EXPECT_TRUE(narrow.CanTurn({{3, 0.5}, 0}, 0, 0.1));
  EXPECT_FALSE(narrow.FitsTurning({{3, 0.5}, 0}));
  const ConfigurationSpace wide = SpaceOf(RoomRows(60, 11));
  EXPECT_TRUE(wide.CanTurn({{3, 0.55}, 0}, 0, std::numbers::pi / 2));
  EXPECT_TRUE(wide.FitsTurning({{3, 0.55}, 0}));
}

// Between the headings that are looked at boxes are grown, beyond the disc that
// the corners sweep: where that disc is free, they do not count.
TEST(DriveSpaceTest, TurnsWhereTheSweptDiscJustFits) {
  const ConfigurationSpace space = SpaceOf(RoomRows(60, 11));
  const double radius_m = space.footprint().circumradius_m;
  const Spot just = {{3, 1.0 - radius_m - 0.001}, 0};
  ASSERT_TRUE(space.FitsTurning(just));
  EXPECT_TRUE(space.CanTurn(just, 0, std::numbers::pi));
  const Spot hardly = {{3, 1.0 - radius_m + 0.005}, 0};
  EXPECT_FALSE(space.FitsTurning(hardly));
  EXPECT_FALSE(space.CanTurn(hardly, 0, std::numbers::pi));
}

TEST(DriveSpaceTest, DrivesAreSweptWithoutGaps) {
  std::vector<std::string> rows = RoomRows(60, 30);
  // One square of 0.1 m.
  Fill(rows, 30, 31, 15, 16, '#');
  const ConfigurationSpace space = SpaceOf(rows);
  EXPECT_TRUE(space.Fits({{2.0, 1.5}, 0}, 0));
  EXPECT_TRUE(space.Fits({{4.0, 1.5}, 0}, 0));
  EXPECT_FALSE(space.Drive({{2.0, 1.5}, 0}, {4.0, 1.5}).has_value());
  // The side passes it by 1 mm, or hits it by 1 mm.
  const double beside_m = 1.5 - core::RobotModel().half_width_m;
  EXPECT_TRUE(space.Drive({{2.0, beside_m - 0.001}, 0}, {4.0, beside_m - 0.001})
                  .has_value());
  EXPECT_FALSE(
      space.Drive({{2.0, beside_m + 0.001}, 0}, {4.0, beside_m + 0.001})
          .has_value());
}

TEST(DriveSpaceTest, DiscsAreKeptOutOfExactly) {
  const ConfigurationSpace space = SpaceOf(
      RoomRows(60, 40), {{.center = {3, 2}, .radius_m = 0.2, .level = 0}});
  const double front_m = 3 - 0.2 - core::RobotModel().front_m;
  EXPECT_TRUE(space.Fits({{front_m - 0.001, 2}, 0}, 0));
  EXPECT_FALSE(space.Fits({{front_m + 0.001, 2}, 0}, 0));
}

TEST(DriveSpaceTest, RoomIsNeverOverestimated) {
  const auto ground = Field(3);
  const ConfigurationSpace space(ground, Footprint::Of(core::RobotModel(), 0),
                                 {});
  for (uint64_t i = 0; i < 2000; ++i) {
    base::Random random(7, i);
    const geometry::Vec2 at = {random.NextUniform(0, 3),
                               random.NextUniform(0, 3)};
    const double room_m = space.RoomAtLeast_m({at, 0});
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        if (ground->Clearance_m(0, {x, y}) > 0) continue;
        const geometry::Vec2 nearest = {
            std::clamp(at.x, 0.05 * x, 0.05 * (x + 1)),
            std::clamp(at.y, 0.05 * y, 0.05 * (y + 1))};
        ASSERT_GE(geometry::Norm(at - nearest), room_m - 1e-6);
      }
    }
  }
}

}  // namespace
}  // namespace treeline::planning
