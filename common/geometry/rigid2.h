// Rigid transforms in the plane: where a robot is on a floor.
#ifndef COMMON_GEOMETRY_RIGID2_H_
#define COMMON_GEOMETRY_RIGID2_H_

#include <cmath>
#include <numbers>

namespace treeline::geometry {

// A position in the plane (m).
struct Vec2 {
  double x = 0;
  double y = 0;

  constexpr bool operator==(const Vec2&) const = default;
};

constexpr Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
constexpr Vec2 operator-(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
constexpr Vec2 operator*(double s, Vec2 a) { return {s * a.x, s * a.y}; }
constexpr double Dot(Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; }
// The z of the cross product: positive where b is to the left of a.
constexpr double Cross(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }
inline double Norm(Vec2 a) { return std::hypot(a.x, a.y); }

// The same angle in [-pi, pi].
inline double NormalizedAngle_rad(double angle_rad) {
  return std::remainder(angle_rad, 2 * std::numbers::pi);
}

// A rotation counter-clockwise by yaw_rad, followed by a translation (m).
// Named as Rigid3 is: map_from_base * point_in_base.
struct Rigid2 {
  Vec2 translation;
  double yaw_rad = 0;

  constexpr bool operator==(const Rigid2&) const = default;
  Rigid2 Inverse() const {
    const double c = std::cos(yaw_rad);
    const double s = std::sin(yaw_rad);
    return {{-c * translation.x - s * translation.y,
             s * translation.x - c * translation.y},
            NormalizedAngle_rad(-yaw_rad)};
  }
};

inline Vec2 operator*(const Rigid2& a, Vec2 point) {
  const double c = std::cos(a.yaw_rad);
  const double s = std::sin(a.yaw_rad);
  return {a.translation.x + c * point.x - s * point.y,
          a.translation.y + s * point.x + c * point.y};
}

inline Rigid2 operator*(const Rigid2& a, const Rigid2& b) {
  return {a * b.translation, NormalizedAngle_rad(a.yaw_rad + b.yaw_rad)};
}

}  // namespace treeline::geometry

#endif  // COMMON_GEOMETRY_RIGID2_H_
