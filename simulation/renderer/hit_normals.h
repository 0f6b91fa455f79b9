// Which way the surfaces that rays hit face.
#ifndef SIMULATION_RENDERER_HIT_NORMALS_H_
#define SIMULATION_RENDERER_HIT_NORMALS_H_

#include <vector>

#include "simulation/renderer/ray_caster.h"
#include "simulation/worlds/world.h"

namespace treeline::renderer {

// Immutable and thread-safe.
class HitNormals {
 public:
  explicit HitNormals(const worlds::World& world);

  // The unit normal (world frame) of what was hit, on the side that the
  // surface shows. The hit must be one of the snapshot's, and not of nothing.
  worlds::Float3 At(const WorldSnapshot& snapshot, const RayHit& hit) const;
  // Of what never moves.
  worlds::Float3 OfSurface(uint32_t surface) const { return fixed_[surface]; }

 private:
  std::vector<worlds::Float3> fixed_;
  // Of each body's surfaces, in its own frame.
  std::vector<std::vector<worlds::Float3>> bodies_;
};

}  // namespace treeline::renderer

#endif  // SIMULATION_RENDERER_HIT_NORMALS_H_
