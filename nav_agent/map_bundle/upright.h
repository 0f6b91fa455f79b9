// Which way is up in a map that a camera made: its first picture says nothing
// of gravity.
#ifndef NAV_AGENT_MAP_BUNDLE_UPRIGHT_H_
#define NAV_AGENT_MAP_BUNDLE_UPRIGHT_H_

#include <cstdint>
#include <span>

#include "common/geometry/rigid3.h"

namespace treeline::map_bundle {

struct UprightMap {
  // z up, and 0 on the floor; x and y of the map's origin are 0.
  geometry::Rigid3 level_from_map;
  // Whether a level surface was found; else `up_guess` was used.
  bool has_surface = false;
  // The share of the points that lie on it.
  double share = 0;
};

// Looks for the largest plane whose normal is within 0.6 rad of
// up_guess_in_map (of any length): floors and table tops say where up is
// (RANSAC, then least squares). The floor is that plane if hardly anything is
// below, and the lowest of the points else. Deterministic by seed. Without
// points: only turned.
UprightMap FindUpright(std::span<const geometry::Vec3> points_in_map,
                       geometry::Vec3 up_guess_in_map, uint64_t seed);

}  // namespace treeline::map_bundle

#endif  // NAV_AGENT_MAP_BUNDLE_UPRIGHT_H_
