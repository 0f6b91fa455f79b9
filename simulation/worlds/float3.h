// Single-precision triples: directions and positions (m) for ray casting, and
// colours (red, green, blue).
#ifndef SIMULATION_WORLDS_FLOAT3_H_
#define SIMULATION_WORLDS_FLOAT3_H_

#include <algorithm>
#include <cmath>

namespace treeline::worlds {

struct Float3 {
  float x = 0;
  float y = 0;
  float z = 0;

  constexpr bool operator==(const Float3&) const = default;
};

constexpr Float3 operator+(Float3 a, Float3 b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
constexpr Float3 operator-(Float3 a, Float3 b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
constexpr Float3 operator*(float s, Float3 a) {
  return {s * a.x, s * a.y, s * a.z};
}
// By component: light on a coloured surface.
constexpr Float3 operator*(Float3 a, Float3 b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}
constexpr float Dot(Float3 a, Float3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
constexpr Float3 Cross(Float3 a, Float3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline float Norm(Float3 a) { return std::sqrt(Dot(a, a)); }
inline Float3 Normalized(Float3 a) { return (1 / Norm(a)) * a; }
// a at t = 0, b at t = 1.
constexpr Float3 Mix(Float3 a, Float3 b, float t) { return a + t * (b - a); }

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_FLOAT3_H_
