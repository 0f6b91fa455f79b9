// Kabsch, RANSAC on points and refinement against poses that are known.
#include <cmath>

#include "Eigen/Cholesky"
#include "Eigen/Core"
#include "common/base/random.h"
#include "common/geometry/kabsch.h"
#include "gtest/gtest.h"
#include "server/core/pose/point_refinement.h"
#include "server/core/pose/point_solver.h"
#include "server/core/pose/preemptive_ransac.h"

namespace treeline::pose {
namespace {

geometry::Vec3 RandomVector(base::Random& random, double scale) {
  return {random.NextUniform(-scale, scale), random.NextUniform(-scale, scale),
          random.NextUniform(-scale, scale)};
}

geometry::Vec3 Noise(base::Random& random, double sigma) {
  return {sigma * random.NextGaussian(), sigma * random.NextGaussian(),
          sigma * random.NextGaussian()};
}

geometry::Rigid3 RandomPose(base::Random& random) {
  return {geometry::Rotation3::FromAxisAngle(RandomVector(random, 1.8)),
          RandomVector(random, 3)};
}

TEST(KabschTest, RecoversAnExactTransform) {
  base::Random random(1, 0);
  for (int trial = 0; trial < 100; ++trial) {
    const geometry::Rigid3 truth = RandomPose(random);
    geometry::Kabsch kabsch;
    for (int i = 0; i < 3 + trial % 5; ++i) {
      const geometry::Vec3 b = RandomVector(random, 2);
      kabsch.Add(truth * b, b, random.NextUniform(0.5, 2));
    }
    const auto solved = kabsch.Solve();
    ASSERT_TRUE(solved.has_value());
    const geometry::PoseError error = geometry::ErrorBetween(*solved, truth);
    EXPECT_LT(error.translation_m, 1e-9);
    EXPECT_LT(error.rotation_rad, 1e-9);
  }
}

TEST(KabschTest, NeverReflects) {
  // Points in a plane with noise out of it: a reflection would fit better.
  base::Random random(2, 0);
  geometry::Kabsch kabsch;
  for (int i = 0; i < 20; ++i) {
    const geometry::Vec3 b{random.NextUniform(-1, 1), random.NextUniform(-1, 1),
                           0.01 * random.NextGaussian()};
    kabsch.Add({b.x, b.y, -b.z}, b);
  }
  const auto solved = kabsch.Solve();
  ASSERT_TRUE(solved.has_value());
  const geometry::Mat3 r = solved->rotation.Matrix();
  EXPECT_NEAR(geometry::Dot(geometry::Cross({r(0, 0), r(1, 0), r(2, 0)},
                                            {r(0, 1), r(1, 1), r(2, 1)}),
                            {r(0, 2), r(1, 2), r(2, 2)}),
              1, 1e-12);
}

TEST(KabschTest, AveragesNoiseDown) {
  // 1000 points of 2 cm noise in a 2 m cube: translation to about
  // 0.02 / sqrt(1000) = 0.6 mm a component; four times that never happens.
  base::Random random(3, 0);
  const geometry::Rigid3 truth = RandomPose(random);
  geometry::Kabsch kabsch;
  for (int i = 0; i < 1000; ++i) {
    const geometry::Vec3 b = RandomVector(random, 1);
    kabsch.Add(truth * b + Noise(random, 0.02), b);
  }
  const geometry::PoseError error =
      geometry::ErrorBetween(*kabsch.Solve(), truth);
  EXPECT_LT(error.translation_m, 0.0045);
  EXPECT_LT(error.rotation_rad, 0.0045);
}

TEST(KabschTest, RefusesPointsThatDetermineNothing) {
  geometry::Kabsch two;
  two.Add({0, 0, 0}, {0, 0, 0});
  two.Add({1, 0, 0}, {1, 0, 0});
  EXPECT_FALSE(two.Solve().has_value());
  geometry::Kabsch line;
  for (double x : {0., 1., 2., 5.}) line.Add({x, 0, 0}, {0, x, 0});
  EXPECT_FALSE(line.Solve().has_value());
  geometry::Kabsch same;
  for (int i = 0; i < 5; ++i) same.Add({1, 2, 3}, {3, 2, 1});
  EXPECT_FALSE(same.Solve().has_value());
}

// Points 1 to 3 m in front of a camera and what a forest might say of them: a
// share of outliers anywhere in the room, the rest with Gaussian noise of
// `sigma_m`. Each point has one prediction.
PointPredictions Scene(const geometry::Rigid3& world_from_camera, int points,
                       double outliers, double sigma_m, base::Random& random) {
  PointPredictions scene;
  for (int i = 0; i < points; ++i) {
    const double z = random.NextUniform(1, 3);
    const geometry::Vec3 point{z * random.NextUniform(-0.5, 0.5),
                               z * random.NextUniform(-0.4, 0.4), z};
    ScenePrediction prediction;
    prediction.mean_in_world =
        random.NextUnit() < outliers
            ? RandomVector(random, 3)
            : world_from_camera * point + Noise(random, sigma_m);
    for (const size_t k : {0u, 3u, 5u})
      prediction.covariance[k] = sigma_m * sigma_m;
    scene.point_in_camera.push_back(point);
    scene.depth_sigma_m.push_back(0);
    scene.predictions.push_back(prediction);
  }
  return scene;
}

std::optional<geometry::Rigid3> Ransac(const PointPredictions& scene,
                                       uint64_t seed,
                                       const std::stop_token& stop = {}) {
  return PreemptiveRansac(PointSolver(scene, {}), {.seed = seed}, stop);
}

// Points whose prediction lies within the solver's inlier distance.
int InliersOf(const PointPredictions& scene, const geometry::Rigid3& pose) {
  int inliers = 0;
  for (size_t i = 0; i < scene.size(); ++i) {
    const geometry::Vec3 residual =
        pose * scene.point_in_camera[i] - scene.at(i, 0).mean_in_world;
    inliers +=
        geometry::Norm(residual) <= PointSolverOptions().inlier_distance_m;
  }
  return inliers;
}

TEST(PointSolverTest, FindsThePoseAmongSixtyPerCentOutliers) {
  base::Random random(4, 0);
  for (int trial = 0; trial < 20; ++trial) {
    const geometry::Rigid3 truth = RandomPose(random);
    const PointPredictions scene = Scene(truth, 500, 0.6, 0.02, random);
    const auto pose = Ransac(scene, static_cast<uint64_t>(trial));
    ASSERT_TRUE(pose.has_value());
    // 200 inliers of 2 cm a component: about 0.02 * sqrt(3 / 200) = 2.4 mm,
    // and the lever arm of 2 m turns rotation into as much again.
    const geometry::PoseError error = geometry::ErrorBetween(*pose, truth);
    EXPECT_LT(error.translation_m, 0.02) << "trial " << trial;
    EXPECT_LT(error.rotation_rad, 0.01) << "trial " << trial;
    EXPECT_NEAR(InliersOf(scene, *pose), 200, 40);
  }
}

TEST(PointSolverTest, TheSameSeedGivesTheSameBits) {
  base::Random random(5, 0);
  const PointPredictions scene =
      Scene(RandomPose(random), 300, 0.5, 0.02, random);
  const auto a = Ransac(scene, 1);
  const auto b = Ransac(scene, 1);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(*a, *b);
}

TEST(PointSolverTest, PureNoiseHasHardlyAnInlier) {
  base::Random random(6, 0);
  const PointPredictions scene = Scene({}, 500, 1.0, 0.02, random);
  const auto pose = Ransac(scene, 0);
  EXPECT_LT(pose ? InliersOf(scene, *pose) : 0, 25);
}

TEST(PointSolverTest, TooFewPointsAndStopsGiveNothing) {
  base::Random random(7, 0);
  EXPECT_FALSE(Ransac(Scene({}, 2, 0, 0.01, random), 0));
  EXPECT_FALSE(Ransac({}, 0));
  std::stop_source stop;
  stop.request_stop();
  EXPECT_FALSE(Ransac(Scene({}, 300, 0, 0.01, random), 0, stop.get_token()));
}

TEST(RefinePointsTest, ConvergesOnExactData) {
  base::Random random(8, 0);
  const geometry::Rigid3 truth = RandomPose(random);
  const PointPredictions scene = Scene(truth, 100, 0, 0, random);
  geometry::Rigid3 start = truth;
  start.translation = start.translation + geometry::Vec3{0.03, -0.02, 0.01};
  start.rotation =
      geometry::Rotation3::FromAxisAngle({0.01, 0.01, -0.02}) * start.rotation;
  const auto refined = RefinePoints(scene, start, {});
  ASSERT_TRUE(refined.has_value());
  const geometry::PoseError error =
      geometry::ErrorBetween(refined->world_from_camera, truth);
  EXPECT_LT(error.translation_m, 1e-6);
  EXPECT_LT(error.rotation_rad, 1e-6);
  EXPECT_EQ(refined->inliers, 100);
}

// The normalised estimation error squared e^T C^-1 e of a correct covariance
// C has mean 6 (its dimension).
TEST(RefinePointsTest, CovarianceMatchesTheErrors) {
  base::Random random(9, 0);
  double nees = 0;
  constexpr int kTrials = 200;
  for (int trial = 0; trial < kTrials; ++trial) {
    const geometry::Rigid3 truth = RandomPose(random);
    // The noise is small against the robust scale, so that all points count,
    // and the model's own floor is part of it.
    PointRefinementOptions options;
    options.model_sigma_m = 1e-6;
    const PointPredictions scene = Scene(truth, 200, 0, 0.005, random);
    const auto refined = RefinePoints(scene, truth, options);
    ASSERT_TRUE(refined.has_value());
    const geometry::Vec3 dt =
        truth.translation - refined->world_from_camera.translation;
    const geometry::Vec3 dr = geometry::ToAxisAngle(
        truth.rotation * refined->world_from_camera.rotation.Inverse());
    Eigen::Matrix<double, 6, 1> e;
    e << dt.x, dt.y, dt.z, dr.x, dr.y, dr.z;
    const Eigen::Map<const Eigen::Matrix<double, 6, 6>> c(
        refined->covariance.data());
    nees += e.dot(c.ldlt().solve(e));
  }
  // Standard deviation of the mean of 200 chi-squared(6): sqrt(12 / 200) =
  // 0.25. Robust weights inflate the covariance by a few per cent.
  EXPECT_NEAR(nees / kTrials, 6, 1.0);
}

TEST(RefinePointsTest, PicksTheSupportingPredictionOfEachPoint) {
  base::Random random(10, 0);
  const geometry::Rigid3 truth = RandomPose(random);
  const PointPredictions one = Scene(truth, 120, 0, 0.002, random);
  PointPredictions two = one;
  two.per_sample = 2;
  two.predictions.clear();
  for (size_t i = 0; i < one.size(); ++i) {
    ScenePrediction wrong = one.at(i, 0);
    wrong.mean_in_world = wrong.mean_in_world + geometry::Vec3{0.5, 0.4, 0.3};
    const bool first = i % 2 == 0;
    two.predictions.push_back(first ? one.at(i, 0) : wrong);
    two.predictions.push_back(first ? wrong : one.at(i, 0));
  }
  const auto refined = RefinePoints(two, truth, {});
  ASSERT_TRUE(refined.has_value());
  for (size_t i = 0; i < two.size(); ++i) {
    EXPECT_EQ(refined->supported[i], i % 2 == 0 ? 0 : 1);
  }
}

TEST(RefinePointsTest, WeightsByTheLeavesCovariance) {
  // Half the predictions are honest about being poor: they must not spoil the
  // precise half. 60 precise points of 1 mm: about 0.3 mm.
  base::Random random(11, 0);
  const geometry::Rigid3 truth = RandomPose(random);
  PointPredictions scene = Scene(truth, 60, 0, 0.001, random);
  const PointPredictions poor = Scene(truth, 60, 0, 0.03, random);
  for (size_t i = 0; i < poor.size(); ++i) {
    scene.point_in_camera.push_back(poor.point_in_camera[i]);
    scene.depth_sigma_m.push_back(0);
    scene.predictions.push_back(poor.predictions[i]);
  }
  PointRefinementOptions options;
  options.model_sigma_m = 0.0005;
  const auto refined = RefinePoints(scene, truth, options);
  ASSERT_TRUE(refined.has_value());
  EXPECT_LT(
      geometry::ErrorBetween(refined->world_from_camera, truth).translation_m,
      0.0015);
}

TEST(RefinePointsTest, NoInliersIsNoPose) {
  base::Random random(12, 0);
  PointPredictions scene = Scene({}, 50, 0, 0.01, random);
  for (ScenePrediction& p : scene.predictions) {
    p.mean_in_world = p.mean_in_world + geometry::Vec3{100, 0, 0};
  }
  EXPECT_FALSE(RefinePoints(scene, {}, {}).has_value());
}

}  // namespace
}  // namespace treeline::pose
