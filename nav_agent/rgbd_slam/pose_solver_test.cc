#include "nav_agent/rgbd_slam/pose_solver.h"

#include <vector>

#include "common/base/random.h"
#include "gtest/gtest.h"

namespace treeline::rgbd_slam {
namespace {

const Pinhole kPinhole = {.fx = 500, .fy = 500, .cx = 320, .cy = 240};
constexpr geometry::Rigid3 kNothing;

geometry::Rigid3 TrueCameraFromMap() {
  return {.rotation = geometry::Rotation3::FromAxisAngle({0.2, -0.5, 0.1}),
          .translation = {0.3, -0.2, 0.5}};
}

// Points seen with noise of 1 px and of the depth's deviation; the first
// `wrong` of them are of some other point.
std::vector<PointSighting> Sightings(int count, int wrong, uint64_t seed) {
  std::vector<PointSighting> sightings;
  const geometry::Rigid3 map_from_camera = TrueCameraFromMap().Inverse();
  base::Random random(seed, 1);
  for (int i = 0; i < count; ++i) {
    const camera::Pixel pixel{random.NextUniform(0, 640),
                              random.NextUniform(0, 480)};
    const double depth_m = random.NextUniform(0.8, 4);
    PointSighting sighting{
        .point_in_map = map_from_camera * kPinhole.PointAt(pixel, depth_m),
        .pixel = {pixel.x + random.NextGaussian(),
                  pixel.y + random.NextGaussian()},
        .depth_m =
            depth_m + FeatureDepthSigma_m(depth_m) * random.NextGaussian()};
    if (i % 3 == 2) sighting.depth_m = 0;
    if (i < wrong) {
      sighting.pixel = {random.NextUniform(0, 640), random.NextUniform(0, 480)};
    }
    sightings.push_back(sighting);
  }
  return sightings;
}

TEST(SolvePose, FindsThePoseFromNearby) {
  const geometry::Rigid3 start =
      geometry::Rigid3{
          .rotation = geometry::Rotation3::FromAxisAngle({0.05, 0, 0}),
          .translation = {0.05, 0.02, -0.04}} *
      TrueCameraFromMap();
  const SolvedPose solved = SolvePose(Sightings(200, 40, 1), kPinhole, start);
  const geometry::PoseError error =
      geometry::ErrorBetween(solved.camera_from_map, TrueCameraFromMap());
  // 160 sightings of 1 px at 500 px and about 2 m: 4 mm / sqrt(160), and some
  // for the geometry; a turn of a pixel.
  EXPECT_LT(error.translation_m, 0.003);
  EXPECT_LT(error.rotation_rad, 0.002);
  // 5 % of the right ones are beyond the bound; of the wrong next to none is
  // within.
  EXPECT_GT(solved.inliers, 140);
  EXPECT_LT(solved.inliers, 162);
}

TEST(SolvePose, TakesFewSightingsForNothing) {
  const SolvedPose solved =
      SolvePose(Sightings(5, 0, 2), kPinhole, TrueCameraFromMap());
  EXPECT_EQ(solved.inliers, 0);
  EXPECT_EQ(solved.camera_from_map, TrueCameraFromMap());
}

TEST(FindPose, FindsThePoseAmongMostlyWrongSightings) {
  const std::vector<PointSighting> sightings = Sightings(150, 100, 3);
  const auto solved = FindPose(sightings, kPinhole, 30, 7, 1);
  ASSERT_TRUE(solved);
  EXPECT_LT(geometry::ErrorBetween(solved->camera_from_map, TrueCameraFromMap())
                .translation_m,
            0.006);
  EXPECT_GE(solved->inliers, 40);
  // The same draws, the same answer.
  const auto again = FindPose(sightings, kPinhole, 30, 7, 1);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->camera_from_map, solved->camera_from_map);
}

TEST(FindPose, FindsNothingInNoise) {
  EXPECT_FALSE(FindPose(Sightings(150, 150, 4), kPinhole, 20, 7, 1));
  EXPECT_FALSE(FindPose({}, kPinhole, 20, 7, 1));
}

TEST(SquaredError, IsInfiniteBehindTheCamera) {
  EXPECT_FALSE(IsExplained(
      {.point_in_map = {0, 0, -1}, .pixel = {320, 240}, .depth_m = 0}, kPinhole,
      kNothing));
  EXPECT_TRUE(IsExplained(
      {.point_in_map = {0, 0, 1}, .pixel = {320, 240}, .depth_m = 1}, kPinhole,
      kNothing));
}

}  // namespace
}  // namespace treeline::rgbd_slam
