// Splits of a recording whose test frames were taken from where no training
// frame was.
#ifndef EVALUATION_ACCURACY_FAR_SPLIT_H_
#define EVALUATION_ACCURACY_FAR_SPLIT_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "common/geometry/rigid3.h"
#include "evaluation/accuracy/training_distance.h"

namespace treeline::accuracy {

// Frames by index, ascending. What is in neither is too near to both.
struct FarSplit {
  std::vector<int> training;
  std::vector<int> test;
};

// Training frames are the first `count` with a pose; test frames are those of
// the rest that are beyond `near` of each of them. poses[i] is world_from_camera
// of frame i; nullopt: not known, and the frame is in neither.
FarSplit SplitAfterFirst(
    const std::vector<std::optional<geometry::Rigid3>>& poses, int count,
    const ViewLimits& near);

struct HoleOptions {
  ViewLimits near;
  // Holes are made until so many of the frames with a pose are for testing, or
  // no other hole leaves `least_training` of them for training. In (0, 1).
  double test_share = 0.2;
  double least_training = 0.4;
  uint64_t seed = 0;
};

// Holes in the space of poses: about frames drawn at random, those within half
// of `near` are for testing, and what is within `near` of any of these is left
// out. So test frames lie all over the recording, a little farther from the
// training frames than `near`. A function of its arguments alone.
FarSplit SplitByHoles(const std::vector<std::optional<geometry::Rigid3>>& poses,
                      const HoleOptions& options);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_FAR_SPLIT_H_
