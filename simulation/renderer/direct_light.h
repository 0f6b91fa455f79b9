// Light that comes straight from lamps, windows and the sun.
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
  // From one receiver of the surface to the next, in u and in v.
  float step_u = 0;
  float step_v = 0;
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

// Light of the sun, per pi: the mean over the square that the receiver stands
// for, so that edges of shadows are as soft as squares are large. Not part of
// the two above.
worlds::Float3 SunLight(const worlds::World& world, const RayCaster& caster,
                        const LightReceiver& receiver, base::Random& random);
// The same of a point in the air on what faces the sun, by its middle.
worlds::Float3 SunAt(const worlds::Sunbeam& beam, const RayCaster& caster,
                     worlds::Float3 point);

// The lights that may shine on receivers of one surface, rows of `width` of
// them: not those that are too faint there, face elsewhere, or are hidden from
// the patch's corners and middles.
std::vector<size_t> LightsOf(const worlds::World& world,
                             const RayCaster& caster,
                             std::span<const LightReceiver> patch,
                             size_t width);

}  // namespace treeline::renderer

#endif  // SIMULATION_RENDERER_DIRECT_LIGHT_H_
