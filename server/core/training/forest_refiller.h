// New frames for an old forest: its splits stay, its leaves learn (thesis
// 7.2.2; Cavallari et al., "On-the-fly adaptation of regression forests",
// 2017).
#ifndef SERVER_CORE_TRAINING_FOREST_REFILLER_H_
#define SERVER_CORE_TRAINING_FOREST_REFILLER_H_

#include <stop_token>

#include "absl/status/statusor.h"
#include "common/dataset/dataset.h"
#include "server/core/forest/forest.h"
#include "server/core/training/forest_trainer.h"
#include "server/core/training/leaf_filler.h"
#include "server/core/training/training_options.h"

namespace treeline::training {

// Sends the samples of every frame of `dataset` that has a pose and depth down
// the trees of `base`, and gathers them in modes (see LeafFiller).
//
// Of `options`, seed, threads, samples_per_frame and depth_adaptive count. The
// result does not depend on threads. FAILED_PRECONDITION if no frame is
// usable, CANCELLED after `stop`, and whatever reading a frame gives.
absl::StatusOr<TrainedForest> RefillForest(
    const forest::ForestView& base, const dataset::Dataset& dataset,
    const camera::RgbdCalibration& calibration, const TrainingOptions& options,
    Refill refill, bool quiet, const std::stop_token& stop);

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_FOREST_REFILLER_H_
