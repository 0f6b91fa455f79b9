// The algebra of docs/explanation/points-and-lines.md against numeric
// differences, and what lines do to a pose.
#include "server/core/pose/normal_equations.h"

#include <cmath>

#include "common/base/random.h"
#include "gtest/gtest.h"
#include "server/core/pose/point_line_solver.h"
#include "server/core/pose/point_refinement.h"
#include "server/core/pose/preemptive_ransac.h"

namespace treeline::pose {
namespace {

geometry::Vec3 RandomVector(base::Random& random, double scale) {
  return {random.NextUniform(-scale, scale), random.NextUniform(-scale, scale),
          random.NextUniform(-scale, scale)};
}

geometry::Rigid3 RandomPose(base::Random& random) {
  return {geometry::Rotation3::FromAxisAngle(RandomVector(random, 1.8)),
          RandomVector(random, 3)};
}

// Sum of outer products: positive definite.
Symmetric3 RandomCovariance(base::Random& random) {
  Symmetric3 c{0.1, 0, 0, 0.1, 0, 0.1};
  for (int i = 0; i < 3; ++i) {
    const geometry::Vec3 v = RandomVector(random, 1);
    c = {c[0] + v.x * v.x, c[1] + v.x * v.y, c[2] + v.x * v.z,
         c[3] + v.y * v.y, c[4] + v.y * v.z, c[5] + v.z * v.z};
  }
  return c;
}

// R c R^T.
Symmetric3 Rotated(const Symmetric3& c, const geometry::Rotation3& rotation) {
  const geometry::Mat3 r = rotation.Matrix();
  const geometry::Mat3 product =
      r *
      geometry::Mat3{{c[0], c[1], c[2], c[1], c[3], c[4], c[2], c[4], c[5]}} *
      geometry::Transpose(r);
  return {product(0, 0), product(0, 1), product(0, 2),
          product(1, 1), product(1, 2), product(2, 2)};
}

// `pose` after a change (translation, rotation) as in PoseCovariance.
geometry::Rigid3 Changed(const geometry::Rigid3& pose,
                         const std::array<double, 6>& change) {
  return {
      geometry::Rotation3::FromAxisAngle({change[3], change[4], change[5]}) *
          pose.rotation,
      pose.translation + geometry::Vec3{change[0], change[1], change[2]}};
}

// A point with its prediction, and its line if it is on one.
struct Correspondence {
  geometry::Vec3 point_in_camera;
  geometry::Vec3 direction_in_camera;  // zero: no line
  geometry::Vec3 mean_in_world;
  Symmetric3 information{};

  double Energy(const geometry::Rigid3& world_from_camera) const {
    const geometry::Vec3 r =
        world_from_camera * point_in_camera - mean_in_world;
    if (direction_in_camera == geometry::Vec3{})
      return QuadraticForm(information, r);
    return QuadraticForm(AcrossLine(information, world_from_camera.rotation *
                                                     direction_in_camera),
                         r);
  }

  NormalEquations Equations(const geometry::Rigid3& world_from_camera) const {
    NormalEquations equations;
    const geometry::Vec3 q = world_from_camera.rotation * point_in_camera;
    const geometry::Vec3 r = q + world_from_camera.translation - mean_in_world;
    if (direction_in_camera == geometry::Vec3{}) {
      equations.Add(information, q, r);
      return equations;
    }
    const geometry::Vec3 d = world_from_camera.rotation * direction_in_camera;
    const geometry::Vec3 along = ClosestOnLine(information, r, d) * d;
    equations.Add(AcrossLine(information, d), q + along, r + along);
    return equations;
  }
};

Correspondence RandomCorrespondence(base::Random& random, bool on_line) {
  return {RandomVector(random, 2),
          on_line ? geometry::Normalized(RandomVector(random, 1))
                  : geometry::Vec3{},
          RandomVector(random, 2), Inverse(RandomCovariance(random))};
}

TEST(NormalEquationsTest, InverseAndDeterminantByHand) {
  // Block diagonal: [[2 1] [1 1]] and 4.
  const Symmetric3 a = {2, 1, 0, 1, 0, 4};
  EXPECT_DOUBLE_EQ(Determinant(a), 4);
  const Symmetric3 inverse = Inverse(a);
  const Symmetric3 expected = {1, -1, 0, 2, 0, 0.25};
  for (size_t i = 0; i < 6; ++i) EXPECT_DOUBLE_EQ(inverse[i], expected[i]);
  EXPECT_DOUBLE_EQ(QuadraticForm(a, {1, 2, 3}), 2 + 4 + 4 + 36);
}

TEST(NormalEquationsTest, AcrossALineIsTheLeastDistanceToAnyOfItsPoints) {
  base::Random random(1, 0);
  for (int trial = 0; trial < 50; ++trial) {
    const Symmetric3 w = Inverse(RandomCovariance(random));
    const geometry::Vec3 d = RandomVector(random, 1);
    const geometry::Vec3 r = RandomVector(random, 1);
    const double across = QuadraticForm(AcrossLine(w, d), r);
    const double t = ClosestOnLine(w, r, d);
    EXPECT_NEAR(across, QuadraticForm(w, r + t * d), 1e-12);
    for (const double other : {t - 1, t - 0.01, t + 0.01, t + 1}) {
      EXPECT_LT(across, QuadraticForm(w, r + other * d));
    }
    EXPECT_NEAR(QuadraticForm(AcrossLine(w, d), d), 0, 1e-12);
  }
}

// Eq. 5.8 with Eq. 5.9 is in the camera what AcrossLine is in the world: there
// the line moves and the covariance stays.
TEST(NormalEquationsTest, TheCameraAndTheWorldAgreeOnTheDistance) {
  base::Random random(2, 0);
  for (int trial = 0; trial < 50; ++trial) {
    const geometry::Rigid3 world_from_camera = RandomPose(random);
    const Symmetric3 covariance = RandomCovariance(random);
    Correspondence c = RandomCorrespondence(random, true);
    c.information = Inverse(covariance);
    const geometry::Rigid3 camera_from_world = world_from_camera.Inverse();
    const Symmetric3 in_camera =
        Inverse(Rotated(covariance, camera_from_world.rotation));
    const geometry::Vec3 r =
        camera_from_world * c.mean_in_world - c.point_in_camera;
    const double t = -ClosestOnLine(in_camera, r, c.direction_in_camera);
    const geometry::Vec3 q = c.point_in_camera + t * c.direction_in_camera;
    EXPECT_NEAR(
        QuadraticForm(in_camera, camera_from_world * c.mean_in_world - q),
        c.Energy(world_from_camera), 1e-9);
  }
}

TEST(NormalEquationsTest, GradientsAreThoseOfNumericDifferences) {
  base::Random random(3, 0);
  constexpr double kStep = 1e-5;
  for (int trial = 0; trial < 50; ++trial) {
    const Correspondence c = RandomCorrespondence(random, trial % 2 == 0);
    const geometry::Rigid3 pose = RandomPose(random);
    const NormalEquations equations = c.Equations(pose);
    for (size_t i = 0; i < 6; ++i) {
      std::array<double, 6> change{};
      change[i] = kStep;
      const double above = c.Energy(Changed(pose, change));
      change[i] = -kStep;
      const double below = c.Energy(Changed(pose, change));
      // Central differences: errors of kStep^2 times third derivatives of
      // some hundreds.
      EXPECT_NEAR(2 * equations.gradient[i], (above - below) / (2 * kStep),
                  1e-6 * (1 + std::abs(2 * equations.gradient[i])))
          << "trial " << trial << ", " << i;
    }
  }
}

// Where the residual is zero, Gauss-Newton's Hessian is the Hessian: for lines
// only if the closest point is taken to move with the pose.
TEST(NormalEquationsTest, HessiansAreThoseOfNumericDifferences) {
  base::Random random(4, 0);
  constexpr double kStep = 1e-3;
  for (int trial = 0; trial < 20; ++trial) {
    Correspondence c = RandomCorrespondence(random, trial % 2 == 0);
    const geometry::Rigid3 pose = RandomPose(random);
    const double t = random.NextUniform(-1, 1);
    c.mean_in_world = pose * (c.point_in_camera + t * c.direction_in_camera);
    const NormalEquations equations = c.Equations(pose);
    for (size_t i = 0; i < 6; ++i) {
      for (size_t j = i; j < 6; ++j) {
        double mixed = 0;
        for (const double a : {-1., 1.}) {
          for (const double b : {-1., 1.}) {
            std::array<double, 6> change{};
            change[i] += a * kStep;
            change[j] += b * kStep;
            mixed += a * b * c.Energy(Changed(pose, change));
          }
        }
        // Errors of kStep^2 times fourth derivatives of some hundreds.
        const double h = 2 * equations.hessian[6 * i + j];
        EXPECT_NEAR(h, mixed / (4 * kStep * kStep), 2e-3) << i << ", " << j;
      }
    }
  }
}

// Points in front of a camera, each on a line of its own, and predictions that
// are exact but for sliding up to `slide_m` along the lines.
PointPredictions LineScene(const geometry::Rigid3& world_from_camera,
                           int points, double slide_m, base::Random& random) {
  PointPredictions scene;
  for (int i = 0; i < points; ++i) {
    const double z = random.NextUniform(1, 3);
    const geometry::Vec3 point{z * random.NextUniform(-0.5, 0.5),
                               z * random.NextUniform(-0.4, 0.4), z};
    const geometry::Vec3 direction =
        geometry::Normalized(RandomVector(random, 1));
    ScenePrediction prediction;
    prediction.mean_in_world =
        world_from_camera *
        (point + random.NextUniform(-slide_m, slide_m) * direction);
    for (const size_t k : {0u, 3u, 5u}) prediction.covariance[k] = 1e-4;
    scene.point_in_camera.push_back(point);
    scene.line_direction_in_camera.push_back(direction);
    scene.depth_sigma_m.push_back(0.002);
    scene.predictions.push_back(prediction);
  }
  return scene;
}

PointRefinementOptions LevenbergMarquardt() {
  PointRefinementOptions options;
  options.levenberg_marquardt = true;
  options.likeliest_prediction = true;
  return options;
}

TEST(PointsOnLinesTest, PredictionsThatSlideAlongLinesDoNoHarm) {
  base::Random random(5, 0);
  for (int trial = 0; trial < 10; ++trial) {
    const geometry::Rigid3 truth = RandomPose(random);
    PointPredictions scene = LineScene(truth, 60, 0.1, random);
    const geometry::Rigid3 start =
        Changed(truth, {0.02, -0.02, 0.01, 0.005, -0.005, 0.01});
    const auto refined = RefinePoints(scene, start, LevenbergMarquardt());
    ASSERT_TRUE(refined.has_value());
    const geometry::PoseError error =
        geometry::ErrorBetween(refined->world_from_camera, truth);
    EXPECT_LT(error.translation_m, 1e-5);
    EXPECT_LT(error.rotation_rad, 1e-5);
    // Taken for points they are 6 cm off (uniform within 10): some millimetres
    // remain of it after 60 of them.
    scene.line_direction_in_camera.clear();
    const auto as_points = RefinePoints(scene, start, LevenbergMarquardt());
    ASSERT_TRUE(as_points.has_value());
    EXPECT_GT(geometry::ErrorBetween(as_points->world_from_camera, truth)
                  .translation_m,
              1e-3);
  }
}

TEST(PointsOnLinesTest, LinesFixWhatPointsLeaveFree) {
  // Points on a spot of 2 cm fix the position of that spot, hardly a rotation.
  base::Random random(6, 0);
  const geometry::Rigid3 truth = RandomPose(random);
  PointPredictions spot;
  for (int i = 0; i < 40; ++i) {
    const geometry::Vec3 point =
        geometry::Vec3{0.1, 0.2, 2} + RandomVector(random, 0.01);
    ScenePrediction prediction;
    prediction.mean_in_world = truth * point;
    for (const size_t k : {0u, 3u, 5u}) prediction.covariance[k] = 1e-4;
    spot.point_in_camera.push_back(point);
    spot.depth_sigma_m.push_back(0.002);
    spot.predictions.push_back(prediction);
  }
  const auto rotation_sigma = [](const RefinedPose& pose) {
    return std::sqrt(pose.covariance[21] + pose.covariance[28] +
                     pose.covariance[35]);
  };
  const auto alone = RefinePoints(spot, truth, LevenbergMarquardt());
  ASSERT_TRUE(alone.has_value());
  EXPECT_GT(rotation_sigma(*alone), 0.2);

  PointPredictions both = LineScene(truth, 40, 0.1, random);
  for (size_t i = 0; i < spot.size(); ++i) {
    both.point_in_camera.push_back(spot.point_in_camera[i]);
    both.line_direction_in_camera.push_back({});
    both.depth_sigma_m.push_back(spot.depth_sigma_m[i]);
    both.predictions.push_back(spot.predictions[i]);
  }
  const auto with_lines = RefinePoints(both, truth, LevenbergMarquardt());
  ASSERT_TRUE(with_lines.has_value());
  // 40 lines known to 1.4 cm across, a metre apart: 1.4 / sqrt(40) cm a metre.
  EXPECT_LT(rotation_sigma(*with_lines), 0.01);
}

TEST(PointsOnLinesTest, ParallelLinesLeaveTheirOwnDirectionFree) {
  base::Random random(7, 0);
  PointPredictions scene = LineScene({}, 60, 0, random);
  for (geometry::Vec3& direction : scene.line_direction_in_camera)
    direction = {1, 0, 0};
  PointRefinementOptions gauss_newton;
  EXPECT_FALSE(RefinePoints(scene, {}, gauss_newton).has_value());
  // One line across them settles it.
  scene.line_direction_in_camera[0] = {0, 1, 0};
  const auto settled = RefinePoints(scene, {}, gauss_newton);
  ASSERT_TRUE(settled.has_value());
  // As well as one point of 1 cm, with a model of 1 cm, can: 1.4 cm, and a
  // little more for what it must give to the rotation.
  EXPECT_GT(std::sqrt(settled->covariance[0]), 0.0141);
  EXPECT_LT(std::sqrt(settled->covariance[0]), 0.02);
}

TEST(PointsOnLinesTest, RansacScoresAndRefinesAcrossTheLines) {
  // 60 of 100 predictions lie anywhere, the others slide by up to 15 cm.
  base::Random random(8, 0);
  for (int trial = 0; trial < 10; ++trial) {
    const geometry::Rigid3 truth = RandomPose(random);
    PointPredictions scene = LineScene(truth, 500, 0.15, random);
    for (ScenePrediction& prediction : scene.predictions) {
      if (random.NextUnit() < 0.6) {
        prediction.mean_in_world = RandomVector(random, 3);
      }
    }
    const PointLineSolver solver(scene, {.points = {.side_tolerance_m = 0.15},
                                         .refinement = LevenbergMarquardt()});
    const auto pose =
        PreemptiveRansac(solver, {.seed = static_cast<uint64_t>(trial)}, {});
    ASSERT_TRUE(pose.has_value());
    // A few steps have taken most of 15 cm away, ...
    EXPECT_LT(geometry::ErrorBetween(*pose, truth).translation_m, 0.03)
        << "trial " << trial;
    // ... and from there the refinement does the rest. Outliers within the
    // robust scale of a line leave a few millimetres.
    const auto refined = RefinePoints(scene, *pose, LevenbergMarquardt());
    ASSERT_TRUE(refined.has_value());
    const geometry::PoseError error =
        geometry::ErrorBetween(refined->world_from_camera, truth);
    EXPECT_LT(error.translation_m, 0.01) << "trial " << trial;
    EXPECT_LT(error.rotation_rad, 0.01) << "trial " << trial;
  }
}

TEST(PointsOnLinesTest, TakesTheLikeliestPredictionNotTheNearest) {
  // The nearer prediction is sure of itself, 6 sigma off; the other one is
  // further away, and fits.
  base::Random random(9, 0);
  const geometry::Rigid3 truth = RandomPose(random);
  PointPredictions scene = LineScene(truth, 60, 0, random);
  scene.line_direction_in_camera.clear();
  scene.per_sample = 2;
  std::vector<ScenePrediction> predictions;
  for (const ScenePrediction& exact : scene.predictions) {
    ScenePrediction sure = exact;
    sure.mean_in_world = sure.mean_in_world + geometry::Vec3{0.03, 0, 0};
    for (const size_t k : {0u, 3u, 5u}) sure.covariance[k] = 2.5e-5;
    ScenePrediction vague = exact;
    vague.mean_in_world = vague.mean_in_world + RandomVector(random, 0.03);
    for (const size_t k : {0u, 3u, 5u}) vague.covariance[k] = 9e-4;
    predictions.push_back(sure);
    predictions.push_back(vague);
  }
  scene.predictions = predictions;
  PointRefinementOptions options = LevenbergMarquardt();
  options.model_sigma_m = 0.001;
  options.iterations = 1;
  options.robust_scale_m = 0.1;
  const auto likeliest = RefinePoints(scene, truth, options);
  options.likeliest_prediction = false;
  const auto nearest = RefinePoints(scene, truth, options);
  ASSERT_TRUE(likeliest && nearest);
  EXPECT_LT(
      geometry::ErrorBetween(likeliest->world_from_camera, truth).translation_m,
      geometry::ErrorBetween(nearest->world_from_camera, truth).translation_m);
}

}  // namespace
}  // namespace treeline::pose
