#include "nav_agent/map_bundle/upright.h"

#include <vector>

#include "common/base/random.h"
#include "gtest/gtest.h"

namespace treeline::map_bundle {
namespace {

// A room's floor, a wall and a table, with noise of 5 mm; then tilted.
std::vector<geometry::Vec3> Room(const geometry::Rigid3& map_from_level,
                                 bool with_floor) {
  base::Random random(1, 0);
  std::vector<geometry::Vec3> points;
  const auto add = [&](geometry::Vec3 point) {
    point.z += 0.005 * random.NextGaussian();
    points.push_back(map_from_level * point);
  };
  for (int i = 0; i < 3000; ++i) {
    const double x = random.NextUniform(0, 4);
    const double y = random.NextUniform(0, 3);
    if (with_floor) add({x, y, 0});
    add({x, 3, random.NextUniform(0, 2.5)});
    if (i % 3 == 0) add({0.3 * x, 0.3 * y, 0.74});
  }
  return points;
}

const geometry::Rigid3 kMapFromLevel{
    geometry::Rotation3::FromAxisAngle({-1.2, 0.3, 0.1}), {0.3, -0.4, 1.1}};

TEST(UprightTest, TheFloorIsLevelAndAtZero) {
  const geometry::Vec3 guess =
      kMapFromLevel.rotation *
      geometry::Rotation3::FromAxisAngle({0.3, 0.1, 0}) *
      geometry::Vec3{0, 0, 2};
  const UprightMap upright =
      FindUpright(Room(kMapFromLevel, /*with_floor=*/true), guess, 7);
  EXPECT_TRUE(upright.has_surface);
  EXPECT_GT(upright.share, 0.3);
  const geometry::Rigid3 level_from_true =
      upright.level_from_map * kMapFromLevel;
  // 3000 points of 5 mm on 4 x 3 m: a tenth of a milliradian.
  EXPECT_LT(geometry::Norm(level_from_true.rotation * geometry::Vec3{0, 0, 1} -
                           geometry::Vec3{0, 0, 1}),
            1e-3);
  EXPECT_NEAR((level_from_true * geometry::Vec3{2, 1.5, 0}).z, 0, 2e-3);
}

TEST(UprightTest, ATableIsNoFloor) {
  const UprightMap upright =
      FindUpright(Room(kMapFromLevel, /*with_floor=*/false),
                  kMapFromLevel.rotation * geometry::Vec3{0, 0, 1}, 7);
  EXPECT_TRUE(upright.has_surface);
  const geometry::Rigid3 level_from_true =
      upright.level_from_map * kMapFromLevel;
  EXPECT_LT(geometry::Norm(level_from_true.rotation * geometry::Vec3{0, 0, 1} -
                           geometry::Vec3{0, 0, 1}),
            5e-3);
  // The wall reaches down to the floor.
  EXPECT_NEAR((level_from_true * geometry::Vec3{2, 1.5, 0}).z, 0, 0.1);
}

TEST(UprightTest, WithoutPointsTheGuessIsBelieved) {
  const UprightMap upright = FindUpright({}, {0, -3, 0}, 0);
  EXPECT_FALSE(upright.has_surface);
  EXPECT_LT(geometry::Norm(upright.level_from_map * geometry::Vec3{0, -1, 0} -
                           geometry::Vec3{0, 0, 1}),
            1e-12);
  // Upside down, and no guess at all.
  EXPECT_LT(geometry::Norm(FindUpright({}, {0, 0, -1}, 0).level_from_map *
                               geometry::Vec3{0, 0, -1} -
                           geometry::Vec3{0, 0, 1}),
            1e-12);
  EXPECT_EQ(FindUpright({}, {}, 0).level_from_map * (geometry::Vec3{1, 2, 3}),
            (geometry::Vec3{1, 2, 3}));
}

}  // namespace
}  // namespace treeline::map_bundle
