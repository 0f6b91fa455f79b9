#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "server/core/keyframes/depth_lookup.cc"
#include "server/core/keyframes/depth_lookup.h"

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

struct V3 {
  V x, y, z;
};

HWY_INLINE V3 Transform(const std::array<float, 9>& m,
                        const std::array<float, 3>& t, const V3& p) {
  const D d;
  const auto row = [&](size_t i, float shift) HWY_ATTR {
    return hn::MulAdd(
        hn::Set(d, m[i]), p.x,
        hn::MulAdd(hn::Set(d, m[i + 1]), p.y,
                   hn::MulAdd(hn::Set(d, m[i + 2]), p.z, hn::Set(d, shift))));
  };
  return {row(0, t[0]), row(3, t[1]), row(6, t[2])};
}

struct V2 {
  V x, y;
};

// As camera::Camera's.
HWY_INLINE V2 Distorted(const DepthView& view, V x, V y) {
  const D d;
  const auto polynomial = [&](V r2, float a, float b, float c) HWY_ATTR {
    const V inner = hn::MulAdd(r2, hn::MulAdd(r2, hn::Set(d, c), hn::Set(d, b)),
                               hn::Set(d, a));
    return hn::MulAdd(r2, inner, hn::Set(d, 1));
  };
  const V r2 = hn::MulAdd(x, x, hn::Mul(y, y));
  const V g = hn::Div(polynomial(r2, view.k1, view.k2, view.k3),
                      polynomial(r2, view.k4, view.k5, view.k6));
  const V p1 = hn::Set(d, view.p1);
  const V p2 = hn::Set(d, view.p2);
  const V two = hn::Set(d, 2);
  const V xy2 = hn::Mul(two, hn::Mul(x, y));
  return {
      hn::MulAdd(
          g, x,
          hn::MulAdd(p1, xy2, hn::Mul(p2, hn::MulAdd(hn::Mul(two, x), x, r2)))),
      hn::MulAdd(g, y,
                 hn::MulAdd(p2, xy2,
                            hn::Mul(p1, hn::MulAdd(hn::Mul(two, y), y, r2))))};
}

void Measure(const VisiblePoints& seen, size_t begin, size_t end,
             const DepthView& view, MeasuredPoints& measured) {
  const D d;
  const DI di;
  const V zero = hn::Zero(d);
  const V one = hn::Set(d, 1);
  const V half = hn::Set(d, 0.5f);
  const auto last_pair = hn::Set(di, view.width * view.height - 2);
  for (size_t i = begin; i < end; i += hn::Lanes(d)) {
    const V3 q = Transform(
        view.depth_from_color_rotation, view.depth_from_color_translation,
        {hn::LoadU(d, seen.x.data() + i), hn::LoadU(d, seen.y.data() + i),
         hn::LoadU(d, seen.z.data() + i)});
    auto known = hn::And(hn::Gt(hn::LoadU(d, seen.seen.data() + i), zero),
                         hn::Gt(q.z, hn::Set(d, kNearest_m)));
    const V iz = hn::Div(one, hn::IfThenElse(known, q.z, one));
    const V x = hn::Mul(q.x, iz);
    const V y = hn::Mul(q.y, iz);
    const V2 lens = Distorted(view, x, y);
    const V u = hn::MulAdd(hn::Set(d, view.fx), lens.x, hn::Set(d, view.cx));
    const V v = hn::MulAdd(hn::Set(d, view.fy), lens.y, hn::Set(d, view.cy));
    const auto inside = hn::And(
        hn::And(hn::Gt(u, zero), hn::Gt(v, zero)),
        hn::And(hn::Lt(u, hn::Set(d, static_cast<float>(view.width - 1))),
                hn::Lt(v, hn::Set(d, static_cast<float>(view.height - 1)))));
    known = hn::And(known, inside);
    const auto column =
        hn::ConvertTo(di, hn::IfThenElseZero(known, hn::Add(u, half)));
    const auto row =
        hn::ConvertTo(di, hn::IfThenElseZero(known, hn::Add(v, half)));
    // Values are read in pairs, the last one as the second of its own.
    const auto at = hn::Add(hn::Mul(row, hn::Set(di, view.width)), column);
    const auto first = hn::Min(at, last_pair);
    const auto pair =
        hn::GatherOffset(di, reinterpret_cast<const int32_t*>(view.values),
                         hn::ShiftLeft<1>(first));
    const auto value = hn::And(
        hn::IfThenElse(hn::Eq(at, first), pair, hn::ShiftRight<16>(pair)),
        hn::Set(di, 65535));
    const auto is_measured =
        hn::And(hn::Gt(value, hn::Zero(di)), hn::Lt(value, hn::Set(di, 65535)));
    known = hn::And(known, hn::RebindMask(d, is_measured));
    const V z = hn::Mul(hn::Set(d, view.unit), hn::ConvertTo(d, value));
    // The ray through the pixel's centre, from that through the point's image.
    const V ray_x = hn::MulAdd(hn::Sub(hn::ConvertTo(d, column), u),
                               hn::Set(d, 1 / view.fx), x);
    const V ray_y = hn::MulAdd(hn::Sub(hn::ConvertTo(d, row), v),
                               hn::Set(d, 1 / view.fy), y);
    const V3 point = Transform(view.color_from_depth_rotation,
                               view.color_from_depth_translation,
                               {hn::Mul(ray_x, z), hn::Mul(ray_y, z), z});
    hn::StoreU(point.x, d, measured.x.data() + i);
    hn::StoreU(point.y, d, measured.y.data() + i);
    hn::StoreU(point.z, d, measured.z.data() + i);
    // features::DepthSigma_m.
    const V gap = hn::Sub(z, hn::Set(d, 0.4f));
    const V sigma =
        hn::MulAdd(hn::Mul(gap, gap), hn::Set(d, 0.0019f), hn::Set(d, 0.0012f));
    hn::StoreU(hn::IfThenElseZero(known, sigma), d,
               measured.sigma_m.data() + i);
  }
}

}  // namespace treeline::keyframes::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace treeline::keyframes {

HWY_EXPORT(Measure);

std::optional<DepthView> DepthViewOf(const camera::RgbdCalibration& calibration,
                                     const image::DepthImage& depth) {
  const camera::Camera& camera = calibration.depth;
  if (depth.width != camera.width() || depth.height != camera.height() ||
      depth.values.size() < 2) {
    return std::nullopt;
  }
  DepthView view{};
  std::array<float*, 8> lens{};  // in the order of the camera's parameters
  size_t first = 4;
  switch (camera.model()) {
    case camera::CameraModel::kSimplePinhole:
    case camera::CameraModel::kPinhole:
      break;
    case camera::CameraModel::kSimpleRadial:
      first = 3;
      lens = {&view.k1};
      break;
    case camera::CameraModel::kRadial:
      first = 3;
      lens = {&view.k1, &view.k2};
      break;
    case camera::CameraModel::kOpenCv:
      lens = {&view.k1, &view.k2, &view.p1, &view.p2};
      break;
    case camera::CameraModel::kFullOpenCv:
      lens = {&view.k1, &view.k2, &view.p1, &view.p2,
              &view.k3, &view.k4, &view.k5, &view.k6};
      break;
    default:
      return std::nullopt;
  }
  for (size_t i = 0; i < lens.size() && lens[i] != nullptr; ++i) {
    *lens[i] = static_cast<float>(camera.parameters()[first + i]);
  }
  const auto split = [](const geometry::Rigid3& pose,
                        std::array<float, 9>& rotation,
                        std::array<float, 3>& translation) {
    const geometry::Mat3 r = pose.rotation.Matrix();
    for (size_t i = 0; i < 9; ++i) rotation[i] = static_cast<float>(r.m[i]);
    translation = {static_cast<float>(pose.translation.x),
                   static_cast<float>(pose.translation.y),
                   static_cast<float>(pose.translation.z)};
  };
  split(calibration.color_from_depth.Inverse(), view.depth_from_color_rotation,
        view.depth_from_color_translation);
  split(calibration.color_from_depth, view.color_from_depth_rotation,
        view.color_from_depth_translation);
  view.fx = static_cast<float>(camera.fx());
  view.fy = static_cast<float>(camera.fy());
  view.cx = static_cast<float>(camera.cx());
  view.cy = static_cast<float>(camera.cy());
  view.unit = static_cast<float>(calibration.depth_scale * depth.unit_m);
  view.width = depth.width;
  view.height = depth.height;
  view.values = depth.values.data();
  return view;
}

void MeasuredPoints::resize(size_t points) {
  for (std::vector<float>* array : {&x, &y, &z, &sigma_m}) {
    array->resize(points);
  }
}

void MeasureDepth(const VisiblePoints& seen, size_t begin, size_t end,
                  const DepthView& view, MeasuredPoints& measured) {
  HWY_DYNAMIC_DISPATCH(Measure)(seen, begin, end, view, measured);
}

}  // namespace treeline::keyframes
#endif  // HWY_ONCE
