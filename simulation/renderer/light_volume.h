// Light in the air of a world: what falls on things that are not there when
// light is baked, because they move.
#ifndef SIMULATION_RENDERER_LIGHT_VOLUME_H_
#define SIMULATION_RENDERER_LIGHT_VOLUME_H_

#include <array>
#include <vector>

#include "simulation/renderer/light_map.h"
#include "simulation/renderer/ray_caster.h"
#include "simulation/worlds/world.h"

namespace treeline::renderer {

// A grid of ambient cubes (McTaggart, "Half-Life 2 / Valve source shading",
// GDC 2004): at each point the light that falls on the six sides of a small
// cube. A surface between the sides gets their mean, by the squares of its
// normal's components.
class LightVolume {
 public:
  // No light anywhere.
  LightVolume() = default;

  // The light of a cloudy day everywhere; goes with LightMap::Even.
  static LightVolume Even();

  // About a probe in half a metre, fewer in large worlds. The result does not
  // depend on the number of threads.
  static LightVolume Bake(const worlds::World& world, const RayCaster& caster,
                          const LightMap& light_map, int threads);

  // Light that falls at `point` on what faces along the unit vector `normal`,
  // in the units of LightMap::At. Beyond the grid: of its nearest point.
  worlds::Float3 At(worlds::Float3 point, worlds::Float3 normal) const;

 private:
  // Light on the sides that face +x, -x, +y, -y, +z, -z.
  struct Probe {
    std::array<worlds::Float3, 6> sides;
    // 0: inside of something, where nobody can be.
    float weight = 0;
  };

  worlds::Float3 low_;
  float spacing_m_ = 1;
  std::array<int, 3> counts_{0, 0, 0};
  std::vector<Probe> probes_;
};

}  // namespace treeline::renderer

#endif  // SIMULATION_RENDERER_LIGHT_VOLUME_H_
