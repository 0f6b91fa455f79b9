// The rigid transform between two sets of corresponding points.
#ifndef COMMON_GEOMETRY_KABSCH_H_
#define COMMON_GEOMETRY_KABSCH_H_

#include <optional>

#include "common/geometry/rigid3.h"

namespace treeline::geometry {

// Accumulates correspondences and solves
//   min over a_from_b of  sum_i w_i | a_from_b * b_i - a_i |^2
// (Kabsch 1976; the rotation by Horn's quaternion method, 1987).
class Kabsch {
 public:
  void Add(Vec3 point_in_a, Vec3 point_in_b, double weight = 1);
  // nullopt: fewer than three points, or all of them on a line.
  std::optional<Rigid3> Solve() const;

 private:
  int count_ = 0;
  double weight_ = 0;
  // Relative to the first pair, so that large coordinates lose no digits.
  Vec3 origin_in_a_;
  Vec3 origin_in_b_;
  Vec3 sum_a_;
  Vec3 sum_b_;
  Mat3 products_;  // sum of w a b^T
};

}  // namespace treeline::geometry

#endif  // COMMON_GEOMETRY_KABSCH_H_
