// From recorded RGB-D frames with poses to a forest.
#ifndef SERVER_CORE_TRAINING_FOREST_TRAINER_H_
#define SERVER_CORE_TRAINING_FOREST_TRAINER_H_

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "common/camera/rgbd_calibration.h"
#include "common/dataset/dataset.h"
#include "server/core/forest/forest.h"
#include "server/core/training/training_options.h"
#include "server/core/training/tree_grower.h"

namespace treeline::training {

struct TrainedForest {
  forest::Forest forest;
  int frames = 0;       // distinct frames that were used
  int64_t samples = 0;  // over all trees
};

// Trees of a forest, before positions are stored relative to the bounds of all.
struct GrownTrees {
  // As they were before the other frames joined; empty where all frames were
  // there from the beginning.
  std::vector<GrownTree> first;
  std::vector<GrownTree> trees;
  int64_t samples = 0;  // over these trees
};

// Trees [first, last) of the options.trees of a forest.
struct TreeRange {
  int first = 0;
  int last = 0;
};

// Grows some of the trees that TrainForests would grow: each is the same to the
// bit, whichever are grown with it. Errors as TrainForests, and
// INVALID_ARGUMENT for a range that is empty or not within [0, options.trees).
absl::StatusOr<GrownTrees> GrowTrees(const dataset::Dataset& dataset,
                                     const camera::RgbdCalibration& calibration,
                                     const TrainingOptions& options,
                                     std::span<const int> first_frames,
                                     TreeRange range, bool quiet,
                                     std::stop_token stop);

// How many distinct frames of `dataset` all trees of a forest draw together.
int CountDrawnFrames(const dataset::Dataset& dataset,
                     const TrainingOptions& options,
                     std::span<const int> first_frames);

// Grows a forest (thesis 4.2.3) on the frames of `dataset` that have a pose
// and depth. `calibration` holds for every frame; its pose_sensor must be the
// dataset's. The result depends on the data, the calibration and the options
// (but for threads), and on nothing else. Shows progress on standard error
// unless quiet.
//
// Errors: INVALID_ARGUMENT for bad options, FAILED_PRECONDITION if no frame is
// usable, CANCELLED after `stop`, and whatever reading a frame gives.
absl::StatusOr<TrainedForest> TrainForest(
    const dataset::Dataset& dataset, const camera::RgbdCalibration& calibration,
    const TrainingOptions& options, bool quiet, std::stop_token stop);

struct TrainedForests {
  // Of the first frames alone.
  forest::Forest first;
  TrainedForest all;
};

// The same in two rounds: some frames, ascending indices of those with a pose
// and depth, come first; the other frames then join the trees that grew from
// them, and growth goes on. The first forest knows nothing of the others, so
// that those can show what its answers are worth. If there are no first frames,
// nor is there a first forest.
absl::StatusOr<TrainedForests> TrainForests(
    const dataset::Dataset& dataset, const camera::RgbdCalibration& calibration,
    const TrainingOptions& options, std::span<const int> first_frames,
    bool quiet, std::stop_token stop);

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_FOREST_TRAINER_H_
