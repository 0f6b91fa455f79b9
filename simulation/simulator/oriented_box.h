// Whether surfaces reach into a box, and where: exact tests in double
// precision.
#ifndef SIMULATION_SIMULATOR_ORIENTED_BOX_H_
#define SIMULATION_SIMULATOR_ORIENTED_BOX_H_

#include <array>
#include <optional>

#include "common/geometry/rigid3.h"

namespace treeline::simulator {

// Corners of a flat, convex quadrilateral, in order.
using QuadCorners = std::array<geometry::Vec3, 4>;

// An axis-parallel box in the world.
struct Bounds {
  geometry::Vec3 low;
  geometry::Vec3 high;
};

Bounds BoundsOf(const QuadCorners& corners);
constexpr bool Touch(const Bounds& a, const Bounds& b) {
  return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y &&
         b.low.y <= a.high.y && a.low.z <= b.high.z && b.low.z <= a.high.z;
}

// A box of any orientation. Immutable.
class OrientedBox {
 public:
  // The box from `low` to `high` in a frame whose pose is world_from_frame.
  OrientedBox(const geometry::Rigid3& world_from_frame, geometry::Vec3 low,
              geometry::Vec3 high);

  const Bounds& bounds() const { return bounds_; }

  // The middle (the mean of the corners) of the part of a quadrilateral in the
  // world that lies in the box; nullopt if none does. Nothing is missed: the
  // quadrilateral is clipped at the six faces.
  std::optional<geometry::Vec3> OverlapWith(
      const QuadCorners& quad_in_world) const;

 private:
  geometry::Mat3 frame_from_world_;
  geometry::Vec3 origin_in_world_;
  geometry::Vec3 low_;
  geometry::Vec3 high_;
  Bounds bounds_;
};

}  // namespace treeline::simulator

#endif  // SIMULATION_SIMULATOR_ORIENTED_BOX_H_
