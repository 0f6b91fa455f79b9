// Where things stand and how they move in a synthetic world.
#ifndef SIMULATION_WORLDS_PLACEMENT_H_
#define SIMULATION_WORLDS_PLACEMENT_H_

#include <vector>

#include "simulation/worlds/float3.h"

namespace treeline::worlds {

// Where a piece stands in the world: it is turned by yaw about z, then moved.
// In its own frame a piece of furniture has x along the wall, y out of the
// wall into the room, and z up, and its back left corner (seen from above,
// looking along y) at the origin.
struct Placement {
  Float3 origin;
  float yaw_rad = 0;

  Float3 Direction(Float3 local) const;
  Float3 Point(Float3 local) const { return origin + Direction(local); }
  // The placement of something that stands at `local` within this one.
  Placement At(Float3 local, float turn_rad = 0) const {
    return {Point(local), yaw_rad + turn_rad};
  }
};

// A scripted motion: a pure function of time.
struct Motion {
  struct Key {
    double time_s = 0;
    Placement world_from_body;
  };
  // In order of time, at least one. Between two keys a body moves evenly and
  // turns by the shorter way; before the first and after the last it stands.
  std::vector<Key> keys;
  // > 0: it begins again after this time. At least the last key's time, which
  // a body takes to return to where the first one has it.
  double period_s = 0;

  Placement At(double time_s) const;
};

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_PLACEMENT_H_
