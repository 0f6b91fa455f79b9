#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/pose/ray_kernels.cc"
#include "server/core/pose/ray_kernels.h"

#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"
#include "server/core/pose/parameters.h"
#include "server/core/pose/reprojection.h"

HWY_BEFORE_NAMESPACE();
namespace treeline::pose::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, 8>;
using V = hn::Vec<D>;

struct V3 {
  V x, y, z;
};

HWY_INLINE V Dot(const V3& a, const V3& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}

HWY_INLINE V3 Cross(const V3& a, const V3& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)),
          hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}

// Row i of a matrix.
HWY_INLINE V3 Row(const geometry::Mat3& m, size_t i) {
  const D d;
  return {hn::Set(d, m.m[3 * i]), hn::Set(d, m.m[3 * i + 1]),
          hn::Set(d, m.m[3 * i + 2])};
}

void Sum(const PackedRays& rays, const CameraFromWorld& camera_from_world,
         geometry::Vec3 position, double scale2, double reach2,
         RobustSum& sum) {
  const D d;
  const V zero = hn::Zero(d);
  const V one = hn::Set(d, 1);
  const V3 rows[3] = {Row(camera_from_world.r, 0), Row(camera_from_world.r, 1),
                      Row(camera_from_world.r, 2)};
  const geometry::Vec3& t = camera_from_world.t;
  V hessian[21];
  V gradient[6];
  for (V& h : hessian) h = zero;
  for (V& g : gradient) g = zero;
  V value = zero;
  V weights = zero;
  for (size_t i = 0; i < rays.size; i += hn::Lanes(d)) {
    const auto load = [&](const std::vector<double>& array)
                          HWY_ATTR { return hn::LoadU(d, array.data() + i); };
    const V3 point = {load(rays.x), load(rays.y), load(rays.z)};
    const V depth = hn::Add(Dot(rows[2], point), hn::Set(d, t.z));
    auto counts = hn::And(hn::FirstN(d, rays.size - i),
                          hn::Ge(depth, hn::Set(d, kMinPointDepth)));
    const V iz = hn::Div(one, hn::IfThenElse(counts, depth, one));
    const V x = hn::Mul(hn::Add(Dot(rows[0], point), hn::Set(d, t.x)), iz);
    const V y = hn::Mul(hn::Add(Dot(rows[1], point), hn::Set(d, t.y)), iz);
    const V rx = hn::Sub(x, load(rays.u));
    const V ry = hn::Sub(y, load(rays.v));
    const V squared = hn::MulAdd(rx, rx, hn::Mul(ry, ry));
    counts = hn::And(counts, hn::Le(squared, hn::Set(d, reach2)));
    if (hn::AllFalse(d, counts)) continue;
    const V root =
        hn::Div(hn::Set(d, scale2), hn::Add(hn::Set(d, scale2), squared));
    const V robust = hn::IfThenElseZero(counts, hn::Mul(root, root));
    // Derivatives of the projection by the point in the world.
    const auto derivative = [&](const V3& row, V at) HWY_ATTR {
      return V3{hn::Mul(iz, hn::NegMulAdd(at, rows[2].x, row.x)),
                hn::Mul(iz, hn::NegMulAdd(at, rows[2].y, row.y)),
                hn::Mul(iz, hn::NegMulAdd(at, rows[2].z, row.z))};
    };
    const V3 ax = derivative(rows[0], x);
    const V3 ay = derivative(rows[1], y);
    const V c[6] = {load(rays.covariance[0]), load(rays.covariance[1]),
                    load(rays.covariance[2]), load(rays.covariance[3]),
                    load(rays.covariance[4]), load(rays.covariance[5])};
    const auto spread = [&](const V3& v) HWY_ATTR {
      return V3{Dot({c[0], c[1], c[2]}, v), Dot({c[1], c[3], c[4]}, v),
                Dot({c[2], c[4], c[5]}, v)};
    };
    const V noise = load(rays.noise);
    const V3 spread_x = spread(ax);
    const V xx = hn::Add(Dot(ax, spread_x), noise);
    const V xy = Dot(ay, spread_x);
    const V yy = hn::Add(Dot(ay, spread(ay)), noise);
    const V determinant =
        hn::IfThenElse(counts, hn::Sub(hn::Mul(xx, yy), hn::Mul(xy, xy)), one);
    const V scale = hn::Div(robust, determinant);
    const V wxx = hn::Mul(scale, yy);
    const V wxy = hn::Neg(hn::Mul(scale, xy));
    const V wyy = hn::Mul(scale, xx);
    // From the camera's position.
    const V3 q = {hn::Sub(point.x, hn::Set(d, position.x)),
                  hn::Sub(point.y, hn::Set(d, position.y)),
                  hn::Sub(point.z, hn::Set(d, position.z))};
    const V3 turn_x = Cross(ax, q);
    const V3 turn_y = Cross(ay, q);
    const V jx[6] = {hn::Neg(ax.x), hn::Neg(ax.y), hn::Neg(ax.z),
                     turn_x.x,      turn_x.y,      turn_x.z};
    const V jy[6] = {hn::Neg(ay.x), hn::Neg(ay.y), hn::Neg(ay.z),
                     turn_y.x,      turn_y.y,      turn_y.z};
    size_t k = 0;
    for (size_t a = 0; a < 6; ++a) {
      const V wx = hn::MulAdd(wxx, jx[a], hn::Mul(wxy, jy[a]));
      const V wy = hn::MulAdd(wxy, jx[a], hn::Mul(wyy, jy[a]));
      for (size_t b = a; b < 6; ++b, ++k) {
        hessian[k] = hn::MulAdd(wx, jx[b], hn::MulAdd(wy, jy[b], hessian[k]));
      }
      gradient[a] = hn::MulAdd(wx, rx, hn::MulAdd(wy, ry, gradient[a]));
    }
    const V wrx = hn::MulAdd(wxx, rx, hn::Mul(wxy, ry));
    const V wry = hn::MulAdd(wxy, rx, hn::Mul(wyy, ry));
    value = hn::MulAdd(rx, wrx, hn::MulAdd(ry, wry, value));
    weights = hn::Add(weights, robust);
  }
  const auto total = [&](V v)
                         HWY_ATTR { return hn::GetLane(hn::SumOfLanes(d, v)); };
  size_t k = 0;
  for (size_t a = 0; a < 6; ++a) {
    for (size_t b = a; b < 6; ++b, ++k) {
      sum.equations.hessian[6 * a + b] = total(hessian[k]);
    }
    sum.equations.gradient[a] = total(gradient[a]);
  }
  sum.value = total(value);
  sum.weights = total(weights);
}

}  // namespace treeline::pose::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeline::pose {
namespace {

HWY_EXPORT(Sum);

// The widest vector.
constexpr size_t kLanes = 8;

}  // namespace

PackedRays::PackedRays(const RayPredictions& scene) : size(scene.size()) {
  const size_t padded = size + kLanes;
  for (std::vector<double>* array : {&u, &v, &noise, &x, &y, &z}) {
    array->resize(padded);
  }
  for (std::vector<double>& array : covariance) array.resize(padded);
  for (size_t i = 0; i < size; ++i) {
    const ScenePrediction& prediction = scene.at(i, 0);
    u[i] = scene.ray[i].x;
    v[i] = scene.ray[i].y;
    noise[i] = scene.ray_sigma[i] * scene.ray_sigma[i];
    x[i] = prediction.mean_in_world.x;
    y[i] = prediction.mean_in_world.y;
    z[i] = prediction.mean_in_world.z;
    for (size_t k = 0; k < 6; ++k) covariance[k][i] = prediction.covariance[k];
  }
}

RobustSum SumRays(const PackedRays& rays,
                  const geometry::Rigid3& world_from_camera, double scale) {
  RobustSum sum;
  const double scale2 = scale * scale;
  HWY_DYNAMIC_DISPATCH(Sum)
  (rays, CameraFromWorld(world_from_camera.Inverse()),
   world_from_camera.translation, scale2, kRobustReach * kRobustReach * scale2,
   sum);
  sum.residuals = 2 * sum.weights;
  return sum;
}

}  // namespace treeline::pose
#endif  // HWY_ONCE
