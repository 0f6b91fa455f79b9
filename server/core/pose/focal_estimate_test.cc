#include "server/core/pose/focal_estimate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "common/base/random.h"

namespace treeline::pose {
namespace {

constexpr double kFocal_px = 500;

// Points in front of a camera at the origin, and their rays as a camera states
// them whose true focal length is `scale` times the stated one, with `noise_px`
// on each; of every `outlier_every` one is anywhere.
RayPredictions Seen(double scale, double noise_px, double nearest_m,
                    double farthest_m, int outlier_every = 0) {
  base::Random random(7, 1);
  RayPredictions scene;
  for (int i = 0; i < 200; ++i) {
    const double z = random.NextUniform(nearest_m, farthest_m);
    const geometry::Vec3 point{z * random.NextUniform(-0.6, 0.6),
                               z * random.NextUniform(-0.45, 0.45), z};
    const bool is_outlier = outlier_every > 0 && i % outlier_every == 0;
    const auto image = [&](double at) {
      return scale * (at + (is_outlier ? random.NextUniform(-0.5, 0.5) : 0) +
                      noise_px / kFocal_px * random.NextGaussian());
    };
    scene.ray.push_back({image(point.x / z), image(point.y / z)});
    scene.ray_sigma.push_back(1 / kFocal_px);
    scene.predictions.push_back({point, {1e-6, 0, 0, 1e-6, 0, 1e-6}});
  }
  return scene;
}

std::optional<FocalEstimate> Estimate(const RayPredictions& scene) {
  // Where a pose alone would be drawn to.
  const geometry::Rigid3 near{
      geometry::Rotation3::FromAxisAngle({0.01, -0.005, 0.01}),
      {0.03, -0.02, 0.1}};
  return EstimateFocal(scene, near, 3 / kFocal_px);
}

TEST(FocalEstimate, FindsTheFocalLengthThatRaysWereMadeWith) {
  for (const double scale : {0.8, 0.95, 1.0, 1.05, 1.2}) {
    const auto estimate = Estimate(Seen(scale, 0, 1, 4));
    ASSERT_TRUE(estimate.has_value()) << scale;
    EXPECT_NEAR(estimate->scale, scale, 1e-4);
  }
}

TEST(FocalEstimate, SaysHowWellItIsKnown) {
  const auto deep = Estimate(Seen(1.05, 1, 1, 4));
  const auto shallow = Estimate(Seen(1.05, 1, 2.9, 3.1));
  ASSERT_TRUE(deep.has_value() && shallow.has_value());
  EXPECT_LT(std::abs(std::log(deep->scale / 1.05)), 4 * deep->sigma);
  EXPECT_LT(deep->sigma, 0.005);
  EXPECT_GT(shallow->sigma, 5 * deep->sigma);
}

// Along the line of sight, as much of the distance.
TEST(FocalEstimate, SaysWhatThatDoesToThePosition) {
  const auto shallow = Estimate(Seen(1, 1, 2.9, 3.1));
  ASSERT_TRUE(shallow.has_value());
  EXPECT_NEAR(std::sqrt(shallow->added[14]), 3 * shallow->sigma,
              0.1 * 3 * shallow->sigma);
  EXPECT_LT(shallow->added[0], 0.1 * shallow->added[14]);
}

TEST(FocalEstimate, HoldsOutAgainstWrongMatches) {
  const auto estimate = Estimate(Seen(1.08, 0.5, 1, 4, /*outlier_every=*/4));
  ASSERT_TRUE(estimate.has_value());
  EXPECT_NEAR(estimate->scale, 1.08, 0.01);
}

TEST(FocalEstimate, AWallInFrontSaysNothing) {
  const auto estimate = Estimate(Seen(1.05, 1, 3, 3));
  EXPECT_TRUE(!estimate || estimate->sigma > 0.02) << estimate->sigma;
}

constexpr LensPrior kAnyLens = {.offset = 0.2, .radial = 0.15};

// Rays of a lens, as a pinhole camera without its lens takes them.
RayPredictions SeenThrough(geometry::Vec3 lens, double noise_px,
                           double nearest_m, double farthest_m) {
  RayPredictions scene = Seen(1, noise_px, nearest_m, farthest_m);
  for (camera::Pixel& ray : scene.ray) {
    const double bent = 1 + lens.z * (ray.x * ray.x + ray.y * ray.y);
    ray = {1.1 * bent * ray.x + lens.x, 1.1 * bent * ray.y + lens.y};
  }
  return scene;
}

std::optional<LensEstimate> EstimateNear(const RayPredictions& scene) {
  return EstimateLens(scene, {}, 3 / kFocal_px, kAnyLens);
}

TEST(EstimateLens, FindsWhatRaysWereMadeWith) {
  for (const geometry::Vec3 lens :
       {geometry::Vec3{0, 0, 0}, geometry::Vec3{0.1, -0.05, 0},
        geometry::Vec3{0, 0, -0.2}, geometry::Vec3{-0.08, 0.02, 0.15}}) {
    const auto estimate = EstimateNear(SeenThrough(lens, 0, 1, 4));
    ASSERT_TRUE(estimate.has_value());
    EXPECT_NEAR(estimate->focal.scale, 1.1, 1e-3);
    EXPECT_NEAR(estimate->offset_x, lens.x, 1e-3);
    EXPECT_NEAR(estimate->offset_y, lens.y, 1e-3);
    EXPECT_NEAR(estimate->radial, lens.z, 1e-3);
  }
}

TEST(EstimateLens, SaysHowWellItIsKnown) {
  const auto deep = EstimateNear(SeenThrough({0.1, 0, -0.1}, 1, 1, 4));
  const auto shallow = EstimateNear(SeenThrough({0.1, 0, -0.1}, 1, 2.9, 3.1));
  ASSERT_TRUE(deep.has_value() && shallow.has_value());
  const auto sigma = [](const LensEstimate& of, size_t i) {
    return std::sqrt(of.covariance[4 * i]);
  };
  EXPECT_LT(std::abs(deep->offset_x - 0.1), 3 * sigma(*deep, 0));
  EXPECT_LT(std::abs(deep->radial + 0.1), 3 * sigma(*deep, 2));
  EXPECT_LT(sigma(*deep, 0), 0.03);
  EXPECT_LT(sigma(*deep, 2), 0.03);
  EXPECT_GT(sigma(*shallow, 0), 2 * sigma(*deep, 0));
  // Position, along the axis and across it.
  for (const size_t i : {0U, 7U, 14U}) {
    EXPECT_GT(deep->added[i], 0);
    EXPECT_GT(shallow->added[i], 4 * deep->added[i]);
  }
}

TEST(EstimateLens, WhatItAddsToAPoseIsOfTheWorldsAxes) {
  const RayPredictions scene = SeenThrough({0.1, 0, -0.1}, 1, 1, 4);
  // The world's y is the camera's x.
  const geometry::Rigid3 world_from_camera{
      geometry::Rotation3::FromAxisAngle({0, 0, std::acos(0.0)}), {1, 2, 3}};
  RayPredictions elsewhere = scene;
  for (ScenePrediction& prediction : elsewhere.predictions) {
    prediction.mean_in_world = world_from_camera * prediction.mean_in_world;
  }
  const auto here = EstimateNear(scene);
  const auto there =
      EstimateLens(elsewhere, world_from_camera, 3 / kFocal_px, kAnyLens);
  ASSERT_TRUE(here.has_value() && there.has_value());
  EXPECT_NEAR(there->added[7] / here->added[0], 1, 1e-6);
  EXPECT_NEAR(there->added[0] / here->added[7], 1, 1e-6);
  EXPECT_NEAR(there->added[14] / here->added[14], 1, 1e-6);
}

// The same points, measured by a depth camera whose true focal length is
// `scale` times the stated one, and whose true depth is `depth_scale` times
// what it measures; of every `outlier_every` one the prediction is anywhere.
PointPredictions Measured(double scale, double depth_scale, double noise_m,
                          int outlier_every = 0) {
  base::Random random(11, 1);
  PointPredictions scene;
  for (int i = 0; i < 200; ++i) {
    const double z = random.NextUniform(1, 3);
    const geometry::Vec3 point{z * random.NextUniform(-0.6, 0.6),
                               z * random.NextUniform(-0.45, 0.45), z};
    geometry::Vec3 predicted = point;
    const double reach =
        outlier_every > 0 && i % outlier_every == 0 ? 1.5 : noise_m;
    predicted.x += reach * random.NextGaussian();
    predicted.y += reach * random.NextGaussian();
    predicted.z += reach * random.NextGaussian();
    scene.point_in_camera.push_back({point.x * scale / depth_scale,
                                     point.y * scale / depth_scale,
                                     point.z / depth_scale});
    scene.depth_sigma_m.push_back(0.005);
    scene.predictions.push_back({predicted, {1e-4, 0, 0, 1e-4, 0, 1e-4}});
  }
  return scene;
}

TEST(FocalOfPoints, IsFoundFromWhereTheyAreToBe) {
  for (const double scale : {0.9, 0.95, 1.0, 1.05, 1.1}) {
    const auto estimate = EstimateFocal(Measured(scale, 1, 0.01), {});
    ASSERT_TRUE(estimate.has_value()) << scale;
    EXPECT_NEAR(estimate->scale, scale, 0.01);
    EXPECT_LT(std::abs(std::log(estimate->scale / scale)), 2 * estimate->sigma);
    EXPECT_LT(estimate->sigma, 0.02);
  }
}

TEST(FocalOfPoints, HoldsOutAgainstWrongPredictions) {
  const auto estimate = EstimateFocal(Measured(1.05, 1, 0.01, 2), {});
  ASSERT_TRUE(estimate.has_value());
  EXPECT_NEAR(estimate->scale, 1.05, 0.015);
}

TEST(FocalOfPoints, DepthOfAnotherScaleIsNoOtherFocalLength) {
  const auto estimate = EstimateFocal(Measured(1, 1.015, 0.005), {});
  ASSERT_TRUE(estimate.has_value());
  EXPECT_NEAR(estimate->scale, 1, 0.01);
}

TEST(FocalOfPoints, TooFewSayNothing) {
  PointPredictions scene = Measured(1.05, 1, 0.01);
  scene.point_in_camera.resize(2);
  EXPECT_FALSE(EstimateFocal(scene, {}).has_value());
}

}  // namespace
}  // namespace treeline::pose
