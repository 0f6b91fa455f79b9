#include "common/geometry/kabsch.h"

#include <cmath>
#include <vector>

#include "common/base/random.h"
#include "gtest/gtest.h"

namespace treeline::geometry {
namespace {

double Uniform(base::Random& random, double low, double high) {
  return low + (high - low) * random.NextBelow(1u << 30) / (1u << 30);
}

Vec3 SomePoint(base::Random& random, double size) {
  return {Uniform(random, -size, size), Uniform(random, -size, size),
          Uniform(random, -size, size)};
}

Rigid3 SomePose(base::Random& random) {
  return {Rotation3::FromAxisAngle(SomePoint(random, 1.8)),
          SomePoint(random, 4)};
}

// Of triangles, flat ones too, and of many points; 100 km from the origin.
TEST(KabschTest, FindsTheTransformOfExactPoints) {
  base::Random random(1, 0);
  for (int trial = 0; trial < 300; ++trial) {
    const Rigid3 a_from_b = SomePose(random);
    const Vec3 far = trial % 3 == 0 ? SomePoint(random, 1e5) : Vec3{};
    const double height = std::pow(10.0, -(trial % 5));
    Kabsch kabsch;
    for (int i = 0; i < 3 + trial % 7; ++i) {
      Vec3 b = SomePoint(random, 2);
      b.y *= height;
      if (trial % 2 == 0) b.z *= height;
      kabsch.Add(a_from_b * b + far, b, Uniform(random, 0.5, 2));
    }
    const auto found = kabsch.Solve();
    ASSERT_TRUE(found.has_value()) << trial;
    // An eigenvector has about the rounding error over the gap between the
    // eigenvalues, which goes with the square of the height; numbers of 1e5
    // have errors of 1e-11 themselves.
    const PoseError error =
        ErrorBetween(*found, {a_from_b.rotation, a_from_b.translation + far});
    const double digits = (trial % 3 == 0 ? 1e-9 : 1e-12) / (height * height);
    EXPECT_LT(error.rotation_rad, digits) << trial;
    EXPECT_LT(error.translation_m, 10 * digits + 1e-9) << trial;
  }
}

double CostOf(const Rigid3& a_from_b, const std::vector<Vec3>& a,
              const std::vector<Vec3>& b) {
  double cost = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    cost += SquaredNorm(a_from_b * b[i] - a[i]);
  }
  return cost;
}

TEST(KabschTest, NothingNearItsAnswerIsBetter) {
  base::Random random(2, 0);
  for (int trial = 0; trial < 40; ++trial) {
    const Rigid3 a_from_b = SomePose(random);
    std::vector<Vec3> a;
    std::vector<Vec3> b;
    Kabsch kabsch;
    for (int i = 0; i < 8; ++i) {
      b.push_back(SomePoint(random, 2));
      a.push_back(a_from_b * b.back() + SomePoint(random, 0.3));
      kabsch.Add(a.back(), b.back());
    }
    const auto best = kabsch.Solve();
    ASSERT_TRUE(best.has_value());
    const double least = CostOf(*best, a, b);
    for (int k = 0; k < 20; ++k) {
      const Rigid3 other{
          Rotation3::FromAxisAngle(SomePoint(random, 1e-3)) * best->rotation,
          best->translation + SomePoint(random, 1e-3)};
      EXPECT_GT(CostOf(other, a, b), least) << trial;
    }
  }
}

TEST(KabschTest, KnowsNoRotationOfALineOrOfFewPoints) {
  Kabsch line;
  for (int i = 0; i < 5; ++i) line.Add({1.0 * i, 2.0, 3}, {0, 1.0 * i, 1});
  EXPECT_FALSE(line.Solve().has_value());
  Kabsch two;
  two.Add({0, 0, 0}, {0, 0, 0});
  EXPECT_FALSE(two.Solve().has_value());
  two.Add({1, 0, 0}, {0, 1, 0});
  EXPECT_FALSE(two.Solve().has_value());
  Kabsch same;
  for (int i = 0; i < 4; ++i) same.Add({1, 2, 3}, {4, 5, 6});
  EXPECT_FALSE(same.Solve().has_value());
}

TEST(KabschTest, MirroredPointsGetTheBestRotation) {
  base::Random random(3, 0);
  std::vector<Vec3> a;
  std::vector<Vec3> b;
  Kabsch kabsch;
  for (int i = 0; i < 6; ++i) {
    b.push_back(SomePoint(random, 2));
    a.push_back({-b.back().x, b.back().y, b.back().z});
    kabsch.Add(a.back(), b.back());
  }
  const auto best = kabsch.Solve();
  ASSERT_TRUE(best.has_value());
  const double least = CostOf(*best, a, b);
  for (int k = 0; k < 50; ++k) {
    const Rigid3 other{
        Rotation3::FromAxisAngle(SomePoint(random, 3)) * best->rotation,
        best->translation};
    EXPECT_GE(CostOf(other, a, b), least);
  }
}

}  // namespace
}  // namespace treeline::geometry
