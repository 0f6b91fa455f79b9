// What cameras see of a world, before any sensor noise.
#ifndef SIMULATION_RENDERER_RENDERER_H_
#define SIMULATION_RENDERER_RENDERER_H_

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "common/camera/camera.h"
#include "common/geometry/rigid3.h"
#include "simulation/renderer/light_map.h"
#include "simulation/renderer/light_volume.h"
#include "simulation/renderer/ray_caster.h"
#include "simulation/worlds/world.h"

namespace treeline::renderer {

// The rays of a camera's pixels, (x/z, y/z, 1) in its frame, rows from the top.
class PixelRays {
 public:
  explicit PixelRays(const camera::Camera& camera);

  int width() const { return width_; }
  int height() const { return height_; }
  float focal_length_px() const { return focal_length_px_; }
  // Pixels that the lens does not see have z = 0.
  const std::vector<worlds::Float3>& rays() const { return rays_; }
  // One over the lengths of the rays.
  const std::vector<float>& inverse_lengths() const { return inverse_lengths_; }

 private:
  int width_;
  int height_;
  float focal_length_px_;
  std::vector<worlds::Float3> rays_;
  std::vector<float> inverse_lengths_;
};

// Ideal measurement of one depth pixel.
struct DepthSample {
  // Along the optical axis (m); 0: nothing there.
  float depth_m = 0;
  // Cosine between the ray and the surface's normal, in [0, 1].
  float incidence = 0;
  // Whether a pane of glass is before it.
  bool is_behind_glass = false;
};

// What there truly is at a pixel, for scoring.
struct PixelTruth {
  // What was hit, panes of glass apart; see RayHit.
  uint32_t surface = RayHit::kNothing;
  int32_t instance = RayHit::kFixed;
  worlds::SurfaceKind kind = worlds::SurfaceKind::kOther;
  // As in DepthSample.
  float depth_m = 0;
  // Of unit length, in the camera's frame, towards the camera.
  worlds::Float3 normal_in_camera;
  bool is_behind_glass = false;
};

// Immutable and thread-safe. Pictures do not depend on the thread count.
// Snapshots must be of caster(); pictures without one show no body.
class Renderer {
 public:
  // Prepares the light of `world` (a second or two). threads < 1: all.
  static absl::StatusOr<std::unique_ptr<const Renderer>> Create(
      worlds::World world, int threads);
  // As Create, with the ceiling cut away after the light was prepared: all
  // ceilings, and what begins above cut_m. For pictures from above.
  static absl::StatusOr<std::unique_ptr<const Renderer>> CreateOpened(
      worlds::World world, float cut_m, int threads);
  // Prepares no light, which takes milliseconds: radiance is that of a cloudy
  // day. For depth, truth and plans.
  static absl::StatusOr<std::unique_ptr<const Renderer>> CreateUnlit(
      worlds::World world);

  const worlds::World& world() const { return world_; }
  const RayCaster& caster() const { return caster_; }

  // Linear radiance of every pixel; edges are smoothed with three rays. Glass
  // dims what is behind, and shines where it is seen at a slant. Bodies are
  // lit by a LightVolume and darken the ground that they stand on.
  std::vector<worlds::Float3> RenderRadiance(
      const PixelRays& rays, const geometry::Rigid3& world_from_camera,
      int threads) const;
  std::vector<worlds::Float3> RenderRadiance(
      const WorldSnapshot& snapshot, const PixelRays& rays,
      const geometry::Rigid3& world_from_camera, int threads) const;

  std::vector<DepthSample> RenderDepth(
      const PixelRays& rays, const geometry::Rigid3& world_from_camera,
      int threads) const;
  std::vector<DepthSample> RenderDepth(
      const WorldSnapshot& snapshot, const PixelRays& rays,
      const geometry::Rigid3& world_from_camera, int threads) const;

  std::vector<PixelTruth> RenderTruth(const WorldSnapshot& snapshot,
                                      const PixelRays& rays,
                                      const geometry::Rigid3& world_from_camera,
                                      int threads) const;

 private:
  // What shading needs to know of a surface.
  struct Shading {
    worlds::Float3 normal;
    float texels_per_m = 0;
  };
  // What it needs to know of a body: its surfaces, and where it stands in its
  // own frame.
  struct BodyShading {
    std::vector<Shading> surfaces;
    worlds::Float3 low;
    worlds::Float3 high;
  };
  // One camera at one place.
  struct View;
  // What its pixels see: what is solid, and glass before it (empty if there is
  // none in the world).
  struct Sight {
    std::vector<RayHit> hits;
    std::vector<RayHit> panes;
  };

  Renderer(worlds::World world, RayCaster caster, LightMap light_map,
           LightVolume light_volume);
  static absl::StatusOr<std::unique_ptr<Renderer>> CreateLit(
      worlds::World world, int threads);
  Shading ShadingOf(const worlds::Surface& surface) const;
  Sight MakeSight(const PixelRays& rays) const;
  void CastRays(const View& view, std::span<const worlds::Float3> directions,
                std::span<RayHit> hits, std::span<RayHit> panes) const;
  void CastRows(const View& view, int first_row, int last_row,
                Sight& sight) const;
  worlds::Float3 NormalAt(const View& view, const RayHit& hit) const;
  // inverse_length: of `direction`.
  worlds::Float3 Shade(const View& view, worlds::Float3 direction,
                       float inverse_length, const RayHit& hit) const;
  worlds::Float3 ShadeThrough(const View& view, worlds::Float3 direction,
                              float inverse_length, const RayHit& pane,
                              worlds::Float3 behind) const;
  // Adds two more rays to each of the pixels `edges`.
  void ShadeEdges(const View& view, const std::vector<size_t>& edges,
                  std::vector<worlds::Float3>& radiance) const;

  worlds::World world_;
  RayCaster caster_;
  LightMap light_map_;
  LightVolume light_volume_;
  std::vector<Shading> shadings_;
  std::vector<BodyShading> bodies_;
};

}  // namespace treeline::renderer

#endif  // SIMULATION_RENDERER_RENDERER_H_
