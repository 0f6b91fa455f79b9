#include "common/image/orientation.h"

#include <algorithm>
#include <cmath>

namespace treeline::image {
namespace {

// Sine of 20 degrees, the least angle between gravity and the optical axis: a
// picture of the floor or the ceiling has no side that is up.
constexpr double kMinInImage = 0.342;
// Tangent of 30 degrees, the largest roll from the nearest quarter turn: in
// between, a picture lies as much on its side as on its bottom.
constexpr double kLargestSlope = 0.577;

}  // namespace

std::optional<Orientation> OrientationFromGravity(
    geometry::Vec3 gravity_in_camera) {
  const geometry::Vec3 down = geometry::Normalized(gravity_in_camera);
  if (std::hypot(down.x, down.y) < kMinInImage) return std::nullopt;
  const double across = std::abs(down.x);
  const double along = std::abs(down.y);
  Orientation orientation;
  orientation.is_certain =
      std::min(across, along) <= kLargestSlope * std::max(across, along);
  if (across > along) {
    // Where things fall to the right, the left side is up.
    orientation.upright_turn =
        down.x > 0 ? QuarterTurn::kClockwise : QuarterTurn::kCounterclockwise;
  } else if (down.y < 0) {
    orientation.upright_turn = QuarterTurn::kHalf;
  }
  return orientation;
}

}  // namespace treeline::image
