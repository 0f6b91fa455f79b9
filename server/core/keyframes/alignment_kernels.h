// The inner loops of direct alignment: many points at once, in single
// precision.
#ifndef SERVER_CORE_KEYFRAMES_ALIGNMENT_KERNELS_H_
#define SERVER_CORE_KEYFRAMES_ALIGNMENT_KERNELS_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"
#include "server/core/features/gray_pyramid.h"

namespace treeline::keyframes {

// Ranges of points begin and end at multiples of this: the widest vector.
inline constexpr size_t kAlignmentBlock = 16;

// Points of keyframes, slot i of each array. What fills up a block has NaN in
// place of a position, and is never seen.
struct AlignmentPoints {
  // In the world, less an origin near the camera (m).
  std::vector<float> x, y, z;
  // Unit normals in the world; zero where they are not known.
  std::vector<float> nx, ny, nz;
  // Brightness at each level of GrayPyramid; not needed by CountVisible.
  std::array<std::vector<float>, features::GrayPyramid::kLevels> gray;

  size_t size() const { return x.size(); }
  void Reserve(size_t points);
  // `origin` is that of the arrays, in the world.
  void Append(const std::array<float, 3>& position_in_world,
              const std::array<int8_t, 3>& normal_in_world,
              geometry::Vec3 origin);
  // A point that is never seen.
  void AppendNothing();
  // Up to a multiple of kAlignmentBlock.
  void Pad();
};

// Those points as a camera sees them, in the same slots.
struct VisiblePoints {
  // In the camera (m); where the point is not seen (0, 0, 1).
  std::vector<float> x, y, z;
  // The pixel, at level 0.
  std::vector<float> u, v;
  std::vector<float> brightness;
  // Of the brightness, per pixel of level 0.
  std::vector<float> gradient_x, gradient_y;
  // 1 if it is seen, else 0 and the three above are 0.
  std::vector<float> seen;

  void resize(size_t points);
};

// Points with the surface that was measured where they project, slot i of each.
struct SurfacePoints {
  // As in AlignmentPoints; normals are known.
  std::vector<float> x, y, z;
  std::vector<float> nx, ny, nz;
  // The measured point in the colour camera (m), and its distance's variance
  // (m^2).
  std::vector<float> measured_x, measured_y, measured_z, variance;

  size_t size() const { return x.size(); }
  void clear();
  void Append(geometry::Vec3 point, geometry::Vec3 normal,
              geometry::Vec3 measured, double distance_variance);
  // Up to a multiple of kAlignmentBlock, with points that count for nothing.
  void Pad();
};

// A pinhole camera somewhere.
struct PinholeView {
  std::array<float, 9> camera_from_world_rotation;  // row by row
  std::array<float, 3> position;  // in the world, less the same origin (m)
  float fx, fy, cx, cy;           // px
};

PinholeView ViewOf(const geometry::Rigid3& camera_from_world,
                   const camera::Camera& camera, geometry::Vec3 origin);

// Sums of Gauss-Newton's normal equations: the upper triangle of H row by row,
// and the gradient. Parameters are a step (v, w) of the camera's frame: a
// point moves by v + w x p.
struct NormalSums {
  std::array<double, 21> h{};
  std::array<double, 6> g{};
};

// Weighted moments of (reference, brightness), both less 128.
struct ExposureSums {
  float w = 0, x = 0, y = 0, xx = 0, xy = 0;

  ExposureSums& operator+=(const ExposureSums& other) {
    w += other.w;
    x += other.x;
    y += other.y;
    xx += other.xx;
    xy += other.xy;
    return *this;
  }
};

// Of the points of each group of `group` (a multiple of kAlignmentBlock), one
// after the other, how many are seen inside an image of this size.
void CountVisible(const AlignmentPoints& points, size_t group,
                  const PinholeView& view, int width, int height,
                  std::span<float> counts);

// All below work on points [begin, end).

// Positions, pixels and `seen`: in front of the camera and facing it.
void ProjectPoints(const AlignmentPoints& points, size_t begin, size_t end,
                   const PinholeView& view, VisiblePoints& seen);

// Brightness and gradients at the pixels, bilinear; what lies outside is not
// seen. Returns how many are.
int SampleBrightness(const features::GrayPyramid& image, int level,
                     size_t begin, size_t end, VisiblePoints& seen);

// Weights are Geman-McClure's of brightness - gain * reference - offset.
ExposureSums SumExposure(const std::vector<float>& reference,
                         const VisiblePoints& seen, size_t begin, size_t end,
                         float gain, float offset, float scale);

// Adds the same residuals, with these weights times `weight`.
void AddBrightness(const std::vector<float>& reference,
                   const VisiblePoints& seen, size_t begin, size_t end,
                   const PinholeView& view, float gain, float offset,
                   float scale, float weight, NormalSums& sums);

// Adds the distances from measured points to the tangent planes, as far as they
// are below max_distance (m), with Geman-McClure's weights over their variance.
void AddSurfaces(const SurfacePoints& points, const PinholeView& view,
                 float max_distance, NormalSums& sums);

}  // namespace treeline::keyframes

#endif  // SERVER_CORE_KEYFRAMES_ALIGNMENT_KERNELS_H_
