#include "simulation/renderer/hit_normals.h"

namespace treeline::renderer {
namespace {

std::vector<worlds::Float3> NormalsOf(
    const std::vector<worlds::Surface>& surfaces) {
  std::vector<worlds::Float3> normals;
  normals.reserve(surfaces.size());
  for (const worlds::Surface& surface : surfaces)
    normals.push_back(surface.Normal());
  return normals;
}

}  // namespace

HitNormals::HitNormals(const worlds::World& world)
    : fixed_(NormalsOf(world.surfaces)) {
  bodies_.reserve(world.bodies.size());
  for (const worlds::Body& body : world.bodies) {
    bodies_.push_back(NormalsOf(body.surfaces));
  }
}

worlds::Float3 HitNormals::At(const WorldSnapshot& snapshot,
                              const RayHit& hit) const {
  if (hit.instance == RayHit::kFixed) return fixed_[hit.surface];
  const worlds::BodyInstance& instance =
      snapshot.instances()[static_cast<size_t>(hit.instance)];
  const worlds::Float3 normal =
      bodies_[static_cast<size_t>(instance.body)][hit.surface];
  // Normals of a stretched body shrink where it grows.
  const worlds::Float3 stretched = {normal.x / instance.scale.x,
                                    normal.y / instance.scale.y,
                                    normal.z / instance.scale.z};
  return worlds::Normalized(instance.world_from_body.Direction(stretched));
}

}  // namespace treeline::renderer
