// How the parts of a TUM RGB-D sequence belong together in time.
#ifndef COMMON_DATASET_TUM_H_
#define COMMON_DATASET_TUM_H_

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/dataset/dataset_index.h"
#include "common/dataset/text_formats.h"

namespace treeline::dataset {

// Pairs entries of `a` with entries of `b` less than max_difference apart, one
// to one, the closest pairs first (as TUM's associate.py). Both ascend. The
// result has for each entry of `a` its partner's index in `b`, or -1.
std::vector<int> AssociateByTime(std::span<const Time_ns> a,
                                 std::span<const Time_ns> b,
                                 Time_ns max_difference);

// The pose at `time`, between its neighbours (rotation along the shorter arc).
// nullopt before the first, after the last, and between neighbours that are
// more than max_gap apart. `poses` ascends in time.
std::optional<geometry::Rigid3> InterpolatePose(
    std::span<const TimedPose> poses, Time_ns time, Time_ns max_gap);

// The colour camera of a sequence in `folder`, by the first of its folder
// names from the right that contains freiburg1/fr1, freiburg2/fr2 or
// freiburg3/fr3; TUM's recommended default (ROS) if none does.
std::string TumColorCamera(const std::string& folder);

// TUM RGB-D: DIR/{rgb,depth,groundtruth}.txt. Colour images without a depth
// image in time have no depth; without ground truth in time, no pose.
absl::StatusOr<DatasetIndex> IndexTum(const IndexRequest& request);

}  // namespace treeline::dataset

#endif  // COMMON_DATASET_TUM_H_
