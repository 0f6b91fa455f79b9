#include "server/core/pose/ray_solver.h"

#include <cmath>

#include "common/base/random.h"
#include "gtest/gtest.h"
#include "server/core/pose/p3p.h"
#include "server/core/pose/preemptive_ransac.h"
#include "server/core/pose/ray_refinement.h"

namespace treeline::pose {
namespace {

geometry::Vec3 RandomVector(base::Random& random, double size) {
  return {random.NextUniform(-size, size), random.NextUniform(-size, size),
          random.NextUniform(-size, size)};
}

geometry::Rigid3 RandomPose(base::Random& random) {
  return {geometry::Rotation3::FromAxisAngle(RandomVector(random, 2)),
          RandomVector(random, 3)};
}

geometry::Vec3 PointInView(base::Random& random) {
  const double z = random.NextUniform(1, 4);
  return {z * random.NextUniform(-0.6, 0.6),
          z * random.NextUniform(-0.45, 0.45), z};
}

TEST(P3pTest, FindsThePoseOfExactPoints) {
  base::Random random(1, 2);
  int found = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const geometry::Rigid3 world_from_camera = RandomPose(random);
    std::array<camera::Pixel, 3> rays;
    std::array<geometry::Vec3, 3> points;
    for (size_t k = 0; k < 3; ++k) {
      const geometry::Vec3 p = PointInView(random);
      rays[k] = {p.x / p.z, p.y / p.z};
      points[k] = world_from_camera * p;
    }
    const P3pSolutions solutions = SolveP3p(rays, points);
    ASSERT_LE(solutions.count, 4);
    double best = 1e9;
    for (int s = 0; s < solutions.count; ++s) {
      const geometry::Rigid3& pose =
          solutions.camera_from_world[static_cast<size_t>(s)];
      // Each is a solution, if not the one that was meant.
      for (size_t k = 0; k < 3; ++k) {
        const geometry::Vec3 p = pose * points[k];
        EXPECT_NEAR(p.x / p.z, rays[k].x, 1e-3);
        EXPECT_NEAR(p.y / p.z, rays[k].y, 1e-3);
      }
      const geometry::PoseError error =
          geometry::ErrorBetween(pose.Inverse(), world_from_camera);
      best = std::min(best, error.translation_m + error.rotation_rad);
    }
    found += best < 1e-4;
  }
  // Nearly degenerate triangles are lost to rounding.
  EXPECT_GT(found, 1980);
}

TEST(P3pTest, GivesNothingForPointsOnALine) {
  EXPECT_EQ(SolveP3p({{{0, 0}, {0.1, 0}, {0.2, 0}}},
                     {{{0, 0, 1}, {0, 0, 1}, {0, 0, 1}}})
                .count,
            0);
}

// Pixels of a random pose, some of whose predictions are wrong.
struct Problem {
  geometry::Rigid3 world_from_camera;
  RayPredictions scene;
};
Problem MakeProblem(uint64_t seed, int count, double outliers, double sigma_m) {
  base::Random random(seed, 3);
  Problem problem;
  problem.world_from_camera = RandomPose(random);
  problem.scene.per_sample = 2;
  for (int i = 0; i < count; ++i) {
    const geometry::Vec3 p = PointInView(random);
    problem.scene.ray.push_back({p.x / p.z, p.y / p.z});
    problem.scene.ray_sigma.push_back(0.5 / 525);
    for (int k = 0; k < 2; ++k) {
      ScenePrediction prediction;
      prediction.mean_in_world =
          k == 1 || random.NextUnit() < outliers
              ? RandomVector(random, 4)
              : problem.world_from_camera * p + RandomVector(random, sigma_m);
      for (const size_t c : {0u, 3u, 5u}) {
        prediction.covariance[c] = sigma_m * sigma_m / 3;
      }
      problem.scene.predictions.push_back(prediction);
    }
  }
  return problem;
}

std::optional<geometry::Rigid3> Ransac(const RayPredictions& scene,
                                       uint64_t seed,
                                       const std::stop_token& stop = {}) {
  return PreemptiveRansac(RaySolver(scene, {}), {.seed = seed}, stop);
}

TEST(RaySolverTest, FindsThePoseAmongOutliers) {
  for (uint64_t seed = 0; seed < 10; ++seed) {
    const Problem problem = MakeProblem(seed, 400, 0.6, 0.02);
    const auto pose = Ransac(problem.scene, seed);
    ASSERT_TRUE(pose) << seed;
    const auto refined = RefineRays(problem.scene, *pose, {});
    ASSERT_TRUE(refined) << seed;
    const geometry::PoseError error = geometry::ErrorBetween(
        refined->world_from_camera, problem.world_from_camera);
    EXPECT_LT(error.translation_m, 0.015) << seed;
    EXPECT_LT(error.rotation_rad, 0.01) << seed;
    EXPECT_GT(refined->inliers, 100) << seed;
    EXPECT_EQ(*Ransac(problem.scene, seed), *pose);
  }
}

TEST(RaySolverTest, CovarianceIsOfTheSizeOfTheError) {
  double normalised = 0;
  constexpr int kTrials = 40;
  for (uint64_t seed = 0; seed < kTrials; ++seed) {
    const Problem problem = MakeProblem(100 + seed, 300, 0.2, 0.02);
    const auto refined =
        RefineRays(problem.scene, problem.world_from_camera, {});
    ASSERT_TRUE(refined);
    const geometry::Vec3 t = refined->world_from_camera.translation -
                             problem.world_from_camera.translation;
    const double variance = refined->covariance[0] + refined->covariance[7] +
                            refined->covariance[14];
    normalised += geometry::SquaredNorm(t) / variance / kTrials;
  }
  EXPECT_GT(normalised, 0.3);
  EXPECT_LT(normalised, 3);
}

TEST(RaySolverTest, HasNoAnswerWithoutSupport) {
  const Problem noise = MakeProblem(7, 3, 0, 0.01);
  EXPECT_FALSE(Ransac(noise.scene, 0));
  // Behind the camera.
  const Problem problem = MakeProblem(8, 100, 0, 0.01);
  geometry::Rigid3 turned = problem.world_from_camera;
  turned.rotation =
      turned.rotation * geometry::Rotation3::FromAxisAngle({0, 3.14159265, 0});
  EXPECT_FALSE(RefineRays(problem.scene, turned, {}));
  std::stop_source stop;
  stop.request_stop();
  EXPECT_FALSE(Ransac(problem.scene, 0, stop.get_token()));
}

}  // namespace
}  // namespace treeline::pose
