// Which frames of a recording are learnt, and which are for tests.
#ifndef COMMON_DATASET_FRAME_USE_H_
#define COMMON_DATASET_FRAME_USE_H_

namespace treeline::dataset {

// Blocks of a cycle: 60 % training, a gap of 10 %, 20 % held out, another gap.
// Gaps belong to neither, so that held-out frames are not neighbours of
// training ones. Cycles are of 100 frames, or a fifth of a shorter recording.
enum class FrameUse { kTrain, kTest, kNeither };
FrameUse UseOfFrame(int frame, int frame_count);

}  // namespace treeline::dataset

#endif  // COMMON_DATASET_FRAME_USE_H_
