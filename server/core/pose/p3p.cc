#include "server/core/pose/p3p.h"

#include <algorithm>
#include <cmath>

namespace treeline::pose {
namespace {

constexpr double kTiny = 1e-12;

// The largest real root of x^3 + a x^2 + b x + c.
double LargestCubicRoot(double a, double b, double c) {
  const double q = (a * a - 3 * b) / 9;
  const double r = (2 * a * a * a - 9 * a * b + 27 * c) / 54;
  if (r * r < q * q * q) {  // three real roots
    const double theta =
        std::acos(std::clamp(r / std::sqrt(q * q * q), -1.0, 1.0));
    const double scale = -2 * std::sqrt(q);
    constexpr double kThirdTurn = 2.0943951023931953;
    double largest = -1e300;
    for (int k = -1; k <= 1; ++k) {
      largest = std::max(largest,
                         scale * std::cos(theta / 3 + k * kThirdTurn) - a / 3);
    }
    return largest;
  }
  const double s = -std::copysign(
      std::cbrt(std::abs(r) + std::sqrt(std::max(0.0, r * r - q * q * q))), r);
  const double t = std::abs(s) < kTiny ? 0 : q / s;
  return s + t - a / 3;
}

// Real roots of k[4] x^4 + ... + k[0] (Ferrari), polished by Newton's method.
int RealQuarticRoots(const std::array<double, 5>& k,
                     std::array<double, 4>& roots) {
  if (std::abs(k[4]) < kTiny) return 0;
  const double b = k[3] / k[4];
  const double c = k[2] / k[4];
  const double d = k[1] / k[4];
  const double e = k[0] / k[4];
  const double p = c - 3 * b * b / 8;
  const double q = d - b * c / 2 + b * b * b / 8;
  const double r = e - b * d / 4 + b * b * c / 16 - 3 * b * b * b * b / 256;
  const double m = LargestCubicRoot(p, p * p / 4 - r, -q * q / 8);
  int count = 0;
  const auto add_pair = [&](double middle, double discriminant) {
    // Double roots may come out a rounding error below zero.
    if (discriminant < -1e-9) return;
    const double half = std::sqrt(std::max(0.0, discriminant)) / 2;
    for (const double y : {middle - half, middle + half}) {
      roots[static_cast<size_t>(count++)] = y - b / 4;
    }
  };
  if (m > kTiny) {
    const double s = std::sqrt(2 * m);
    add_pair(s / 2, -(2 * p + 2 * m + 2 * q / s));
    add_pair(-s / 2, -(2 * p + 2 * m - 2 * q / s));
  } else {  // biquadratic
    const double root = std::sqrt(std::max(0.0, p * p - 4 * r));
    add_pair(0, 2 * (-p + root));
    add_pair(0, 2 * (-p - root));
  }
  for (int i = 0; i < count; ++i) {
    double& x = roots[static_cast<size_t>(i)];
    for (int step = 0; step < 2; ++step) {
      const double value = (((x + b) * x + c) * x + d) * x + e;
      const double slope = ((4 * x + 3 * b) * x + 2 * c) * x + d;
      if (std::abs(slope) < kTiny) break;
      x -= value / slope;
    }
  }
  return count;
}

// The rotation whose columns are the axes of a triangle's own frame.
struct Triad {
  geometry::Vec3 x;
  geometry::Vec3 y;
  geometry::Vec3 z;
};
Triad TriadOf(geometry::Vec3 a, geometry::Vec3 b, geometry::Vec3 c) {
  Triad t;
  t.x = geometry::Normalized(b - a);
  t.z = geometry::Normalized(geometry::Cross(t.x, c - a));
  t.y = geometry::Cross(t.z, t.x);
  return t;
}

geometry::Rigid3 Align(const std::array<geometry::Vec3, 3>& in_camera,
                       const std::array<geometry::Vec3, 3>& in_world) {
  const Triad c = TriadOf(in_camera[0], in_camera[1], in_camera[2]);
  const Triad w = TriadOf(in_world[0], in_world[1], in_world[2]);
  geometry::Mat3 rotation;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      rotation(i, j) = c.x[i] * w.x[j] + c.y[i] * w.y[j] + c.z[i] * w.z[j];
    }
  }
  const geometry::Rotation3 camera_from_world =
      geometry::Rotation3::FromMatrix(rotation);
  return {camera_from_world, in_camera[0] - camera_from_world * in_world[0]};
}

}  // namespace

P3pSolutions SolveP3p(const std::array<camera::Pixel, 3>& rays,
                      const std::array<geometry::Vec3, 3>& points_in_world) {
  P3pSolutions solutions;
  std::array<geometry::Vec3, 3> j;
  for (size_t i = 0; i < 3; ++i) {
    j[i] = geometry::Normalized(geometry::Vec3{rays[i].x, rays[i].y, 1});
  }
  const auto& p = points_in_world;
  const double a2 = geometry::SquaredNorm(p[1] - p[2]);
  const double b2 = geometry::SquaredNorm(p[0] - p[2]);
  const double c2 = geometry::SquaredNorm(p[0] - p[1]);
  if (!(b2 > 0) ||
      !(geometry::SquaredNorm(geometry::Cross(p[1] - p[0], p[2] - p[0])) > 0)) {
    return solutions;
  }
  const double cos_a = geometry::Dot(j[1], j[2]);
  const double cos_b = geometry::Dot(j[0], j[2]);
  const double cos_c = geometry::Dot(j[0], j[1]);
  // Distances s1, u s1, v s1 along the rays; a quartic in v is left.
  const double m = (a2 - c2) / b2;
  const double n = (a2 + c2) / b2;
  const double a = a2 / b2;
  const double c = c2 / b2;
  const std::array<double, 5> quartic = {
      (1 + m) * (1 + m) - 4 * a * cos_c * cos_c,
      4 * (-m * (1 + m) * cos_b + 2 * a * cos_c * cos_c * cos_b -
           (1 - n) * cos_a * cos_c),
      2 * (m * m - 1 + 2 * m * m * cos_b * cos_b + 2 * (1 - c) * cos_a * cos_a -
           4 * n * cos_a * cos_b * cos_c + 2 * (1 - a) * cos_c * cos_c),
      4 * (m * (1 - m) * cos_b - (1 - n) * cos_a * cos_c +
           2 * c * cos_a * cos_a * cos_b),
      (m - 1) * (m - 1) - 4 * c * cos_a * cos_a};
  std::array<double, 4> roots;
  const int count = RealQuarticRoots(quartic, roots);
  for (int i = 0; i < count; ++i) {
    const double v = roots[static_cast<size_t>(i)];
    const double denominator = 2 * (cos_c - v * cos_a);
    const double s2 = b2 / (1 + v * v - 2 * v * cos_b);
    if (!(v > 0) || std::abs(denominator) < kTiny || !(s2 > 0)) continue;
    const double u =
        ((m - 1) * v * v - 2 * m * cos_b * v + 1 + m) / denominator;
    if (!(u > 0)) continue;
    const double s = std::sqrt(s2);
    const geometry::Rigid3 pose =
        Align({s * j[0], (u * s) * j[1], (v * s) * j[2]}, p);
    if (!geometry::IsFinite(pose)) continue;
    solutions.camera_from_world[static_cast<size_t>(solutions.count++)] = pose;
  }
  return solutions;
}

}  // namespace treeline::pose
