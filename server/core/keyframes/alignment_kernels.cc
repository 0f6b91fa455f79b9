#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/keyframes/alignment_kernels.cc"
#include "server/core/keyframes/alignment_kernels.h"

#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"
#include "server/core/keyframes/parameters.h"

HWY_BEFORE_NAMESPACE();
namespace treeline::keyframes::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, kAlignmentBlock>;
using V = hn::Vec<D>;
using DI = hn::RebindToSigned<D>;

constexpr float kNearest_m = static_cast<float>(kMinPointDepth_m);
// A squared cosine.
constexpr float kMinFacing2 = kMinFacing * kMinFacing;

struct V3 {
  V x, y, z;
};

HWY_INLINE V Dot3(const V3& a, const V3& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}

HWY_INLINE V3 Load3(const std::vector<float>& x, const std::vector<float>& y,
                    const std::vector<float>& z, size_t i) {
  const D d;
  return {hn::LoadU(d, x.data() + i), hn::LoadU(d, y.data() + i),
          hn::LoadU(d, z.data() + i)};
}

// From the camera's position to the points.
HWY_INLINE V3 FromCamera(const V3& point, const PinholeView& view) {
  const D d;
  return {hn::Sub(point.x, hn::Set(d, view.position[0])),
          hn::Sub(point.y, hn::Set(d, view.position[1])),
          hn::Sub(point.z, hn::Set(d, view.position[2]))};
}

HWY_INLINE V3 Rotate(const PinholeView& view, const V3& q) {
  const D d;
  const auto& m = view.camera_from_world_rotation;
  const auto row = [&](size_t i) {
    return Dot3({hn::Set(d, m[i]), hn::Set(d, m[i + 1]), hn::Set(d, m[i + 2])},
                q);
  };
  return {row(0), row(3), row(6)};
}

// (scale^2 / (scale^2 + squared))^2.
HWY_INLINE V GemanMcClure(V squared, V scale2) {
  const V root = hn::Div(scale2, hn::Add(scale2, squared));
  return hn::Mul(root, root);
}

// In front of the camera and not seen at a grazing angle: q is p before its
// rotation, n the normal.
HWY_INLINE hn::Mask<D> Faces(const V3& q, const V3& p, const V3& n) {
  const D d;
  const V facing = hn::Neg(Dot3(n, q));
  const V limit =
      hn::Mul(hn::Set(d, kMinFacing2), hn::Mul(Dot3(q, q), Dot3(n, n)));
  return hn::And(hn::Gt(p.z, hn::Set(d, kNearest_m)),
                 hn::And(hn::Ge(facing, hn::Zero(d)),
                         hn::Ge(hn::Mul(facing, facing), limit)));
}

void See(const AlignmentPoints& points, size_t begin, size_t end,
         const PinholeView& view, VisiblePoints& seen) {
  const D d;
  const V one = hn::Set(d, 1);
  for (size_t i = begin; i < end; i += hn::Lanes(d)) {
    const V3 q = FromCamera(Load3(points.x, points.y, points.z, i), view);
    const V3 n = Load3(points.nx, points.ny, points.nz, i);
    const V3 p = Rotate(view, q);
    const auto visible = Faces(q, p, n);
    const V x = hn::IfThenElseZero(visible, p.x);
    const V y = hn::IfThenElseZero(visible, p.y);
    const V z = hn::IfThenElse(visible, p.z, one);
    const V iz = hn::Div(one, z);
    hn::StoreU(x, d, seen.x.data() + i);
    hn::StoreU(y, d, seen.y.data() + i);
    hn::StoreU(z, d, seen.z.data() + i);
    hn::StoreU(
        hn::MulAdd(hn::Set(d, view.fx), hn::Mul(x, iz), hn::Set(d, view.cx)), d,
        seen.u.data() + i);
    hn::StoreU(
        hn::MulAdd(hn::Set(d, view.fy), hn::Mul(y, iz), hn::Set(d, view.cy)), d,
        seen.v.data() + i);
    hn::StoreU(hn::IfThenElseZero(visible, one), d, seen.seen.data() + i);
  }
}

void Count(const AlignmentPoints& points, size_t group, const PinholeView& view,
           int width, int height, float* counts) {
  const D d;
  const V one = hn::Set(d, 1);
  const V fx = hn::Set(d, view.fx);
  const V fy = hn::Set(d, view.fy);
  const V cx = hn::Set(d, view.cx);
  const V cy = hn::Set(d, view.cy);
  const V right = hn::Set(d, static_cast<float>(width));
  const V bottom = hn::Set(d, static_cast<float>(height));
  for (size_t begin = 0; begin < points.size(); begin += group) {
    V count = hn::Zero(d);
    for (size_t i = begin; i < begin + group; i += hn::Lanes(d)) {
      const V3 q = FromCamera(Load3(points.x, points.y, points.z, i), view);
      const V3 p = Rotate(view, q);
      // Pixels times depth, so that nothing is divided.
      const V u = hn::MulAdd(fx, p.x, hn::Mul(cx, p.z));
      const V v = hn::MulAdd(fy, p.y, hn::Mul(cy, p.z));
      const auto inside =
          hn::And(hn::And(hn::Gt(u, hn::Zero(d)), hn::Gt(v, hn::Zero(d))),
                  hn::And(hn::Lt(u, hn::Mul(right, p.z)),
                          hn::Lt(v, hn::Mul(bottom, p.z))));
      const auto faces = Faces(q, p, Load3(points.nx, points.ny, points.nz, i));
      count = hn::Add(count, hn::IfThenElseZero(hn::And(inside, faces), one));
    }
    *counts++ = hn::GetLane(hn::SumOfLanes(d, count));
  }
}

// Three pixels of a row that begins half a pixel left of a position.
struct Row {
  V value;
  V gradient;
};
HWY_INLINE Row ReadRow(hn::Vec<DI> bytes, V f) {
  const D d;
  const DI di;
  const auto mask = hn::Set(di, 255);
  const V a = hn::ConvertTo(d, hn::And(bytes, mask));
  const V b = hn::ConvertTo(d, hn::And(hn::ShiftRight<8>(bytes), mask));
  const V c = hn::ConvertTo(d, hn::And(hn::ShiftRight<16>(bytes), mask));
  const V ab = hn::Sub(b, a);
  const V bc = hn::Sub(c, b);
  const V half = hn::Set(d, 0.5f);
  const V shifted = hn::Sub(f, half);
  // The position lies left or right of the middle pixel.
  const V slope = hn::IfThenElse(hn::Lt(shifted, hn::Zero(d)), ab, bc);
  return {hn::MulAdd(shifted, slope, b), hn::MulAdd(f, hn::Sub(bc, ab), ab)};
}

// The same down a column of three values.
HWY_INLINE V Between(V top, V middle, V bottom, V f) {
  const D d;
  const V shifted = hn::Sub(f, hn::Set(d, 0.5f));
  const V slope = hn::IfThenElse(hn::Lt(shifted, hn::Zero(d)),
                                 hn::Sub(middle, top), hn::Sub(bottom, middle));
  return hn::MulAdd(shifted, slope, middle);
}

int LookUp(const uint8_t* gray, int width, int height, int level, size_t begin,
           size_t end, VisiblePoints& seen) {
  const D d;
  V count = hn::Zero(d);
  const DI di;
  const V half = hn::Set(d, 0.5f);
  const V one = hn::Set(d, 1);
  const V least = hn::Set(d, 1.5f);
  const V shrink = hn::Set(d, 1.0f / static_cast<float>(1 << level));
  const V right = hn::Set(d, static_cast<float>(width) - 2.5f);
  const V bottom = hn::Set(d, static_cast<float>(height) - 2.5f);
  const auto stride = hn::Set(di, width);
  for (size_t i = begin; i < end; i += hn::Lanes(d)) {
    // Half a pixel up and left; see AtLevel.
    const V x = hn::Sub(
        hn::Mul(hn::Add(hn::LoadU(d, seen.u.data() + i), half), shrink), one);
    const V y = hn::Sub(
        hn::Mul(hn::Add(hn::LoadU(d, seen.v.data() + i), half), shrink), one);
    const auto inside = hn::And(hn::And(hn::Gt(hn::Add(x, half), least),
                                        hn::Gt(hn::Add(y, half), least)),
                                hn::And(hn::Lt(hn::Add(x, half), right),
                                        hn::Lt(hn::Add(y, half), bottom)));
    const auto visible = hn::And(
        inside, hn::Gt(hn::LoadU(d, seen.seen.data() + i), hn::Zero(d)));
    const V safe_x = hn::IfThenElseZero(visible, x);
    const V safe_y = hn::IfThenElseZero(visible, y);
    const auto x0 = hn::ConvertTo(di, safe_x);
    const auto y0 = hn::ConvertTo(di, safe_y);
    const V fx = hn::Sub(safe_x, hn::ConvertTo(d, x0));
    const V fy = hn::Sub(safe_y, hn::ConvertTo(d, y0));
    const auto offset = hn::Add(hn::Mul(y0, stride), x0);
    const auto* base = reinterpret_cast<const int32_t*>(gray);
    const Row r0 = ReadRow(hn::GatherOffset(di, base, offset), fx);
    const Row r1 =
        ReadRow(hn::GatherOffset(di, base, hn::Add(offset, stride)), fx);
    const Row r2 = ReadRow(
        hn::GatherOffset(di, base, hn::Add(offset, hn::Add(stride, stride))),
        fx);
    const V brightness = Between(r0.value, r1.value, r2.value, fy);
    const V gx = Between(r0.gradient, r1.gradient, r2.gradient, fy);
    const V upper = hn::Sub(r1.value, r0.value);
    const V lower = hn::Sub(r2.value, r1.value);
    const V gy = hn::MulAdd(fy, hn::Sub(lower, upper), upper);
    hn::StoreU(hn::IfThenElseZero(visible, brightness), d,
               seen.brightness.data() + i);
    hn::StoreU(hn::IfThenElseZero(visible, hn::Mul(gx, shrink)), d,
               seen.gradient_x.data() + i);
    hn::StoreU(hn::IfThenElseZero(visible, hn::Mul(gy, shrink)), d,
               seen.gradient_y.data() + i);
    const V ones = hn::IfThenElseZero(visible, one);
    hn::StoreU(ones, d, seen.seen.data() + i);
    count = hn::Add(count, ones);
  }
  return static_cast<int>(hn::GetLane(hn::SumOfLanes(d, count)));
}

ExposureSums Exposure(const float* reference, const VisiblePoints& seen,
                      size_t begin, size_t end, float gain, float offset,
                      float scale) {
  const D d;
  const V middle = hn::Set(d, 128);
  const V scale2 = hn::Set(d, scale * scale);
  // Of values less 128: b - gain * a - offset + 128 (1 - gain).
  const V shift = hn::Set(d, offset + 128 * (gain - 1));
  V w = hn::Zero(d), x = w, y = w, xx = w, xy = w;
  for (size_t i = begin; i < end; i += hn::Lanes(d)) {
    const V a = hn::Sub(hn::LoadU(d, reference + i), middle);
    const V b = hn::Sub(hn::LoadU(d, seen.brightness.data() + i), middle);
    const V r = hn::Sub(hn::Sub(b, hn::Mul(hn::Set(d, gain), a)), shift);
    const V weight = hn::Mul(GemanMcClure(hn::Mul(r, r), scale2),
                             hn::LoadU(d, seen.seen.data() + i));
    const V wa = hn::Mul(weight, a);
    w = hn::Add(w, weight);
    x = hn::Add(x, wa);
    y = hn::MulAdd(weight, b, y);
    xx = hn::MulAdd(wa, a, xx);
    xy = hn::MulAdd(wa, b, xy);
  }
  const auto sum = [&](V v) { return hn::GetLane(hn::SumOfLanes(d, v)); };
  return {sum(w), sum(x), sum(y), sum(xx), sum(xy)};
}

// Partial sums of NormalSums.
struct Partial {
  V h[21];
  V g[6];
  Partial() {
    for (V& v : h) v = hn::Zero(D());
    for (V& v : g) v = hn::Zero(D());
  }

  // A residual with derivative j with respect to the point p in the camera.
  HWY_INLINE void Add(const V3& p, const V3& j, V residual, V weight) {
    const V row[6] = {j.x,
                      j.y,
                      j.z,
                      hn::Sub(hn::Mul(p.y, j.z), hn::Mul(p.z, j.y)),
                      hn::Sub(hn::Mul(p.z, j.x), hn::Mul(p.x, j.z)),
                      hn::Sub(hn::Mul(p.x, j.y), hn::Mul(p.y, j.x))};
    size_t k = 0;
    for (size_t a = 0; a < 6; ++a) {
      const V wa = hn::Mul(weight, row[a]);
      for (size_t b = a; b < 6; ++b, ++k) h[k] = hn::MulAdd(wa, row[b], h[k]);
      g[a] = hn::MulAdd(wa, residual, g[a]);
    }
  }

  void AddTo(NormalSums& sums) const {
    const D d;
    const auto sum = [&](V v) {
      return static_cast<double>(hn::GetLane(hn::SumOfLanes(d, v)));
    };
    for (size_t k = 0; k < 21; ++k) sums.h[k] += sum(h[k]);
    for (size_t k = 0; k < 6; ++k) sums.g[k] += sum(g[k]);
  }
};

void Brightness(const float* reference, const VisiblePoints& seen, size_t begin,
                size_t end, const PinholeView& view, float gain, float offset,
                float scale, float weight, NormalSums& sums) {
  const D d;
  const V scale2 = hn::Set(d, scale * scale);
  Partial partial;
  for (size_t i = begin; i < end; i += hn::Lanes(d)) {
    const V r =
        hn::Sub(hn::Sub(hn::LoadU(d, seen.brightness.data() + i),
                        hn::Mul(hn::Set(d, gain), hn::LoadU(d, reference + i))),
                hn::Set(d, offset));
    const V w = hn::Mul(
        hn::Mul(GemanMcClure(hn::Mul(r, r), scale2), hn::Set(d, weight)),
        hn::LoadU(d, seen.seen.data() + i));
    const V3 p = Load3(seen.x, seen.y, seen.z, i);
    const V iz = hn::Div(hn::Set(d, 1), p.z);
    const V jx = hn::Mul(
        hn::Mul(hn::LoadU(d, seen.gradient_x.data() + i), hn::Set(d, view.fx)),
        iz);
    const V jy = hn::Mul(
        hn::Mul(hn::LoadU(d, seen.gradient_y.data() + i), hn::Set(d, view.fy)),
        iz);
    const V jz = hn::Neg(hn::Mul(hn::MulAdd(jx, p.x, hn::Mul(jy, p.y)), iz));
    partial.Add(p, {jx, jy, jz}, r, w);
  }
  partial.AddTo(sums);
}

void Surfaces(const SurfacePoints& points, const PinholeView& view,
              float max_distance, NormalSums& sums) {
  const D d;
  Partial partial;
  for (size_t i = 0; i < points.size(); i += hn::Lanes(d)) {
    const V3 p =
        Rotate(view, FromCamera(Load3(points.x, points.y, points.z, i), view));
    const V3 n = Rotate(view, Load3(points.nx, points.ny, points.nz, i));
    const V3 m =
        Load3(points.measured_x, points.measured_y, points.measured_z, i);
    const V variance = hn::LoadU(d, points.variance.data() + i);
    const V distance =
        Dot3(n, {hn::Sub(p.x, m.x), hn::Sub(p.y, m.y), hn::Sub(p.z, m.z)});
    // Geman-McClure's, at a scale of two standard deviations.
    const V w = hn::Div(GemanMcClure(hn::Mul(distance, distance),
                                     hn::Mul(hn::Set(d, 4), variance)),
                        variance);
    const auto near = hn::Le(hn::Abs(distance), hn::Set(d, max_distance));
    partial.Add(p, n, distance, hn::IfThenElseZero(near, w));
  }
  partial.AddTo(sums);
}

}  // namespace treeline::keyframes::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <limits>

namespace treeline::keyframes {
namespace {

HWY_EXPORT(See);
HWY_EXPORT(LookUp);
HWY_EXPORT(Exposure);
HWY_EXPORT(Brightness);
HWY_EXPORT(Surfaces);
HWY_EXPORT(Count);

size_t Padded(size_t size) {
  return (size + kAlignmentBlock - 1) / kAlignmentBlock * kAlignmentBlock;
}

}  // namespace

void AlignmentPoints::Append(const std::array<float, 3>& position_in_world,
                             const std::array<int8_t, 3>& normal_in_world,
                             geometry::Vec3 origin) {
  x.push_back(position_in_world[0] - static_cast<float>(origin.x));
  y.push_back(position_in_world[1] - static_cast<float>(origin.y));
  z.push_back(position_in_world[2] - static_cast<float>(origin.z));
  nx.push_back(static_cast<float>(normal_in_world[0]) / 127);
  ny.push_back(static_cast<float>(normal_in_world[1]) / 127);
  nz.push_back(static_cast<float>(normal_in_world[2]) / 127);
}

void AlignmentPoints::Reserve(size_t points) {
  for (std::vector<float>* array : {&x, &y, &z, &nx, &ny, &nz}) {
    array->reserve(points);
  }
  for (std::vector<float>& level : gray) level.reserve(points);
}

void AlignmentPoints::AppendNothing() {
  for (std::vector<float>* array : {&x, &y, &z}) {
    array->push_back(std::numeric_limits<float>::quiet_NaN());
  }
  for (std::vector<float>* array : {&nx, &ny, &nz}) array->push_back(0);
}

void AlignmentPoints::Pad() {
  while (size() % kAlignmentBlock != 0) AppendNothing();
  for (std::vector<float>& level : gray) level.resize(size(), 0);
}

void VisiblePoints::resize(size_t points) {
  for (std::vector<float>* array :
       {&x, &y, &z, &u, &v, &brightness, &gradient_x, &gradient_y, &seen}) {
    array->resize(points);
  }
}

void SurfacePoints::clear() {
  for (std::vector<float>* array : {&x, &y, &z, &nx, &ny, &nz, &measured_x,
                                    &measured_y, &measured_z, &variance}) {
    array->clear();
  }
}

void SurfacePoints::Append(geometry::Vec3 point, geometry::Vec3 normal,
                           geometry::Vec3 measured, double distance_variance) {
  x.push_back(static_cast<float>(point.x));
  y.push_back(static_cast<float>(point.y));
  z.push_back(static_cast<float>(point.z));
  nx.push_back(static_cast<float>(normal.x));
  ny.push_back(static_cast<float>(normal.y));
  nz.push_back(static_cast<float>(normal.z));
  measured_x.push_back(static_cast<float>(measured.x));
  measured_y.push_back(static_cast<float>(measured.y));
  measured_z.push_back(static_cast<float>(measured.z));
  variance.push_back(static_cast<float>(distance_variance));
}

void SurfacePoints::Pad() {
  const size_t padded = Padded(size());
  // With a normal of zero every derivative is zero.
  for (std::vector<float>* array :
       {&x, &y, &z, &nx, &ny, &nz, &measured_x, &measured_y, &measured_z}) {
    array->resize(padded, 0);
  }
  variance.resize(padded, 1);
}

PinholeView ViewOf(const geometry::Rigid3& camera_from_world,
                   const camera::Camera& camera, geometry::Vec3 origin) {
  PinholeView view;
  const geometry::Mat3 r = camera_from_world.rotation.Matrix();
  for (size_t i = 0; i < 9; ++i) {
    view.camera_from_world_rotation[i] = static_cast<float>(r.m[i]);
  }
  const geometry::Vec3 position =
      camera_from_world.Inverse().translation - origin;
  view.position = {static_cast<float>(position.x),
                   static_cast<float>(position.y),
                   static_cast<float>(position.z)};
  view.fx = static_cast<float>(camera.fx());
  view.fy = static_cast<float>(camera.fy());
  view.cx = static_cast<float>(camera.cx());
  view.cy = static_cast<float>(camera.cy());
  return view;
}

void CountVisible(const AlignmentPoints& points, size_t group,
                  const PinholeView& view, int width, int height,
                  std::span<float> counts) {
  HWY_DYNAMIC_DISPATCH(Count)
  (points, group, view, width, height, counts.data());
}

void ProjectPoints(const AlignmentPoints& points, size_t begin, size_t end,
                   const PinholeView& view, VisiblePoints& seen) {
  HWY_DYNAMIC_DISPATCH(See)(points, begin, end, view, seen);
}

int SampleBrightness(const features::GrayPyramid& image, int level,
                     size_t begin, size_t end, VisiblePoints& seen) {
  const features::GrayPyramid::Level& l = image.level(level);
  return HWY_DYNAMIC_DISPATCH(LookUp)(l.gray.data(), l.width, l.height, level,
                                      begin, end, seen);
}

ExposureSums SumExposure(const std::vector<float>& reference,
                         const VisiblePoints& seen, size_t begin, size_t end,
                         float gain, float offset, float scale) {
  return HWY_DYNAMIC_DISPATCH(Exposure)(reference.data(), seen, begin, end,
                                        gain, offset, scale);
}

void AddBrightness(const std::vector<float>& reference,
                   const VisiblePoints& seen, size_t begin, size_t end,
                   const PinholeView& view, float gain, float offset,
                   float scale, float weight, NormalSums& sums) {
  HWY_DYNAMIC_DISPATCH(Brightness)
  (reference.data(), seen, begin, end, view, gain, offset, scale, weight, sums);
}

void AddSurfaces(const SurfacePoints& points, const PinholeView& view,
                 float max_distance, NormalSums& sums) {
  HWY_DYNAMIC_DISPATCH(Surfaces)(points, view, max_distance, sums);
}

}  // namespace treeline::keyframes
#endif  // HWY_ONCE
