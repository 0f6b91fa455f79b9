// When the frames of a recording were taken.
#ifndef COMMON_DATASET_FRAME_TIMES_H_
#define COMMON_DATASET_FRAME_TIMES_H_

#include <cstdint>
#include <vector>

#include "common/dataset/dataset.h"
#include "common/dataset/text_formats.h"

namespace treeline::dataset {

// Of formats without time stamps.
inline constexpr int64_t kFrameRate_hz = 30;

// One for each frame, in the order of the frames: its stem where that is a time
// stamp (TUM). Otherwise frames are numbered at kFrameRate_hz: frame n of a
// sequence is taken n periods after 0, and where the numbers do not go on (the
// next sequence, names without numbers), a frame comes one period after the one
// before it. Only time stamps can descend.
std::vector<Time_ns> FrameTimes(const Dataset& dataset);

}  // namespace treeline::dataset

#endif  // COMMON_DATASET_FRAME_TIMES_H_
