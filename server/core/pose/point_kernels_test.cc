#include "server/core/pose/point_kernels.h"

#include <algorithm>

#include "common/base/random.h"
#include "common/base/testing_vector_targets.h"
#include "gtest/gtest.h"

namespace treeline::pose {
namespace {

constexpr double kInlier_m = 0.1;

double Uniform(base::Random& random, double size) {
  return size * (2.0 * random.NextBelow(1u << 30) / (1u << 30) - 1);
}

geometry::Vec3 SomePoint(base::Random& random, double size) {
  return {Uniform(random, size), Uniform(random, size), Uniform(random, size)};
}

// Half of the points within some centimetres of where the pose takes them, the
// others anywhere; the world's origin 300 m away.
struct Scene {
  geometry::Rigid3 world_from_camera;
  std::vector<geometry::Vec3> camera;
  std::vector<geometry::Vec3> world;
  PackedPairs pairs;

  explicit Scene(size_t points) {
    base::Random random(5, 0);
    world_from_camera = {
        geometry::Rotation3::FromAxisAngle(SomePoint(random, 1)),
        {300, -200, 10}};
    for (size_t i = 0; i < points; ++i) {
      camera.push_back(SomePoint(random, 3));
      world.push_back(world_from_camera * camera.back() +
                      SomePoint(random, i % 2 == 0 ? 0.04 : 2));
      pairs.Add(camera.back(), world.back());
    }
    pairs.Pad();
  }

  double SquaredDistance(size_t i) const {
    return geometry::SquaredNorm(world_from_camera * camera[i] - world[i]);
  }
};

TEST(PointKernelsTest, CostIsTheSumOfTruncatedSquares) {
  const Scene scene(77);
  base::WithEachVectorTarget([&] {
    for (const size_t begin : {0u, 3u, 60u}) {
      for (const size_t end : {60u, 61u, 77u}) {
        double expected = 0;
        for (size_t i = begin; i < end; ++i) {
          expected +=
              std::min(1.0, scene.SquaredDistance(i) / (kInlier_m * kInlier_m));
        }
        // Coordinates of 300 m are rounded to 3e-5 m: up to 6e-4 inlier
        // distances.
        EXPECT_NEAR(TruncatedDistances(scene.pairs, begin, end,
                                       scene.world_from_camera, kInlier_m),
                    expected, 6e-4 * 77)
            << begin << " to " << end;
      }
    }
  });
}

TEST(PointKernelsTest, SumsAreThoseOfTheInliers) {
  const Scene scene(77);
  base::WithEachVectorTarget([&] {
    for (const size_t end : {3u, 16u, 33u, 77u}) {
      geometry::Kabsch kabsch;
      int inliers = 0;
      for (size_t i = 0; i < end; ++i) {
        if (scene.SquaredDistance(i) > kInlier_m * kInlier_m) continue;
        kabsch.Add(scene.world[i], scene.camera[i]);
        ++inliers;
      }
      const geometry::CorrespondenceSums sums =
          SumInliers(scene.pairs, end, scene.world_from_camera, kInlier_m);
      EXPECT_EQ(sums.count, inliers) << end;
      const auto expected = kabsch.Solve();
      const auto found = geometry::SolveKabsch(sums);
      ASSERT_EQ(found.has_value(), expected.has_value()) << end;
      if (!expected) continue;
      const geometry::PoseError error =
          geometry::ErrorBetween(*found, *expected);
      // As above, and two points far apart hold the pose.
      EXPECT_LT(error.translation_m, 1e-4) << end;
      EXPECT_LT(error.rotation_rad, 1e-4) << end;
    }
  });
}

TEST(PointKernelsTest, NoPointsGiveNothing) {
  const Scene scene(0);
  EXPECT_EQ(TruncatedDistances(scene.pairs, 0, 0, {}, kInlier_m), 0);
  EXPECT_EQ(SumInliers(scene.pairs, 0, {}, kInlier_m).count, 0);
}

}  // namespace
}  // namespace treeline::pose
