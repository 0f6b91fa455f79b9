// How solvers score a model on many observations: in single precision, as a
// loop that compilers vectorise.
#ifndef SERVER_CORE_POSE_TRUNCATED_COST_H_
#define SERVER_CORE_POSE_TRUNCATED_COST_H_

#include <algorithm>
#include <cstddef>
#include <vector>

#include "common/geometry/rigid3.h"

namespace treeline::pose {

// Vectors as separate arrays.
struct PackedVectors {
  std::vector<float> x, y, z;

  void Reserve(size_t count) {
    for (std::vector<float>* array : {&x, &y, &z}) array->reserve(count);
  }
  void Add(geometry::Vec3 v) {
    x.push_back(static_cast<float>(v.x));
    y.push_back(static_cast<float>(v.y));
    z.push_back(static_cast<float>(v.z));
  }
};

// A rigid transform in single precision.
struct FloatTransform {
  explicit FloatTransform(const geometry::Rigid3& pose)
      : tx(static_cast<float>(pose.translation.x)),
        ty(static_cast<float>(pose.translation.y)),
        tz(static_cast<float>(pose.translation.z)) {
    const geometry::Mat3 r = pose.rotation.Matrix();
    for (size_t i = 0; i < 9; ++i) m[i] = static_cast<float>(r.m[i]);
  }
  float m[9];
  float tx, ty, tz;
};

// Sum over [begin, end) of min(1, squared_residual(i) / inlier_distance^2).
template <typename SquaredResidual>
double TruncatedCost(size_t begin, size_t end, double inlier_distance,
                     const SquaredResidual& squared_residual) {
  const float scale =
      static_cast<float>(1 / (inlier_distance * inlier_distance));
  // Eight partial sums in a fixed order: vectorisable, and the same on every
  // machine.
  float sums[8] = {};
  for (size_t base = begin; base < end; base += 8) {
    const size_t count = std::min<size_t>(8, end - base);
    for (size_t lane = 0; lane < count; ++lane) {
      sums[lane] += std::min(1.0f, squared_residual(base + lane) * scale);
    }
  }
  double cost = 0;
  for (const float sum : sums) cost += static_cast<double>(sum);
  return cost;
}

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_TRUNCATED_COST_H_
