// Light that falls on the surfaces of a world, computed once: direct light of
// area lights with soft shadows, and what walls and furniture reflect.
#ifndef COMMON_SYNTHETIC_LIGHT_MAP_H_
#define COMMON_SYNTHETIC_LIGHT_MAP_H_

#include <vector>

#include "common/synthetic/ray_caster.h"
#include "common/synthetic/world.h"

namespace treeline {

class LightMap {
 public:
  // Bakes on up to `threads` threads; the result does not depend on how many.
  static LightMap Bake(const World& world, const RayCaster& caster,
                       int threads);

  // The light of a cloudy day: more from above, and from some sides than from
  // others, so that corners can be told.
  static LightMap Even(const World& world);
  static Float3 EvenLight(Float3 normal);

  // Light at (u, v) of a surface, per pi: times reflectance it is the radiance
  // of a matt surface. Bilinear between texels of about 6 cm.
  Float3 At(uint32_t surface, float u, float v) const;

 private:
  // The texels of one surface: u_count x v_count of them from `first`.
  struct Grid {
    int u_count = 1;
    int v_count = 1;
    size_t first = 0;
  };
  std::vector<Grid> grids_;
  std::vector<Float3> texels_;
};

}  // namespace treeline

#endif  // COMMON_SYNTHETIC_LIGHT_MAP_H_
