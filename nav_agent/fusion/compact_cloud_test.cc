#include "nav_agent/fusion/compact_cloud.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "gtest/gtest.h"
#include "nav_agent/fusion/testing_views.h"

namespace treeline::fusion {
namespace {

const camera::Camera kCamera;

geometry::Vec3 PointOf(const CompactCloud& cloud, size_t i) {
  const CompactPoint& point = cloud.points[i];
  return cloud.unit_m *
         geometry::Vec3{double(point.x), double(point.y), double(point.z)};
}

TEST(DepthCloud, CellsOfAWallAverageItsNoise) {
  base::Random random(1, 0);
  // The sensor's noise at 3 m is 14 mm.
  const image::DepthImage wall = MakeDepth(kCamera, [&random](double, double) {
    return 3 + 0.014 * random.NextGaussian();
  });
  const auto cloud = MakeDepthCloud(wall, kCamera, {.outlier_neighbors = 0});
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  // 4 x 4 pixels at 4 m are 27 mm, below 0.6 voxels of 50 mm.
  EXPECT_EQ(cloud->points.size(), size_t{160 * 120});
  EXPECT_EQ(cloud->hits, cloud->points.size());
  double squares = 0;
  for (size_t i = 0; i < cloud->hits; ++i) {
    squares += std::pow(PointOf(*cloud, i).z - 3, 2);
  }
  // 16 pixels: a quarter of the noise, and a little for the rounding.
  EXPECT_LT(std::sqrt(squares / static_cast<double>(cloud->hits)), 0.0045);
}

TEST(DepthCloud, PointsLieOnTheirRays) {
  const image::DepthImage slanted = MakeDepth(
      kCamera, [](double x, double y) { return 2 / (1 + 0.3 * x - 0.2 * y); });
  const auto cloud = MakeDepthCloud(slanted, kCamera, {});
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  ASSERT_GT(cloud->hits, size_t{18000});
  for (size_t i = 0; i < cloud->hits; ++i) {
    const geometry::Vec3 point = PointOf(*cloud, i);
    // The plane z + 0.3 x - 0.2 y = 2; half a millimetre of rounding each.
    EXPECT_NEAR(point.z + 0.3 * point.x - 0.2 * point.y, 2, 0.0015);
  }
}

TEST(DepthCloud, FlyingPixelsBetweenTwoSurfacesAreRemoved) {
  base::Random random(2, 0);
  // A near wall on the left, a far one on the right, and between them a column
  // of 12 pixels that measured anything in between.
  const auto depth_m = [&random](double x, double) {
    if (x < -0.01) return 1.5;
    if (x > 0.01) return 3.5;
    return random.NextUniform(1.6, 3.4);
  };
  const auto cloud = MakeDepthCloud(MakeDepth(kCamera, depth_m), kCamera, {});
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  size_t flying = 0;
  for (size_t i = 0; i < cloud->hits; ++i) {
    const double z_m = PointOf(*cloud, i).z;
    if (std::abs(z_m - 1.5) > 0.03 && std::abs(z_m - 3.5) > 0.03) ++flying;
  }
  // Of 360 cells, few find neighbours by chance.
  EXPECT_LT(flying, size_t{40});
  EXPECT_GT(cloud->hits, size_t{160 * 120 - 4 * 120 - 300});
}

TEST(DepthCloud, AFloorSeenAtAGrazingAngleKeepsItsPointsAndGetsMore) {
  // The camera is 1.1 m above the floor and looks level.
  const image::DepthImage floor = MakeDepth(
      kCamera, [](double, double y) { return y > 0.01 ? 1.1 / y : 0; });
  const auto cloud = MakeDepthCloud(floor, kCamera, {.max_depth_m = 4});
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  // In each row of voxels from 2.8 m (the image's lower border) to 4 m, every
  // voxel ahead has a point.
  std::vector<int> counts(24);
  for (size_t i = 0; i < cloud->hits; ++i) {
    const geometry::Vec3 point = PointOf(*cloud, i);
    if (std::abs(point.x) > 0.5) continue;
    const int row = static_cast<int>((point.z - 2.8) / 0.05);
    if (row >= 0 && row < 24) ++counts[static_cast<size_t>(row)];
  }
  for (int row = 0; row < 24; ++row) {
    EXPECT_GE(counts[static_cast<size_t>(row)], 20) << "row " << row;
  }
}

TEST(DepthCloud, WhatIsFurtherThanTheRangeIsNoHit) {
  const image::DepthImage wall =
      MakeDepth(kCamera, [](double, double) { return 6; });
  const auto cloud = MakeDepthCloud(wall, kCamera, {});
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  EXPECT_EQ(cloud->hits, size_t{0});
  ASSERT_EQ(cloud->points.size(), size_t{160 * 120});
  for (size_t i = 0; i < cloud->points.size(); ++i) {
    EXPECT_NEAR(PointOf(*cloud, i).z, 4, 0.0005);
  }
}

TEST(DepthCloud, AnImageWithoutDepthGivesAnEmptyCloud) {
  image::DepthImage image =
      MakeDepth(kCamera, [](double, double) { return 0; });
  EXPECT_TRUE(MakeDepthCloud(image, kCamera, {})->points.empty());
  std::fill(image.values.begin(), image.values.end(), uint16_t{65535});
  EXPECT_TRUE(MakeDepthCloud(image, kCamera, {})->points.empty());
}

TEST(DepthCloud, ImagesThatDoNotFitTheirCameraAreRefused) {
  image::DepthImage image =
      MakeDepth(kCamera, [](double, double) { return 1; });
  image.unit_m = 0;
  EXPECT_EQ(MakeDepthCloud(image, kCamera, {}).status().code(),
            absl::StatusCode::kInvalidArgument);
  image.unit_m = 0.001;
  image.values.pop_back();
  EXPECT_EQ(MakeDepthCloud(image, kCamera, {}).status().code(),
            absl::StatusCode::kInvalidArgument);
  image.width = 320;
  EXPECT_EQ(MakeDepthCloud(image, kCamera, {}).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(DepthCloud, DistortedCamerasAreUndone) {
  const camera::Camera camera =
      *camera::Camera::Parse("SIMPLE_RADIAL,585,320,240,0.1", 640, 480);
  const image::DepthImage wall =
      MakeDepth(camera, [](double, double) { return 2; });
  const auto cloud = MakeDepthCloud(wall, camera, {});
  ASSERT_TRUE(cloud.ok()) << cloud.status();
  // The cell whose middle is pixel (1.5, 1.5).
  const camera::Pixel ray = *camera.Unproject({1.5, 1.5});
  EXPECT_NEAR(PointOf(*cloud, 0).x, 2 * ray.x, 0.001);
  EXPECT_NEAR(PointOf(*cloud, 0).y, 2 * ray.y, 0.001);
}

TEST(PointCloud, PointsThatAreNotFiniteAreLeftOut) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const std::vector<geometry::Vec3> points = {
      {nan, 0, 0}, {1, 2, 3}, {infinity, 0, 0}, {0, 0, 1e300}, {100, 0, 0}};
  const CompactCloud cloud = MakePointCloud(points, {});
  ASSERT_EQ(cloud.points.size(), size_t{2});
  EXPECT_EQ(cloud.hits, size_t{1});
  EXPECT_NEAR(geometry::Norm(PointOf(cloud, 0) - geometry::Vec3{1, 2, 3}), 0,
              0.0005);
  EXPECT_NEAR(geometry::Norm(PointOf(cloud, 1) - geometry::Vec3{10, 0, 0}), 0,
              0.0005);
}

}  // namespace
}  // namespace treeline::fusion
