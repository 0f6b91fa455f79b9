#include "common/geometry/kabsch.h"

#include <array>
#include <cmath>

#include "Eigen/Eigenvalues"

namespace treeline::geometry {
namespace {

using Symmetric4 = std::array<std::array<double, 4>, 4>;

// Horn's matrix of s(i, j) = sum w b_i a_j: its largest eigenvector is the
// rotation as a quaternion (w, x, y, z).
Symmetric4 HornMatrix(const Mat3& s) {
  Symmetric4 n;
  n[0] = {s(0, 0) + s(1, 1) + s(2, 2), s(1, 2) - s(2, 1), s(2, 0) - s(0, 2),
          s(0, 1) - s(1, 0)};
  n[1] = {n[0][1], s(0, 0) - s(1, 1) - s(2, 2), s(0, 1) + s(1, 0),
          s(2, 0) + s(0, 2)};
  n[2] = {n[0][2], n[1][2], s(1, 1) - s(0, 0) - s(2, 2), s(1, 2) + s(2, 1)};
  n[3] = {n[0][3], n[1][3], n[2][3], s(2, 2) - s(0, 0) - s(1, 1)};
  return n;
}

// The minors of two rows: columns 01, 02, 03, 12, 13, 23.
std::array<double, 6> Minors(const std::array<double, 4>& a,
                             const std::array<double, 4>& b) {
  return {a[0] * b[1] - b[0] * a[1], a[0] * b[2] - b[0] * a[2],
          a[0] * b[3] - b[0] * a[3], a[1] * b[2] - b[1] * a[2],
          a[1] * b[3] - b[1] * a[3], a[2] * b[3] - b[2] * a[3]};
}

double Determinant(const Symmetric4& m) {
  const auto s = Minors(m[0], m[1]);
  const auto c = Minors(m[2], m[3]);
  return s[0] * c[5] - s[1] * c[4] + s[2] * c[3] + s[3] * c[2] - s[4] * c[1] +
         s[5] * c[0];
}

// A multiple of the vector that the singular matrix m takes to zero: the row of
// its adjugate with the largest entry on the diagonal.
std::array<double, 4> KernelOf(const Symmetric4& m) {
  const auto s = Minors(m[0], m[1]);
  const auto c = Minors(m[2], m[3]);
  const Symmetric4 adjugate = {{
      {m[1][1] * c[5] - m[1][2] * c[4] + m[1][3] * c[3],
       -m[0][1] * c[5] + m[0][2] * c[4] - m[0][3] * c[3],
       m[3][1] * s[5] - m[3][2] * s[4] + m[3][3] * s[3],
       -m[2][1] * s[5] + m[2][2] * s[4] - m[2][3] * s[3]},
      {-m[1][0] * c[5] + m[1][2] * c[2] - m[1][3] * c[1],
       m[0][0] * c[5] - m[0][2] * c[2] + m[0][3] * c[1],
       -m[3][0] * s[5] + m[3][2] * s[2] - m[3][3] * s[1],
       m[2][0] * s[5] - m[2][2] * s[2] + m[2][3] * s[1]},
      {m[1][0] * c[4] - m[1][1] * c[2] + m[1][3] * c[0],
       -m[0][0] * c[4] + m[0][1] * c[2] - m[0][3] * c[0],
       m[3][0] * s[4] - m[3][1] * s[2] + m[3][3] * s[0],
       -m[2][0] * s[4] + m[2][1] * s[2] - m[2][3] * s[0]},
      {-m[1][0] * c[3] + m[1][1] * c[1] - m[1][2] * c[0],
       m[0][0] * c[3] - m[0][1] * c[1] + m[0][2] * c[0],
       -m[3][0] * s[3] + m[3][1] * s[1] - m[3][2] * s[0],
       m[2][0] * s[3] - m[2][1] * s[1] + m[2][2] * s[0]},
  }};
  size_t largest = 0;
  for (size_t i = 1; i < 4; ++i) {
    if (std::abs(adjugate[i][i]) > std::abs(adjugate[largest][largest])) {
      largest = i;
    }
  }
  return adjugate[largest];
}

// The largest root of Horn's characteristic polynomial by Newton's method
// (Theobald 2005), in a tenth of the time of an eigendecomposition. nullopt
// where the next root is so near that digits would be lost.
std::optional<Rotation3> RotationByNewton(const Mat3& s, Symmetric4 n) {
  constexpr int kMaxSteps = 30;
  constexpr double kMinSlope = 1e-3;
  double squares = 0;
  for (const double entry : s.m) squares += entry * entry;
  const double determinant = s(0, 0) * (s(1, 1) * s(2, 2) - s(1, 2) * s(2, 1)) -
                             s(0, 1) * (s(1, 0) * s(2, 2) - s(1, 2) * s(2, 0)) +
                             s(0, 2) * (s(1, 0) * s(2, 1) - s(1, 1) * s(2, 0));
  const double c2 = -2 * squares;
  const double c1 = -8 * determinant;
  const double c0 = Determinant(n);
  // All roots are real, and this is none less than the largest: the steps go
  // down to it.
  double root = std::sqrt(3 * squares);
  double slope = 0;
  for (int i = 0; i < kMaxSteps; ++i) {
    const double root2 = root * root;
    slope = (4 * root2 + 2 * c2) * root + c1;
    const double value = (root2 + c2) * root2 + c1 * root + c0;
    const double step = value / slope;
    root -= step;
    if (!(std::abs(step) > 1e-14 * root)) break;
  }
  if (!(slope > kMinSlope * root * root * root) || !(root > 0)) {
    return std::nullopt;
  }
  for (size_t i = 0; i < 4; ++i) n[i][i] -= root;
  const auto [w, x, y, z] = KernelOf(n);
  return Normalized(Rotation3{w, x, y, z});
}

std::optional<Rotation3> RotationByEigenvalues(const Symmetric4& n) {
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      matrix(i, j) = n[static_cast<size_t>(i)][static_cast<size_t>(j)];
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(matrix);
  // The two largest eigenvalues coincide when the points lie on a line: then
  // any rotation about it does.
  const Eigen::Vector4d& values = solver.eigenvalues();
  if (!(values[3] - values[2] > 1e-9 * values[3])) return std::nullopt;
  const Eigen::Vector4d q = solver.eigenvectors().col(3);
  return Normalized(Rotation3{q[0], q[1], q[2], q[3]});
}

}  // namespace

void Kabsch::Add(Vec3 point_in_a, Vec3 point_in_b, double weight) {
  if (sums_.count == 0) {
    sums_.origin_in_a = point_in_a;
    sums_.origin_in_b = point_in_b;
  }
  ++sums_.count;
  const Vec3 a = point_in_a - sums_.origin_in_a;
  const Vec3 b = point_in_b - sums_.origin_in_b;
  const Vec3 wa = weight * a;
  sums_.weight += weight;
  sums_.sum_a = sums_.sum_a + wa;
  sums_.sum_b = sums_.sum_b + weight * b;
  for (int j = 0; j < 3; ++j) {
    sums_.products(0, j) += wa.x * b[j];
    sums_.products(1, j) += wa.y * b[j];
    sums_.products(2, j) += wa.z * b[j];
  }
}

std::optional<Rigid3> SolveKabsch(const CorrespondenceSums& sums) {
  if (sums.count < 3 || !(sums.weight > 0)) return std::nullopt;
  const Vec3 mean_a = sums.sum_a / sums.weight;
  const Vec3 mean_b = sums.sum_b / sums.weight;
  Mat3 s;  // covariance of b with a: s(i, j) = sum w b_i a_j
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      s(i, j) = sums.products(j, i) - sums.weight * mean_a[j] * mean_b[i];
    }
  }
  const Symmetric4 n = HornMatrix(s);
  std::optional<Rotation3> rotation = RotationByNewton(s, n);
  if (!rotation) rotation = RotationByEigenvalues(n);
  if (!rotation) return std::nullopt;
  return Rigid3{*rotation, (sums.origin_in_a + mean_a) -
                               *rotation * (sums.origin_in_b + mean_b)};
}

}  // namespace treeline::geometry
