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

// Which frames of a recording are for training and which are held out. Blocks
// of a cycle: 60 % training, a gap of 10 %, 20 % held out, another gap. Gaps
// belong to neither, so that held-out frames are not neighbours of training
// ones. Cycles are of 100 frames, or a fifth of a shorter recording.
enum class FrameUse { kTrain, kTest, kNeither };
FrameUse UseOfFrame(int frame, int frame_count);

}  // namespace treeline::recorder

#endif  // SIMULATION_RECORDER_WALK_H_
