// Light that comes straight from lamps and windows.
#ifndef COMMON_SYNTHETIC_DIRECT_LIGHT_H_
#define COMMON_SYNTHETIC_DIRECT_LIGHT_H_

#include <cstdint>
#include <span>
#include <vector>

#include "common/base/random.h"
#include "common/synthetic/ray_caster.h"
#include "common/synthetic/world.h"

namespace treeline {

// A point just before a surface, where light is computed.
struct LightReceiver {
  uint32_t surface = 0;
  float u = 0;
  float v = 0;
  Float3 point;
  Float3 normal;
};

// Light of all lamps that falls on a receiver, per pi; sixteen samples each.
Float3 DirectLight(const World& world, const RayCaster& caster,
                   const LightReceiver& receiver, Random& random);

// The same of some lights only, and from a quarter of the samples where these
// agree on whether there is light.
Float3 QuickDirectLight(const World& world, std::span<const size_t> lights,
                        const RayCaster& caster, const LightReceiver& receiver,
                        Random& random);

// The lights that may shine on receivers of one surface, rows of `width` of
// them: not those that are too faint there, face elsewhere, or are hidden from
// the patch's corners and middles.
std::vector<size_t> LightsOf(const World& world, const RayCaster& caster,
                             std::span<const LightReceiver> patch,
                             size_t width);

}  // namespace treeline

#endif  // COMMON_SYNTHETIC_DIRECT_LIGHT_H_
