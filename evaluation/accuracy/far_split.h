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

// world_from_camera of each frame; nullopt: not known.
using FramePoses = std::vector<std::optional<geometry::Rigid3>>;

// Frames by index, ascending. What is in neither is too near to both, or has no
// pose.
struct FarSplit {
  std::vector<int> training;
  std::vector<int> test;
};

// The frames that are beyond `near` of every training camera. Ascending.
std::vector<int> FramesBeyond(
    const FramePoses& poses,
    const std::vector<geometry::Rigid3>& training_poses,
    const ViewLimits& near);

// Training frames are the first `count` with a pose; test frames are those of
// the rest that are beyond `near` of each of them.
FarSplit SplitAfterFirst(const FramePoses& poses, int count,
                         const ViewLimits& near);

struct HoleOptions {
  // (The braces let designated initialisers leave it out without a warning.)
  ViewLimits near{};
  // Holes are made until so many of the frames with a pose are for testing, or
  // no other hole leaves `min_training` of them for training. In (0, 1).
  double test_share = 0.2;
  double min_training = 0.4;
  uint64_t seed = 0;
};

// Holes in the space of poses: about frames drawn at random, those within half
// of `near` are for testing, and what is within `near` of any of these is left
// out. So test frames lie all over the recording, a little farther from the
// training frames than `near`. A function of its arguments alone.
FarSplit SplitByHoles(const FramePoses& poses, const HoleOptions& options);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_FAR_SPLIT_H_
