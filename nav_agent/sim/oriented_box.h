// Whether surfaces reach into a box, and where: exact tests in double
// precision.
#ifndef NAV_AGENT_SIM_ORIENTED_BOX_H_
#define NAV_AGENT_SIM_ORIENTED_BOX_H_

#include <array>
#include <optional>

#include "common/geometry/rigid3.h"

namespace treeline {

// Corners of a flat, convex quadrilateral, in order.
using QuadCorners = std::array<Vec3, 4>;

// An axis-parallel box in the world.
struct Bounds {
  Vec3 low;
  Vec3 high;
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
  OrientedBox(const Rigid3& world_from_frame, Vec3 low, Vec3 high);

  const Bounds& bounds() const { return bounds_; }

  // The middle (the mean of the corners) of the part of a quadrilateral in the
  // world that lies in the box; nullopt if none does. Nothing is missed: the
  // quadrilateral is clipped at the six faces.
  std::optional<Vec3> OverlapWith(const QuadCorners& quad_in_world) const;

 private:
  Mat3 frame_from_world_;
  Vec3 origin_in_world_;
  Vec3 low_;
  Vec3 high_;
  Bounds bounds_;
};

}  // namespace treeline

#endif  // NAV_AGENT_SIM_ORIENTED_BOX_H_
