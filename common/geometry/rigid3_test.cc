#include "common/geometry/rigid3.h"

#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "absl/status/statusor.h"
#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::geometry {
namespace {

using ::testing::HasSubstr;

constexpr double kPi = 3.14159265358979323846;

// A few roundings of numbers around 1.
constexpr double kRounding = 1e-14;

void ExpectNear(Vec3 a, Vec3 b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

Vec3 RandomVector(base::Random& random) {
  return {random.NextGaussian(), random.NextGaussian(), random.NextGaussian()};
}

Rotation3 RandomRotation(base::Random& random) {
  return Normalized(Rotation3{random.NextGaussian(), random.NextGaussian(),
                              random.NextGaussian(), random.NextGaussian()});
}

Rigid3 RandomRigid(base::Random& random) {
  return {RandomRotation(random), RandomVector(random)};
}

// Row-major 4x4 of rotation `r` times `scale`, and translation `t`.
std::array<double, 16> Matrix4(const Mat3& r, double scale, Vec3 t) {
  return {scale * r(0, 0),
          scale * r(0, 1),
          scale * r(0, 2),
          t.x,
          scale * r(1, 0),
          scale * r(1, 1),
          scale * r(1, 2),
          t.y,
          scale * r(2, 0),
          scale * r(2, 1),
          scale * r(2, 2),
          t.z,
          0,
          0,
          0,
          1};
}

TEST(Rotation3, QuarterTurnsFollowTheRightHandRule) {
  ExpectNear(Rotation3::FromAxisAngle({0, 0, kPi / 2}) * Vec3{1, 0, 0},
             {0, 1, 0}, kRounding);
  ExpectNear(Rotation3::FromAxisAngle({kPi / 2, 0, 0}) * Vec3{0, 1, 0},
             {0, 0, 1}, kRounding);
  ExpectNear(Rotation3::FromAxisAngle({0, kPi / 2, 0}) * Vec3{0, 0, 1},
             {1, 0, 0}, kRounding);
}

TEST(Rotation3, FromAxisAngleMatchesTheHalfAngleFormula) {
  const Rotation3 q = Rotation3::FromAxisAngle({0, 0.6, 0});
  EXPECT_NEAR(q.w, std::cos(0.3), kRounding);
  EXPECT_NEAR(q.x, 0, kRounding);
  EXPECT_NEAR(q.y, std::sin(0.3), kRounding);
  EXPECT_NEAR(q.z, 0, kRounding);
}

TEST(Rotation3, MatrixRotatesLikeTheQuaternion) {
  base::Random random(1, 0);
  for (int i = 0; i < 100; ++i) {
    const Rotation3 q = RandomRotation(random);
    const Vec3 v = RandomVector(random);
    ExpectNear(q.Matrix() * v, q * v, 10 * kRounding);
    EXPECT_NEAR(Norm(q * v), Norm(v), 10 * kRounding);
  }
}

TEST(Rotation3, FromMatrixInvertsMatrix) {
  base::Random random(1, 1);
  for (int i = 0; i < 1000; ++i) {
    const Rotation3 q = RandomRotation(random);
    EXPECT_LT(AngleBetween_rad(Rotation3::FromMatrix(q.Matrix()), q),
              10 * kRounding);
  }
}

TEST(Rotation3, FromMatrixHandlesHalfTurnsAboutEveryAxis) {
  // Here w = 0, and each axis takes another branch of Shepperd's method.
  const Vec3 axes[] = {{kPi, 0, 0}, {0, kPi, 0}, {0, 0, kPi}};
  for (const Vec3& axis : axes) {
    const Rotation3 q = Rotation3::FromAxisAngle(axis);
    EXPECT_LT(AngleBetween_rad(Rotation3::FromMatrix(q.Matrix()), q),
              10 * kRounding);
  }
}

TEST(Rotation3, ProductAppliesTheRightFactorFirst) {
  const Rotation3 about_x = Rotation3::FromAxisAngle({kPi / 2, 0, 0});
  const Rotation3 about_z = Rotation3::FromAxisAngle({0, 0, kPi / 2});
  // x goes to y about z, and y to z about x.
  ExpectNear((about_x * about_z) * Vec3{1, 0, 0}, {0, 0, 1}, kRounding);
  ExpectNear((about_z * about_x) * Vec3{1, 0, 0}, {0, 1, 0}, kRounding);
}

TEST(Rotation3, ProductMatchesTheMatrixProduct) {
  base::Random random(1, 2);
  for (int i = 0; i < 100; ++i) {
    const Rotation3 a = RandomRotation(random);
    const Rotation3 b = RandomRotation(random);
    const Mat3 product = (a * b).Matrix();
    const Mat3 expected = a.Matrix() * b.Matrix();
    for (size_t k = 0; k < 9; ++k) {
      EXPECT_NEAR(product.m[k], expected.m[k], 10 * kRounding);
    }
  }
}

TEST(Rotation3, InverseUndoesTheRotation) {
  base::Random random(1, 3);
  const Rotation3 q = RandomRotation(random);
  const Vec3 v = RandomVector(random);
  ExpectNear(q.Inverse() * (q * v), v, 10 * kRounding);
}

TEST(Rotation3, ToAxisAngleInvertsFromAxisAngle) {
  base::Random random(1, 4);
  for (double angle : {0.0, 1e-12, 1e-9, 1e-7, 1e-6, 1e-3, 0.5, 3.0, 3.1415}) {
    const Vec3 axis_angle = angle * Normalized(RandomVector(random));
    // Near pi the half angle's cosine carries the information.
    ExpectNear(ToAxisAngle(Rotation3::FromAxisAngle(axis_angle)), axis_angle,
               1e-15 + 4 * kRounding * angle);
  }
}

TEST(Rotation3, ToAxisAngleTakesTheShorterWay) {
  // 200 degrees about z are -160 degrees.
  const Vec3 v = ToAxisAngle(Rotation3::FromAxisAngle({0, 0, kPi * 200 / 180}));
  ExpectNear(v, {0, 0, -kPi * 160 / 180}, 10 * kRounding);
}

TEST(Rotation3, AngleBetweenIsExactForTinyAndForStraightAngles) {
  base::Random random(1, 5);
  const Rotation3 a = RandomRotation(random);
  for (double angle : {0.0, 1e-10, 1e-5, 1.0, kPi}) {
    const Rotation3 b = a * Rotation3::FromAxisAngle({0, angle, 0});
    // A double near 1 resolves 1e-16: the angle, not its cosine, is computed.
    EXPECT_NEAR(AngleBetween_rad(a, b), angle, 1e-14);
  }
}

TEST(Rotation3, AngleBetweenIgnoresTheSignOfTheQuaternion) {
  base::Random random(1, 6);
  const Rotation3 a = RandomRotation(random);
  const Rotation3 minus{-a.w, -a.x, -a.y, -a.z};
  EXPECT_NEAR(AngleBetween_rad(a, minus), 0, kRounding);
}

TEST(Rotation3, NormalizedHasUnitLengthAndNonNegativeW) {
  const Rotation3 q = Normalized(Rotation3{-2, 2, -2, 2});
  EXPECT_EQ(q, (Rotation3{0.5, -0.5, 0.5, -0.5}));
}

TEST(Slerp, MeetsBothEndsAndTurnsAtConstantRate) {
  const Rotation3 a = Rotation3::FromAxisAngle({0.1, 0, 0});
  const Rotation3 b = Rotation3::FromAxisAngle({0.9, 0, 0});
  for (double t : {0.0, 0.25, 0.5, 1.0}) {
    const Rotation3 expected = Rotation3::FromAxisAngle({0.1 + 0.8 * t, 0, 0});
    EXPECT_LT(AngleBetween_rad(Slerp(a, b, t), expected), kRounding);
  }
}

TEST(Slerp, TakesTheShorterArcWhateverTheSigns) {
  const Rotation3 a = Rotation3::FromAxisAngle({0, 0, 0.2});
  const Rotation3 b = Rotation3::FromAxisAngle({0, 0, 0.6});
  const Rotation3 minus_b{-b.w, -b.x, -b.y, -b.z};
  EXPECT_LT(AngleBetween_rad(Slerp(a, minus_b, 0.5),
                             Rotation3::FromAxisAngle({0, 0, 0.4})),
            kRounding);
}

TEST(Rigid3, RotatesThenTranslates) {
  const Rigid3 world_from_camera{Rotation3::FromAxisAngle({0, 0, kPi / 2}),
                                 {10, 20, 30}};
  ExpectNear(world_from_camera * Vec3{1, 2, 3}, {8, 21, 33}, 10 * kRounding);
}

TEST(Rigid3, ProductComposes) {
  base::Random random(2, 0);
  const Rigid3 a_from_b = RandomRigid(random);
  const Rigid3 b_from_c = RandomRigid(random);
  const Vec3 point_in_c = RandomVector(random);
  ExpectNear((a_from_b * b_from_c) * point_in_c,
             a_from_b * (b_from_c * point_in_c), 10 * kRounding);
}

TEST(Rigid3, InverseComposesToTheIdentityOnBothSides) {
  base::Random random(2, 1);
  for (int i = 0; i < 20; ++i) {
    const Rigid3 a = RandomRigid(random);
    for (const Rigid3& identity : {a * a.Inverse(), a.Inverse() * a}) {
      ExpectNear(identity.translation, {0, 0, 0}, 10 * kRounding);
      EXPECT_LT(AngleBetween_rad(identity.rotation, Rotation3{}),
                10 * kRounding);
    }
  }
}

TEST(RigidFromMatrix4, ReadsAnExactMatrix) {
  base::Random random(3, 0);
  const Rigid3 truth = RandomRigid(random);
  const absl::StatusOr<Rigid3> read =
      RigidFromMatrix4(Matrix4(truth.rotation.Matrix(), 1, truth.translation));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->translation, truth.translation);
  EXPECT_LT(AngleBetween_rad(read->rotation, truth.rotation), 1e-13);
}

TEST(RigidFromMatrix4, RemovesAScaleOfTheRotationAndKeepsTheTranslation) {
  base::Random random(3, 1);
  const Rigid3 truth = RandomRigid(random);
  for (double scale : {0.96, 0.999, 1.04}) {
    const absl::StatusOr<Rigid3> read = RigidFromMatrix4(
        Matrix4(truth.rotation.Matrix(), scale, truth.translation));
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(read->translation, truth.translation);
    EXPECT_LT(AngleBetween_rad(read->rotation, truth.rotation), 1e-13);
  }
}

TEST(RigidFromMatrix4, FindsTheNearestRotationToASkewedMatrix) {
  // A symmetric stretch S on the right of R is removed exactly: R S is a polar
  // decomposition.
  base::Random random(3, 2);
  const Rotation3 rotation = RandomRotation(random);
  const Mat3 stretch{{1.02, 0.01, 0, 0.01, 0.99, -0.005, 0, -0.005, 1.01}};
  const absl::StatusOr<Rigid3> read =
      RigidFromMatrix4(Matrix4(rotation.Matrix() * stretch, 1, {1, 2, 3}));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_LT(AngleBetween_rad(read->rotation, rotation), 1e-13);
}

TEST(RigidFromMatrix4, RefusesWhatIsNotRigid) {
  const Mat3 identity = Mat3::Identity();
  const auto code = [](const std::array<double, 16>& matrix) {
    return RigidFromMatrix4(matrix).status().code();
  };
  EXPECT_EQ(code(Matrix4(identity, 1.06, {})),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(code(Matrix4(identity, 0.94, {})),
            absl::StatusCode::kInvalidArgument);
  const Mat3 reflection{{1, 0, 0, 0, 1, 0, 0, 0, -1}};
  EXPECT_EQ(code(Matrix4(reflection, 1, {})),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(code(Matrix4(Mat3{}, 1, {})), absl::StatusCode::kInvalidArgument);
  std::array<double, 16> bad_row = Matrix4(identity, 1, {});
  bad_row[12] = 0.1;
  EXPECT_EQ(code(bad_row), absl::StatusCode::kInvalidArgument);
  bad_row = Matrix4(identity, 1, {});
  bad_row[15] = 2;
  EXPECT_EQ(code(bad_row), absl::StatusCode::kInvalidArgument);
}

TEST(RigidFromMatrix4, RefusesNanAndInfinityAnywhere) {
  for (size_t k = 0; k < 16; ++k) {
    for (double bad : {std::numeric_limits<double>::quiet_NaN(),
                       std::numeric_limits<double>::infinity()}) {
      std::array<double, 16> matrix = Matrix4(Mat3::Identity(), 1, {});
      matrix[k] = bad;
      const absl::Status status = RigidFromMatrix4(matrix).status();
      EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << k;
      EXPECT_THAT(std::string(status.message()), HasSubstr("NaN")) << k;
    }
  }
}

TEST(RigidFromQuaternion, NormalisesSmallRoundingErrors) {
  const absl::StatusOr<Rigid3> read =
      RigidFromQuaternion(0.995, 0, 0, 0, {1, 2, 3});
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_NEAR(read->rotation.w, 1, kRounding);
  EXPECT_EQ(read->translation, (Vec3{1, 2, 3}));
}

TEST(RigidFromQuaternion, RefusesBadNormsAndNan) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(RigidFromQuaternion(0.98, 0, 0, 0, {}).ok());
  EXPECT_FALSE(RigidFromQuaternion(1.02, 0, 0, 0, {}).ok());
  EXPECT_FALSE(RigidFromQuaternion(0, 0, 0, 0, {}).ok());
  EXPECT_FALSE(RigidFromQuaternion(nan, 0, 0, 1, {}).ok());
  EXPECT_FALSE(RigidFromQuaternion(1, 0, 0, 0, {0, nan, 0}).ok());
}

TEST(IsFinite, SeesEveryComponentOfATransform) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(IsFinite(Rigid3{}));
  EXPECT_FALSE(IsFinite(Rigid3{{nan, 0, 0, 0}, {}}));
  EXPECT_FALSE(IsFinite(Rigid3{{1, nan, 0, 0}, {}}));
  EXPECT_FALSE(IsFinite(Rigid3{{1, 0, nan, 0}, {}}));
  EXPECT_FALSE(IsFinite(Rigid3{{1, 0, 0, nan}, {}}));
  EXPECT_FALSE(IsFinite(Rigid3{{}, {0, 0, nan}}));
}

TEST(ErrorBetween, SeparatesTranslationAndRotation) {
  base::Random random(4, 0);
  const Rigid3 truth = RandomRigid(random);
  const Rigid3 estimate{truth.rotation * Rotation3::FromAxisAngle({0, 0.03, 0}),
                        truth.translation + Vec3{0.02, -0.01, 0.02}};
  const PoseError error = ErrorBetween(estimate, truth);
  EXPECT_NEAR(error.translation_m, 0.03, kRounding);
  EXPECT_NEAR(error.rotation_rad, 0.03, kRounding);
  const PoseError swapped = ErrorBetween(truth, estimate);
  EXPECT_NEAR(swapped.translation_m, error.translation_m, kRounding);
  EXPECT_NEAR(swapped.rotation_rad, error.rotation_rad, kRounding);
}

}  // namespace
}  // namespace treeline::geometry
