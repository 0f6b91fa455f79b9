// Which way the surfaces that rays hit face.
#ifndef COMMON_SYNTHETIC_HIT_NORMALS_H_
#define COMMON_SYNTHETIC_HIT_NORMALS_H_

#include <vector>

#include "common/synthetic/ray_caster.h"
#include "common/synthetic/world.h"

namespace treeline {

// Immutable and thread-safe.
class HitNormals {
 public:
  explicit HitNormals(const World& world);

  // The unit normal (world frame) of what was hit, on the side that the
  // surface shows. The hit must be one of the snapshot's, and not of nothing.
  Float3 At(const WorldSnapshot& snapshot, const RayHit& hit) const;
  // Of what never moves.
  Float3 OfSurface(uint32_t surface) const { return fixed_[surface]; }

 private:
  std::vector<Float3> fixed_;
  // Of each body's surfaces, in its own frame.
  std::vector<std::vector<Float3>> bodies_;
};

}  // namespace treeline

#endif  // COMMON_SYNTHETIC_HIT_NORMALS_H_
