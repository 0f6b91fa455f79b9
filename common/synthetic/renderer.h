// What cameras see of a world, before any sensor noise.
#ifndef COMMON_SYNTHETIC_RENDERER_H_
#define COMMON_SYNTHETIC_RENDERER_H_

#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"
#include "common/synthetic/light_map.h"
#include "common/synthetic/ray_caster.h"
#include "common/synthetic/world.h"

namespace treeline {

// The rays of a camera's pixels, (x/z, y/z, 1) in its frame, rows from the top.
class PixelRays {
 public:
  explicit PixelRays(const Camera& camera);

  int width() const { return width_; }
  int height() const { return height_; }
  float focal_length_px() const { return focal_length_px_; }
  // Pixels that the lens does not see have z = 0.
  const std::vector<Float3>& rays() const { return rays_; }
  // One over the lengths of the rays.
  const std::vector<float>& inverse_lengths() const { return inverse_lengths_; }

 private:
  int width_;
  int height_;
  float focal_length_px_;
  std::vector<Float3> rays_;
  std::vector<float> inverse_lengths_;
};

// Ideal measurement of one depth pixel.
struct DepthSample {
  // Along the optical axis (m); 0: nothing there.
  float depth_m = 0;
  // Cosine between the ray and the surface's normal, in [0, 1].
  float incidence = 0;
};

// Immutable and thread-safe. Pictures do not depend on the thread count.
class Renderer {
 public:
  // Prepares the light of `world` (a second or two). threads < 1: all.
  static absl::StatusOr<std::unique_ptr<const Renderer>> Create(World world,
                                                                int threads);

  const World& world() const { return world_; }
  const RayCaster& caster() const { return caster_; }

  // Linear radiance of every pixel; edges are smoothed with three rays.
  std::vector<Float3> RenderRadiance(const PixelRays& rays,
                                     const Rigid3& world_from_camera,
                                     int threads) const;

  std::vector<DepthSample> RenderDepth(const PixelRays& rays,
                                       const Rigid3& world_from_camera,
                                       int threads) const;

 private:
  // What shading needs to know of a surface.
  struct Shading {
    Float3 normal;
    float texels_per_m = 0;
  };
  // One camera at one place.
  struct View;

  Renderer(World world, RayCaster caster, LightMap light_map);
  void CastRows(const View& view, int first_row, int last_row,
                std::vector<RayHit>& hits) const;
  // inverse_length: of `direction`.
  Float3 Shade(const View& view, Float3 direction, float inverse_length,
               const RayHit& hit) const;
  // Adds two more rays to each of the pixels `edges`.
  void ShadeEdges(const View& view, const std::vector<size_t>& edges,
                  std::vector<Float3>& radiance) const;

  World world_;
  RayCaster caster_;
  LightMap light_map_;
  std::vector<Shading> shadings_;
};

}  // namespace treeline

#endif  // COMMON_SYNTHETIC_RENDERER_H_
