// Where a robot is in a building of several levels.
#ifndef NAV_AGENT_CORE_LEVEL_POSE_H_
#define NAV_AGENT_CORE_LEVEL_POSE_H_

#include "common/geometry/rigid2.h"

namespace treeline::core {

// Ground that a robot stands on: a level of the map, from 0 at the bottom, and
// the height of its surface in the map's frame (m).
struct LevelPlace {
  int level = 0;
  double height_m = 0;

  constexpr bool operator==(const LevelPlace&) const = default;
};

// The robot as a map sees it from above, and what it stands on.
struct LevelPose {
  geometry::Rigid2 map_from_base;
  LevelPlace place;

  constexpr bool operator==(const LevelPose&) const = default;
};

}  // namespace treeline::core

#endif  // NAV_AGENT_CORE_LEVEL_POSE_H_
