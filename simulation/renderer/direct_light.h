// Light that comes straight from lamps and windows.
#ifndef SIMULATION_RENDERER_DIRECT_LIGHT_H_
#define SIMULATION_RENDERER_DIRECT_LIGHT_H_

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/random.h"
#include "simulation/renderer/ray_caster.h"
#include "simulation/worlds/world.h"

namespace treeline::renderer {

// A point just before a surface, where light is computed.
struct LightReceiver {
  uint32_t surface = 0;
  float u = 0;
  float v = 0;
  worlds::Float3 point;
  worlds::Float3 normal;
};

// Light of all lamps that falls on a receiver, per pi; sixteen samples each.
worlds::Float3 DirectLight(const worlds::World& world, const RayCaster& caster,
                           const LightReceiver& receiver, base::Random& random);

// The same of some lights only, and from a quarter of the samples where these
// agree on whether there is light.
worlds::Float3 QuickDirectLight(const worlds::World& world,
                                std::span<const size_t> lights,
                                const RayCaster& caster,
                                const LightReceiver& receiver,
                                base::Random& random);

// The lights that may shine on receivers of one surface, rows of `width` of
// them: not those that are too faint there, face elsewhere, or are hidden from
// the patch's corners and middles.
std::vector<size_t> LightsOf(const worlds::World& world,
                             const RayCaster& caster,
                             std::span<const LightReceiver> patch,
                             size_t width);

}  // namespace treeline::renderer

#endif  // SIMULATION_RENDERER_DIRECT_LIGHT_H_
