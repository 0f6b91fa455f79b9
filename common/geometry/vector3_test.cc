#include "common/geometry/vector3.h"

#include <cmath>
#include <limits>

#include "gtest/gtest.h"

namespace treeline::geometry {
namespace {

TEST(Vec3, IndexesItsComponentsInOrder) {
  constexpr Vec3 a{1, 2, 3};
  EXPECT_EQ(a[0], 1);
  EXPECT_EQ(a[1], 2);
  EXPECT_EQ(a[2], 3);
}

TEST(Vec3, ArithmeticMatchesHandComputedValues) {
  constexpr Vec3 a{1, -2, 3};
  constexpr Vec3 b{4, 5, -6};
  EXPECT_EQ(a + b, (Vec3{5, 3, -3}));
  EXPECT_EQ(a - b, (Vec3{-3, -7, 9}));
  EXPECT_EQ(-a, (Vec3{-1, 2, -3}));
  EXPECT_EQ(2 * a, (Vec3{2, -4, 6}));
  EXPECT_EQ(a * 2, (Vec3{2, -4, 6}));
  EXPECT_EQ(a / 4, (Vec3{0.25, -0.5, 0.75}));
}

TEST(Vec3, DotAndCrossMatchHandComputedValues) {
  constexpr Vec3 a{1, -2, 3};
  constexpr Vec3 b{4, 5, -6};
  EXPECT_EQ(Dot(a, b), 4 - 10 - 18);
  EXPECT_EQ(Cross(a, b), (Vec3{12 - 15, 12 + 6, 5 + 8}));
}

TEST(Vec3, CrossFollowsTheRightHandRule) {
  EXPECT_EQ(Cross({1, 0, 0}, {0, 1, 0}), (Vec3{0, 0, 1}));
  EXPECT_EQ(Cross({0, 1, 0}, {0, 0, 1}), (Vec3{1, 0, 0}));
  EXPECT_EQ(Cross({0, 0, 1}, {1, 0, 0}), (Vec3{0, 1, 0}));
}

TEST(Vec3, CrossIsOrthogonalToBothAndAsLongAsTheirArea) {
  constexpr Vec3 a{0.3, -1.2, 2.5};
  constexpr Vec3 b{-0.7, 0.4, 1.1};
  const Vec3 c = Cross(a, b);
  EXPECT_NEAR(Dot(c, a), 0, 1e-14);
  EXPECT_NEAR(Dot(c, b), 0, 1e-14);
  EXPECT_NEAR(SquaredNorm(c),
              SquaredNorm(a) * SquaredNorm(b) - Dot(a, b) * Dot(a, b), 1e-12);
}

TEST(Vec3, NormOfAKnownTripleAndUnitLength) {
  EXPECT_EQ(Norm({2, -3, 6}), 7);
  EXPECT_EQ(SquaredNorm({2, -3, 6}), 49);
  EXPECT_NEAR(Norm(Normalized({2, -3, 6})), 1, 1e-15);
  EXPECT_NEAR(Normalized({2, -3, 6}).y, -3.0 / 7, 1e-15);
}

TEST(Vec3, IsFiniteSeesEachComponent) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(IsFinite({1, 2, 3}));
  EXPECT_FALSE(IsFinite({nan, 2, 3}));
  EXPECT_FALSE(IsFinite({1, inf, 3}));
  EXPECT_FALSE(IsFinite({1, 2, -inf}));
}

TEST(Mat3, IsRowMajor) {
  const Mat3 a{{1, 2, 3, 4, 5, 6, 7, 8, 9}};
  EXPECT_EQ(a(0, 2), 3);
  EXPECT_EQ(a(2, 0), 7);
  EXPECT_EQ(a * Vec3({1, 10, 100}), (Vec3{321, 654, 987}));
}

TEST(Mat3, ProductMatchesAHandComputedOne) {
  const Mat3 a{{1, 2, 0, 0, 1, 0, 3, 0, 1}};
  const Mat3 b{{1, 0, 4, 2, 1, 0, 0, 5, 1}};
  const Mat3 c = a * b;
  const Mat3 expected{{5, 2, 4, 2, 1, 0, 3, 5, 13}};
  EXPECT_EQ(c.m, expected.m);
}

TEST(Mat3, ProductAppliesTheRightFactorFirst) {
  const Mat3 a{{1, 2, 3, 4, 5, 6, 7, 8, 10}};
  const Mat3 b{{2, 0, 1, 1, 3, 0, 0, 1, 1}};
  const Vec3 v{1, -2, 3};
  EXPECT_EQ((a * b) * v, a * (b * v));
}

TEST(Mat3, TransposeSwapsRowsAndColumns) {
  const Mat3 a{{1, 2, 3, 4, 5, 6, 7, 8, 9}};
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) EXPECT_EQ(Transpose(a)(r, c), a(c, r));
  }
}

TEST(Mat3, IdentityChangesNothing) {
  const Vec3 v{1.5, -2, 3};
  EXPECT_EQ(Mat3::Identity() * v, v);
}

}  // namespace
}  // namespace treeline::geometry
