// Three-vectors and 3x3 matrices: plain values, no library behind them.
#ifndef COMMON_GEOMETRY_VECTOR3_H_
#define COMMON_GEOMETRY_VECTOR3_H_

#include <array>
#include <cmath>

namespace treeline::geometry {

struct Vec3 {
  double x = 0;
  double y = 0;
  double z = 0;

  constexpr double operator[](int i) const {
    return i == 0 ? x : (i == 1 ? y : z);
  }
  constexpr bool operator==(const Vec3&) const = default;
};

constexpr Vec3 operator+(Vec3 a, Vec3 b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
constexpr Vec3 operator-(Vec3 a, Vec3 b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
constexpr Vec3 operator-(Vec3 a) { return {-a.x, -a.y, -a.z}; }
constexpr Vec3 operator*(double s, Vec3 a) {
  return {s * a.x, s * a.y, s * a.z};
}
constexpr Vec3 operator*(Vec3 a, double s) { return s * a; }
constexpr Vec3 operator/(Vec3 a, double s) { return (1 / s) * a; }
constexpr double Dot(Vec3 a, Vec3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
constexpr Vec3 Cross(Vec3 a, Vec3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
constexpr double SquaredNorm(Vec3 a) { return Dot(a, a); }
inline double Norm(Vec3 a) { return std::sqrt(SquaredNorm(a)); }
inline Vec3 Normalized(Vec3 a) { return a / Norm(a); }
inline bool IsFinite(Vec3 a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

// Row-major 3x3 matrix.
struct Mat3 {
  std::array<double, 9> m{};

  constexpr double& operator()(int row, int col) {
    return m[static_cast<size_t>(3 * row + col)];
  }
  constexpr double operator()(int row, int col) const {
    return m[static_cast<size_t>(3 * row + col)];
  }
  static constexpr Mat3 Identity() { return Mat3{{1, 0, 0, 0, 1, 0, 0, 0, 1}}; }
};

constexpr Vec3 operator*(const Mat3& a, Vec3 v) {
  return {a.m[0] * v.x + a.m[1] * v.y + a.m[2] * v.z,
          a.m[3] * v.x + a.m[4] * v.y + a.m[5] * v.z,
          a.m[6] * v.x + a.m[7] * v.y + a.m[8] * v.z};
}

constexpr Mat3 operator*(const Mat3& a, const Mat3& b) {
  Mat3 c;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      c(i, j) = a(i, 0) * b(0, j) + a(i, 1) * b(1, j) + a(i, 2) * b(2, j);
    }
  }
  return c;
}

constexpr Mat3 Transpose(const Mat3& a) {
  return Mat3{
      {a.m[0], a.m[3], a.m[6], a.m[1], a.m[4], a.m[7], a.m[2], a.m[5], a.m[8]}};
}

}  // namespace treeline::geometry

#endif  // COMMON_GEOMETRY_VECTOR3_H_
