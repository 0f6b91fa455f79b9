// Light that falls on the surfaces of a world, computed once: direct light of
// area lights with soft shadows, and what walls and furniture reflect.
#ifndef SIMULATION_RENDERER_LIGHT_MAP_H_
#define SIMULATION_RENDERER_LIGHT_MAP_H_

#include <cstdint>
#include <span>
#include <vector>

#include "simulation/renderer/direct_light.h"
#include "simulation/renderer/ray_caster.h"
#include "simulation/worlds/world.h"

namespace treeline::renderer {

class LightMap {
 public:
  // Bakes on up to `threads` threads; the result does not depend on how many.
  static LightMap Bake(const worlds::World& world, const RayCaster& caster,
                       int threads);

  // The light of a cloudy day: more from above, and from some sides than from
  // others, so that corners can be told.
  static LightMap Even(const worlds::World& world);
  static worlds::Float3 EvenLight(worlds::Float3 normal);

  // Light at (u, v) of a surface, per pi: times reflectance it is the radiance
  // of a matt surface. Bilinear between texels of about 6 cm, more in
  // large worlds.
  worlds::Float3 At(uint32_t surface, float u, float v) const;

 private:
  // The texels of one surface: u_count x v_count of them from `first`.
  struct Grid {
    int u_count = 1;
    int v_count = 1;
    size_t first = 0;
  };
  // Lays out texels of about this size, and says where they are.
  std::vector<LightReceiver> LayOut(const worlds::World& world, float texel_m);
  // With all care: each texel by itself.
  void BakeSmall(const worlds::World& world, const RayCaster& caster,
                 std::span<const LightReceiver> receivers, int threads);
  // Hundreds of thousands of texels and dozens of lights within seconds:
  // leaves out lights that are not seen from around a texel, samples lights
  // less that are wholly in view or wholly hidden, and gathers what surfaces
  // reflect for larger squares.
  void BakeLarge(const worlds::World& world, const RayCaster& caster,
                 std::span<const LightReceiver> receivers, int threads);
  // What surfaces reflect and give off towards receivers, by this map.
  // is_front_only: what gives off light does so to its front; light from the
  // inside of flat lamps would seep through to the ceiling that they hang from.
  std::vector<worlds::Float3> Gather(const worlds::World& world,
                                     const RayCaster& caster,
                                     std::span<const LightReceiver> receivers,
                                     int bounce, bool is_front_only,
                                     int threads) const;
  void SmoothFrom(const std::vector<worlds::Float3>& gathered);
  // Texels of one surface that lie together.
  struct Patch {
    size_t width = 0;
    std::vector<size_t> texels;
  };
  std::vector<Patch> Patches() const;

  std::vector<Grid> grids_;
  std::vector<worlds::Float3> texels_;
};

}  // namespace treeline::renderer

#endif  // SIMULATION_RENDERER_LIGHT_MAP_H_
