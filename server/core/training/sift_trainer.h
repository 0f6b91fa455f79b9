// From photographs with a structure from motion to a forest on SIFT features
// (thesis 4.2.2, 4.3.2).
#ifndef SERVER_CORE_TRAINING_SIFT_TRAINER_H_
#define SERVER_CORE_TRAINING_SIFT_TRAINER_H_

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/dataset/dataset.h"
#include "server/core/features/sift_extractor.h"
#include "server/core/forest/forest.h"

namespace treeline::training {

// Defaults are what served best on every eighth training image of South
// Building; see docs/research/structure-from-motion.md.
struct SiftTrainingOptions {
  uint64_t seed = 0;
  // 0: one a processor.
  int threads = 0;
  // Trees of the forest, in [1, 64].
  int trees = 5;
  // Images drawn at random for each tree, in [1, 65535].
  int images_per_tree = 300;
  // What is taken for a feature; a query should take the same.
  features::SiftOptions features{.max_features = 4000};
  // A feature within this distance of a keypoint of the model shows that
  // keypoint's point (px), in (0, 10].
  double label_radius_px = 1.5;
  // Nodes of depth below this are split by the sample-balanced objective
  // (Eq. 4.4), deeper ones by spatial variance (Eq. 3.8), in [0, 40].
  int balanced_levels = 8;
  // Depth of the deepest leaf, in [1, 40].
  int max_depth = 25;
  // A node with so many samples or fewer is a leaf, in [1, 32].
  int leaf_samples = 32;
  // Random dimensions tried at each node, in [1, 1000].
  int split_candidates = 16;

  absl::Status Validate() const;
};

struct TrainedSiftForest {
  forest::Forest forest;
  int images = 0;       // distinct images that were used
  int64_t samples = 0;  // over all trees
  // Median distance from a training camera to a point it observes (world
  // units): what errors are relative to where units are arbitrary.
  double viewing_distance = 0;
};

// Grows a forest on the images of `dataset`, which must have a structure. Each
// feature of an image that lies on a keypoint of the model is a sample: its
// descriptor and the keypoint's point. A leaf has a mode for each point that
// reached it (at most 32, those with most samples): the point's position, its
// uncertainty as the training cameras' rays leave it for one pixel of noise,
// and its samples' mean descriptor. Points far outside of the others are left
// out, for positions are stored relative to the bounds of all. The result
// depends on data and options (but for threads) alone. Shows progress on
// standard error unless quiet.
//
// INVALID_ARGUMENT for bad options; FAILED_PRECONDITION for a dataset without
// structure, or if no feature lies on a keypoint; CANCELLED after `stop`; and
// whatever reading an image gives.
absl::StatusOr<TrainedSiftForest> TrainSiftForest(
    const dataset::Dataset& dataset, const SiftTrainingOptions& options,
    bool quiet, const std::stop_token& stop);

// For each feature, the point of the nearest keypoint that has one within
// radius_px; -1: none. Ties go to the earlier keypoint.
std::vector<int32_t> LabelFeatures(
    std::span<const features::SiftKeypoint> features,
    std::span<const dataset::SfmModel::Keypoint> keypoints, double radius_px);

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_SIFT_TRAINER_H_
