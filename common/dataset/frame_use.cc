#include "common/dataset/frame_use.h"

#include <algorithm>

namespace treeline::dataset {

FrameUse UseOfFrame(int frame, int frame_count) {
  const int cycle = std::clamp(frame_count / 5, 5, 100);
  const double place =
      static_cast<double>(frame % cycle) / static_cast<double>(cycle);
  if (place < 0.6) return FrameUse::kTrain;
  if (place >= 0.7 && place < 0.9) return FrameUse::kTest;
  return FrameUse::kNeither;
}

}  // namespace treeline::dataset
