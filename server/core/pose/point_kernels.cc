#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/pose/point_kernels.cc"
#include "server/core/pose/point_kernels.h"

#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"

// What all targets share.
#ifndef TREELINE_POINT_KERNELS_SHARED_
#define TREELINE_POINT_KERNELS_SHARED_

namespace treeline::pose {

struct FloatSums {
  float count = 0;
  float a[3] = {};
  float b[3] = {};
  float products[9] = {};  // a b^T, row by row
};

}  // namespace treeline::pose

#endif  // TREELINE_POINT_KERNELS_SHARED_

HWY_BEFORE_NAMESPACE();
namespace treeline::pose::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;

struct V3 {
  V x, y, z;
};

HWY_INLINE V3 Load3(const PackedVectors& points, size_t i) {
  const D d;
  return {hn::LoadU(d, points.x.data() + i), hn::LoadU(d, points.y.data() + i),
          hn::LoadU(d, points.z.data() + i)};
}

// From where the points are thought to be to where the pose takes them.
HWY_INLINE V3 Residual(const FloatTransform& p, const V3& camera,
                       const V3& world) {
  const D d;
  const auto row = [&](size_t i, float t, V to) HWY_ATTR {
    return hn::MulAdd(hn::Set(d, p.m[i]), camera.x,
                      hn::MulAdd(hn::Set(d, p.m[i + 1]), camera.y,
                                 hn::MulAdd(hn::Set(d, p.m[i + 2]), camera.z,
                                            hn::Sub(hn::Set(d, t), to))));
  };
  return {row(0, p.tx, world.x), row(3, p.ty, world.y), row(6, p.tz, world.z)};
}

HWY_INLINE V SquaredNorm(const V3& v) {
  return hn::MulAdd(v.x, v.x, hn::MulAdd(v.y, v.y, hn::Mul(v.z, v.z)));
}

HWY_INLINE float Sum(V v) { return hn::GetLane(hn::SumOfLanes(D(), v)); }

float Cost(const PackedPairs& pairs, size_t begin, size_t end,
           const FloatTransform& p, float scale) {
  const D d;
  const V one = hn::Set(d, 1);
  V cost = hn::Zero(d);
  for (size_t i = begin; i < end; i += hn::Lanes(d)) {
    const auto inside = hn::FirstN(d, end - i);
    const V squared = SquaredNorm(
        Residual(p, Load3(pairs.in_camera, i), Load3(pairs.in_world, i)));
    cost = hn::Add(
        cost, hn::IfThenElseZero(
                  inside, hn::Min(one, hn::Mul(squared, hn::Set(d, scale)))));
  }
  return Sum(cost);
}

void AddInliers(const PackedPairs& pairs, size_t end, const FloatTransform& p,
                const float* origin, float limit, FloatSums& sums) {
  const D d;
  const V one = hn::Set(d, 1);
  V count = hn::Zero(d);
  V sum_a[3];
  V sum_b[3];
  V products[9];
  for (V& v : sum_a) v = hn::Zero(d);
  for (V& v : sum_b) v = hn::Zero(d);
  for (V& v : products) v = hn::Zero(d);
  for (size_t i = 0; i < end; i += hn::Lanes(d)) {
    const auto inside = hn::FirstN(d, end - i);
    const V3 camera = Load3(pairs.in_camera, i);
    const V3 world = Load3(pairs.in_world, i);
    const auto taken = hn::And(
        inside,
        hn::Le(SquaredNorm(Residual(p, camera, world)), hn::Set(d, limit)));
    const V a[3] = {
        hn::IfThenElseZero(taken, hn::Sub(world.x, hn::Set(d, origin[0]))),
        hn::IfThenElseZero(taken, hn::Sub(world.y, hn::Set(d, origin[1]))),
        hn::IfThenElseZero(taken, hn::Sub(world.z, hn::Set(d, origin[2])))};
    const V b[3] = {hn::IfThenElseZero(taken, camera.x),
                    hn::IfThenElseZero(taken, camera.y),
                    hn::IfThenElseZero(taken, camera.z)};
    count = hn::Add(count, hn::IfThenElseZero(taken, one));
    for (size_t r = 0; r < 3; ++r) {
      sum_a[r] = hn::Add(sum_a[r], a[r]);
      sum_b[r] = hn::Add(sum_b[r], b[r]);
      for (size_t c = 0; c < 3; ++c) {
        products[3 * r + c] = hn::MulAdd(a[r], b[c], products[3 * r + c]);
      }
    }
  }
  sums.count = Sum(count);
  for (size_t r = 0; r < 3; ++r) {
    sums.a[r] = Sum(sum_a[r]);
    sums.b[r] = Sum(sum_b[r]);
  }
  for (size_t k = 0; k < 9; ++k) sums.products[k] = Sum(products[k]);
}

}  // namespace treeline::pose::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeline::pose {

HWY_EXPORT(Cost);
HWY_EXPORT(AddInliers);

void PackedPairs::Add(geometry::Vec3 point_in_camera,
                      geometry::Vec3 point_in_world) {
  in_camera.Add(point_in_camera);
  in_world.Add(point_in_world);
}

void PackedPairs::Reserve(size_t pairs) {
  in_camera.Reserve(pairs + kPairPadding);
  in_world.Reserve(pairs + kPairPadding);
}

void PackedPairs::Pad() {
  for (size_t i = 0; i < kPairPadding; ++i) Add({}, {});
}

double TruncatedDistances(const PackedPairs& pairs, size_t begin, size_t end,
                          const geometry::Rigid3& world_from_camera,
                          double inlier_distance_m) {
  return static_cast<double>(HWY_DYNAMIC_DISPATCH(Cost)(
      pairs, begin, end, FloatTransform(world_from_camera),
      static_cast<float>(1 / (inlier_distance_m * inlier_distance_m))));
}

geometry::CorrespondenceSums SumInliers(
    const PackedPairs& pairs, size_t end,
    const geometry::Rigid3& world_from_camera, double inlier_distance_m) {
  geometry::CorrespondenceSums sums;
  if (end == 0) return sums;
  const float origin[3] = {pairs.in_world.x[0], pairs.in_world.y[0],
                           pairs.in_world.z[0]};
  FloatSums s;
  HWY_DYNAMIC_DISPATCH(AddInliers)
  (pairs, end, FloatTransform(world_from_camera), origin,
   static_cast<float>(inlier_distance_m * inlier_distance_m), s);
  const auto vector = [](const float* v) {
    return geometry::Vec3{v[0], v[1], v[2]};
  };
  sums.count = static_cast<int>(s.count);
  sums.weight = static_cast<double>(s.count);
  sums.origin_in_a = vector(origin);
  sums.sum_a = vector(s.a);
  sums.sum_b = vector(s.b);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      sums.products(r, c) = static_cast<double>(s.products[3 * r + c]);
    }
  }
  return sums;
}

}  // namespace treeline::pose
#endif  // HWY_ONCE
