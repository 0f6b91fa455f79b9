// Light in the air of a world: what falls on things that are not there when
// light is baked, because they move.
#ifndef COMMON_SYNTHETIC_LIGHT_VOLUME_H_
#define COMMON_SYNTHETIC_LIGHT_VOLUME_H_

#include <array>
#include <vector>

#include "common/synthetic/light_map.h"
#include "common/synthetic/ray_caster.h"
#include "common/synthetic/world.h"

namespace treeline {

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
  static LightVolume Bake(const World& world, const RayCaster& caster,
                          const LightMap& light_map, int threads);

  // Light that falls at `point` on what faces along the unit vector `normal`,
  // in the units of LightMap::At. Beyond the grid: of its nearest point.
  Float3 At(Float3 point, Float3 normal) const;

 private:
  // Light on the sides that face +x, -x, +y, -y, +z, -z.
  struct Probe {
    std::array<Float3, 6> sides;
    // 0: inside of something, where nobody can be.
    float weight = 0;
  };

  Float3 low_;
  float spacing_m_ = 1;
  std::array<int, 3> counts_{0, 0, 0};
  std::vector<Probe> probes_;
};

}  // namespace treeline

#endif  // COMMON_SYNTHETIC_LIGHT_VOLUME_H_
