// The terms that a pose is refined with: points on points, and points on
// lines (thesis 5.5). docs/explanation/points-and-lines.md derives them.
#ifndef SERVER_CORE_POSE_NORMAL_EQUATIONS_H_
#define SERVER_CORE_POSE_NORMAL_EQUATIONS_H_

#include <array>

#include "common/geometry/rigid3.h"

namespace treeline::pose {

// A symmetric 3 x 3 matrix: xx xy xz yy yz zz.
using Symmetric3 = std::array<double, 6>;

// Of a matrix that has one.
Symmetric3 Inverse(const Symmetric3& a);

double Determinant(const Symmetric3& a);

// v^T a v.
double QuadraticForm(const Symmetric3& a, geometry::Vec3 v);

// What `information` W knows across a direction d (any length but zero), in
// the same frame:
//   W - W d d^T W / (d^T W d).
// r^T (this) r = min over t of (r - t d)^T W (r - t d): the squared
// Mahalanobis distance of a point to a line. d is in its kernel.
Symmetric3 AcrossLine(const Symmetric3& information, geometry::Vec3 direction);

// Normal equations of a pose: for a change (translation, rotation) of
// world_from_camera as in PoseCovariance, the energy E of the terms so far is
//   E + 2 gradient . change + change^T hessian change
// up to second order (Gauss-Newton).
struct NormalEquations {
  // Row-major 6 x 6; entries below the diagonal blocks are not set.
  std::array<double, 36> hessian{};
  std::array<double, 6> gradient{};

  // Adds r^T W r with r = world_from_camera * x - m, where rotated = R x:
  // dr/d(translation) = I, dr/d(rotation) = -[R x]x. For a point on a line W is
  // AcrossLine(W, R d), and x the line's point next to m (ClosestOnLine).
  void Add(const Symmetric3& information, geometry::Vec3 rotated,
           geometry::Vec3 residual);
};

// The t for which residual + t * direction has the least Mahalanobis norm: the
// line's point next to the prediction is t * direction from where `residual`
// was taken.
double ClosestOnLine(const Symmetric3& information, geometry::Vec3 residual,
                     geometry::Vec3 direction);

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_NORMAL_EQUATIONS_H_
