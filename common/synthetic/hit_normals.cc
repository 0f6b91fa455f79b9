#include "common/synthetic/hit_normals.h"

namespace treeline {
namespace {

std::vector<Float3> NormalsOf(const std::vector<Surface>& surfaces) {
  std::vector<Float3> normals;
  normals.reserve(surfaces.size());
  for (const Surface& surface : surfaces) normals.push_back(surface.Normal());
  return normals;
}

}  // namespace

HitNormals::HitNormals(const World& world) : fixed_(NormalsOf(world.surfaces)) {
  bodies_.reserve(world.bodies.size());
  for (const Body& body : world.bodies) {
    bodies_.push_back(NormalsOf(body.surfaces));
  }
}

Float3 HitNormals::At(const WorldSnapshot& snapshot, const RayHit& hit) const {
  if (hit.instance == RayHit::kFixed) return fixed_[hit.surface];
  const BodyInstance& instance =
      snapshot.instances()[static_cast<size_t>(hit.instance)];
  const Float3 normal =
      bodies_[static_cast<size_t>(instance.body)][hit.surface];
  // Normals of a stretched body shrink where it grows.
  const Float3 stretched = {normal.x / instance.scale.x,
                            normal.y / instance.scale.y,
                            normal.z / instance.scale.z};
  return Normalized(instance.world_from_body.Direction(stretched));
}

}  // namespace treeline
