// Somebody walks about a world with a camera in hand, looking around.
#ifndef SIMULATION_RECORDER_WALK_H_
#define SIMULATION_RECORDER_WALK_H_

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/geometry/rigid3.h"
#include "simulation/worlds/world.h"

namespace treeline::recorder {

// A smooth path for all times: round after round through the walk area, each
// on another way and with other views, camera 1.2 to 1.6 m above the floor,
// about 0.4 m/s, gazes across the room and along the walls.
class Walk {
 public:
  Walk(const worlds::WalkArea& area, uint64_t seed);

  geometry::Rigid3 WorldFromCameraAt(double time_s) const;

 private:
  // sin(2 pi (time / period + phase)), of the k-th of the walk's waves.
  double Wave(int k, double period_s, double time_s) const;

  worlds::WalkArea area_;
  std::array<double, 12> phases_{};
  double direction_ = 1;
};

}  // namespace treeline::recorder

#endif  // SIMULATION_RECORDER_WALK_H_
