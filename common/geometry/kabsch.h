// The rigid transform between two sets of corresponding points.
#ifndef COMMON_GEOMETRY_KABSCH_H_
#define COMMON_GEOMETRY_KABSCH_H_

#include <optional>

#include "common/geometry/rigid3.h"

namespace treeline::geometry {

// Sums over correspondences (a_i, b_i) of weight w_i, each less an origin near
// them, so that large coordinates lose no digits.
struct CorrespondenceSums {
  int count = 0;
  double weight = 0;
  Vec3 origin_in_a;
  Vec3 origin_in_b;
  Vec3 sum_a;     // of w a
  Vec3 sum_b;     // of w b
  Mat3 products;  // of w a b^T
};

// Kabsch's transform from those sums; see below.
std::optional<Rigid3> SolveKabsch(const CorrespondenceSums& sums);

// Accumulates correspondences and solves
//   min over a_from_b of  sum_i w_i | a_from_b * b_i - a_i |^2
// (Kabsch 1976; the rotation by Horn's quaternion method, 1987).
class Kabsch {
 public:
  void Add(Vec3 point_in_a, Vec3 point_in_b, double weight = 1);
  // nullopt: fewer than three points, or all of them on a line.
  std::optional<Rigid3> Solve() const { return SolveKabsch(sums_); }

 private:
  CorrespondenceSums sums_;
};

}  // namespace treeline::geometry

#endif  // COMMON_GEOMETRY_KABSCH_H_
