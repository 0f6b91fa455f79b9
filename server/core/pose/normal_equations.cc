#include "server/core/pose/normal_equations.h"

namespace treeline::pose {
namespace {

geometry::Vec3 Times(const Symmetric3& a, geometry::Vec3 v) {
  return {a[0] * v.x + a[1] * v.y + a[2] * v.z,
          a[1] * v.x + a[3] * v.y + a[4] * v.z,
          a[2] * v.x + a[4] * v.y + a[5] * v.z};
}

}  // namespace

Symmetric3 Inverse(const Symmetric3& a) {
  const double xx = a[3] * a[5] - a[4] * a[4];
  const double xy = a[2] * a[4] - a[1] * a[5];
  const double xz = a[1] * a[4] - a[2] * a[3];
  const double d = 1 / (a[0] * xx + a[1] * xy + a[2] * xz);
  return {d * xx,
          d * xy,
          d * xz,
          d * (a[0] * a[5] - a[2] * a[2]),
          d * (a[1] * a[2] - a[0] * a[4]),
          d * (a[0] * a[3] - a[1] * a[1])};
}

double Determinant(const Symmetric3& a) {
  return a[0] * (a[3] * a[5] - a[4] * a[4]) +
         a[1] * (a[2] * a[4] - a[1] * a[5]) +
         a[2] * (a[1] * a[4] - a[2] * a[3]);
}

double QuadraticForm(const Symmetric3& a, geometry::Vec3 v) {
  return a[0] * v.x * v.x + a[3] * v.y * v.y + a[5] * v.z * v.z +
         2 * (a[1] * v.x * v.y + a[2] * v.x * v.z + a[4] * v.y * v.z);
}

Symmetric3 AcrossLine(const Symmetric3& information, geometry::Vec3 direction) {
  const geometry::Vec3 wd = Times(information, direction);
  const double scale = 1 / geometry::Dot(direction, wd);
  Symmetric3 across = information;
  across[0] -= scale * wd.x * wd.x;
  across[1] -= scale * wd.x * wd.y;
  across[2] -= scale * wd.x * wd.z;
  across[3] -= scale * wd.y * wd.y;
  across[4] -= scale * wd.y * wd.z;
  across[5] -= scale * wd.z * wd.z;
  return across;
}

double ClosestOnLine(const Symmetric3& information, geometry::Vec3 residual,
                     geometry::Vec3 direction) {
  const geometry::Vec3 wd = Times(information, direction);
  return -geometry::Dot(wd, residual) / geometry::Dot(wd, direction);
}

void NormalEquations::Add(const Symmetric3& w, geometry::Vec3 q,
                          geometry::Vec3 r) {
  const double wm[3][3] = {
      {w[0], w[1], w[2]}, {w[1], w[3], w[4]}, {w[2], w[4], w[5]}};
  // The derivative of Exp(a) q by a is -[q]x.
  const double b[3][3] = {{0, q.z, -q.y}, {-q.z, 0, q.x}, {q.y, -q.x, 0}};
  double wb[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      wb[i][j] = wm[i][0] * b[0][j] + wm[i][1] * b[1][j] + wm[i][2] * b[2][j];
    }
  }
  const double rr[3] = {r.x, r.y, r.z};
  double wr[3];
  for (int i = 0; i < 3; ++i) {
    wr[i] = wm[i][0] * rr[0] + wm[i][1] * rr[1] + wm[i][2] * rr[2];
  }
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) {
      hessian[6 * i + j] += wm[i][j];
      hessian[6 * i + 3 + j] += wb[i][j];
      hessian[6 * (3 + i) + 3 + j] +=
          b[0][i] * wb[0][j] + b[1][i] * wb[1][j] + b[2][i] * wb[2][j];
    }
    gradient[i] += wr[i];
    gradient[3 + i] += b[0][i] * wr[0] + b[1][i] * wr[1] + b[2][i] * wr[2];
  }
}

}  // namespace treeline::pose
