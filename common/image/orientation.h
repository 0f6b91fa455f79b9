// Which way up a picture is, as far as somebody knows.
#ifndef COMMON_IMAGE_ORIENTATION_H_
#define COMMON_IMAGE_ORIENTATION_H_

#include <optional>

#include "common/geometry/vector3.h"

namespace treeline::image {

// What is done to a picture: quarter turns clockwise, as many as its number.
enum class QuarterTurn {
  kNone = 0,
  kClockwise = 1,
  kHalf = 2,
  kCounterclockwise = 3
};

inline constexpr QuarterTurn kQuarterTurns[] = {
    QuarterTurn::kNone, QuarterTurn::kClockwise, QuarterTurn::kHalf,
    QuarterTurn::kCounterclockwise};

// What is left to do of `whole` once `done` was done.
constexpr QuarterTurn Remaining(QuarterTurn whole, QuarterTurn done) {
  return static_cast<QuarterTurn>(
      (static_cast<int>(whole) - static_cast<int>(done) + 4) % 4);
}

// The turn that undoes it.
constexpr QuarterTurn Inverse(QuarterTurn turn) {
  return Remaining(QuarterTurn::kNone, turn);
}

struct Orientation {
  // The turn that makes the picture upright: that brings the side that is up
  // in the world to its top.
  QuarterTurn upright_turn = QuarterTurn::kNone;
  // Whether somebody stated or measured it. If not, it is a guess.
  bool is_certain = false;

  bool operator==(const Orientation&) const = default;
};

// From the direction in which things fall, in the camera's frame (x right, y
// down, z forward) and any unit; finite, and long enough to be normalised.
// Certain if the picture is rolled by at most 30 degrees from a quarter turn.
// nullopt: the camera looks up or down within 20 degrees.
std::optional<Orientation> OrientationFromGravity(
    geometry::Vec3 gravity_in_camera);

}  // namespace treeline::image

#endif  // COMMON_IMAGE_ORIENTATION_H_
