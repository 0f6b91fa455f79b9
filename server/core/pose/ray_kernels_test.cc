#include "server/core/pose/ray_kernels.h"

#include <cmath>

#include "Eigen/Core"
#include "Eigen/LU"
#include "common/base/random.h"
#include "common/base/testing_vector_targets.h"
#include "gtest/gtest.h"
#include "server/core/pose/parameters.h"

namespace treeline::pose {
namespace {

constexpr double kScale = 0.02;

double Uniform(base::Random& random, double size) {
  return size * (2.0 * random.NextBelow(1u << 30) / (1u << 30) - 1);
}

geometry::Rigid3 SomePose() {
  return {geometry::Rotation3::FromAxisAngle({0.3, -0.2, 0.5}), {2, -1, 0.5}};
}

// Points before the camera and behind it, seen well, badly and elsewhere.
RayPredictions SomeRays(size_t count) {
  base::Random random(4, 0);
  RayPredictions scene;
  for (size_t i = 0; i < count; ++i) {
    const geometry::Vec3 p{Uniform(random, 1), Uniform(random, 1),
                           i % 9 == 0 ? -2.0 : 2 + Uniform(random, 1)};
    const double error = i % 5 == 0 ? 0.5 : 0.02;
    scene.ray.push_back({p.x / p.z + Uniform(random, error),
                         p.y / p.z + Uniform(random, error)});
    scene.ray_sigma.push_back(0.002 + 0.001 * (1 + Uniform(random, 1)));
    scene.predictions.push_back(
        {SomePose() * p, {2e-4, 2e-5, -1e-5, 1e-4, 3e-5, 3e-4}});
  }
  return scene;
}

// The residual of a ray when the pose is moved as in PoseCovariance.
Eigen::Vector2d ResidualAt(const RayPredictions& scene, size_t i,
                           const Eigen::Matrix<double, 6, 1>& step) {
  const geometry::Rigid3 pose = SomePose();
  const geometry::Rigid3 moved = {
      geometry::Rotation3::FromAxisAngle({step[3], step[4], step[5]}) *
          pose.rotation,
      pose.translation + geometry::Vec3{step[0], step[1], step[2]}};
  const geometry::Vec3 p = moved.Inverse() * scene.at(i, 0).mean_in_world;
  return {p.x / p.z - scene.ray[i].x, p.y / p.z - scene.ray[i].y};
}

// As the header defines the sums, with derivatives by differences.
struct Expected {
  Eigen::Matrix<double, 6, 6> hessian = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> gradient = Eigen::Matrix<double, 6, 1>::Zero();
  double value = 0;
  double weights = 0;
};

Expected SumsOf(const RayPredictions& scene) {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  constexpr double kStep = 1e-6;
  Expected sums;
  const geometry::Rigid3 camera_from_world = SomePose().Inverse();
  for (size_t i = 0; i < scene.size(); ++i) {
    const geometry::Vec3 p = camera_from_world * scene.at(i, 0).mean_in_world;
    const Eigen::Vector2d r = ResidualAt(scene, i, Vector6::Zero());
    if (p.z <= 0 || r.norm() > kRobustReach * kScale) continue;
    Eigen::Matrix<double, 2, 6> j;
    for (int a = 0; a < 6; ++a) {
      j.col(a) = (ResidualAt(scene, i, kStep * Vector6::Unit(a)) -
                  ResidualAt(scene, i, -kStep * Vector6::Unit(a))) /
                 (2 * kStep);
    }
    // Moving the camera moves the point the other way.
    const Eigen::Matrix<double, 2, 3> a = -j.leftCols<3>();
    const auto& c = scene.at(i, 0).covariance;
    Eigen::Matrix3d covariance;
    covariance << c[0], c[1], c[2], c[1], c[3], c[4], c[2], c[4], c[5];
    const double noise = scene.ray_sigma[i] * scene.ray_sigma[i];
    const double root = kScale * kScale / (kScale * kScale + r.squaredNorm());
    const Eigen::Matrix2d w =
        root * root *
        (a * covariance * a.transpose() + noise * Eigen::Matrix2d::Identity())
            .inverse();
    sums.hessian += j.transpose() * w * j;
    sums.gradient += j.transpose() * w * r;
    sums.value += r.dot(w * r);
    sums.weights += root * root;
  }
  return sums;
}

TEST(RayKernelsTest, SumsAreThoseOfTheDefinition) {
  for (const size_t count : {1u, 7u, 8u, 50u}) {
    const RayPredictions scene = SomeRays(count);
    const Expected expected = SumsOf(scene);
    base::WithEachVectorTarget([&] {
      const RobustSum sum = SumRays(PackedRays(scene), SomePose(), kScale);
      EXPECT_NEAR(sum.value, expected.value, 1e-9 * (1 + expected.value));
      EXPECT_NEAR(sum.weights, expected.weights, 1e-9);
      EXPECT_EQ(sum.residuals, 2 * sum.weights);
      // Differences are exact to about 1e-9 of the largest term.
      const double near = 1e-7 * (1 + expected.hessian.maxCoeff());
      for (int a = 0; a < 6; ++a) {
        EXPECT_NEAR(sum.equations.gradient[static_cast<size_t>(a)],
                    expected.gradient[a], near);
        for (int b = a; b < 6; ++b) {
          EXPECT_NEAR(sum.equations.hessian[static_cast<size_t>(6 * a + b)],
                      expected.hessian(a, b), near)
              << a << b;
        }
      }
    });
  }
}

}  // namespace
}  // namespace treeline::pose
