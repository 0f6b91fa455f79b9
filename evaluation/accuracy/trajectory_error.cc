#include "evaluation/accuracy/trajectory_error.h"

namespace treeline::accuracy {

std::vector<dataset::PosePair> PosePairs(
    const std::vector<FrameResult>& results) {
  std::vector<dataset::PosePair> pairs;
  for (const FrameResult& result : results) {
    if (!result.error) continue;
    pairs.push_back({.estimate = result.estimate.world_from_camera,
                     .reference = *result.true_world_from_camera});
  }
  return pairs;
}

}  // namespace treeline::accuracy
