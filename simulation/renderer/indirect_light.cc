#include "simulation/renderer/indirect_light.h"

namespace treeline::renderer {

worlds::Float3 GivenOn(const worlds::World& world,
                       const worlds::Surface& surface, worlds::Float3 light) {
  return world.lighting == building::Lighting::kDay
             ? surface.Leaving(light)
             : surface.reflection * light;
}

}  // namespace treeline::renderer
