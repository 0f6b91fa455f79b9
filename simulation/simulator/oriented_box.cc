#include "simulation/simulator/oriented_box.h"

#include <algorithm>
#include <cstddef>

namespace treeline::simulator {
namespace {

// A quadrilateral cut by six planes has at most ten corners.
constexpr size_t kMaxCorners = 10;

struct Polygon {
  std::array<geometry::Vec3, kMaxCorners> corners;
  size_t count = 0;
};

// What of `in` has sign * (coordinate - limit) <= 0.
Polygon Cut(const Polygon& in, int axis, double limit, double sign) {
  Polygon out;
  for (size_t i = 0; i < in.count; ++i) {
    const geometry::Vec3& a = in.corners[i];
    const geometry::Vec3& b = in.corners[(i + 1) % in.count];
    const double beyond_a = sign * (a[axis] - limit);
    const double beyond_b = sign * (b[axis] - limit);
    if (beyond_a <= 0 && out.count < kMaxCorners) out.corners[out.count++] = a;
    if ((beyond_a < 0 && beyond_b > 0) || (beyond_a > 0 && beyond_b < 0)) {
      const double t = beyond_a / (beyond_a - beyond_b);
      if (out.count < kMaxCorners) out.corners[out.count++] = a + t * (b - a);
    }
  }
  return out;
}

}  // namespace

Bounds BoundsOf(const QuadCorners& corners) {
  Bounds bounds = {corners[0], corners[0]};
  for (const geometry::Vec3& corner : corners) {
    bounds.low = {std::min(bounds.low.x, corner.x),
                  std::min(bounds.low.y, corner.y),
                  std::min(bounds.low.z, corner.z)};
    bounds.high = {std::max(bounds.high.x, corner.x),
                   std::max(bounds.high.y, corner.y),
                   std::max(bounds.high.z, corner.z)};
  }
  return bounds;
}

OrientedBox::OrientedBox(const geometry::Rigid3& world_from_frame,
                         geometry::Vec3 low, geometry::Vec3 high)
    : frame_from_world_(
          geometry::Transpose(world_from_frame.rotation.Matrix())),
      origin_in_world_(world_from_frame.translation),
      low_(low),
      high_(high) {
  const geometry::Mat3 world_from = geometry::Transpose(frame_from_world_);
  const geometry::Vec3 middle =
      origin_in_world_ + world_from * (0.5 * (low + high));
  const geometry::Vec3 half = 0.5 * (high - low);
  const auto reach = [&](int row) {
    return std::abs(world_from(row, 0)) * half.x +
           std::abs(world_from(row, 1)) * half.y +
           std::abs(world_from(row, 2)) * half.z;
  };
  const geometry::Vec3 extent = {reach(0), reach(1), reach(2)};
  bounds_ = {middle - extent, middle + extent};
}

std::optional<geometry::Vec3> OrientedBox::OverlapWith(
    const QuadCorners& quad_in_world) const {
  Polygon polygon;
  for (const geometry::Vec3& corner : quad_in_world) {
    polygon.corners[polygon.count++] =
        frame_from_world_ * (corner - origin_in_world_);
  }
  for (int axis = 0; axis < 3 && polygon.count > 0; ++axis) {
    polygon = Cut(polygon, axis, low_[axis], -1);
    polygon = Cut(polygon, axis, high_[axis], 1);
  }
  if (polygon.count == 0) return std::nullopt;
  geometry::Vec3 sum;
  for (size_t i = 0; i < polygon.count; ++i) sum = sum + polygon.corners[i];
  return origin_in_world_ + geometry::Transpose(frame_from_world_) *
                                (sum / static_cast<double>(polygon.count));
}

}  // namespace treeline::simulator
