// How a forest is grown.
#ifndef SERVER_CORE_TRAINING_TRAINING_OPTIONS_H_
#define SERVER_CORE_TRAINING_TRAINING_OPTIONS_H_

#include <cstdint>

#include "absl/status/status.h"

namespace treeline::training {

// What splits below the balanced levels are chosen by.
enum class SplitObjective {
  kVariance,  // spatial variance (thesis Eq. 3.8)
  kEntropy    // entropy of a Gaussian with full covariance (Eq. 5.5)
};

// Defaults are what served best on held-out blocks of training frames of
// 7-Scenes red kitchen; see docs/research/benchmarks.md.
struct TrainingOptions {
  uint64_t seed = 0;
  // 0: one a processor.
  int threads = 0;
  // Trees of the forest, in [1, 64].
  int trees = 5;
  // Frames drawn at random for each tree, in [1, 65535].
  int frames_per_tree = 500;
  // Pixels drawn at random from each frame, for each tree, in [1, 20000].
  int samples_per_frame = 1000;
  // L_max: nodes of depth below this are split by the sample-balanced
  // objective (thesis Eq. 4.4), deeper ones by spatial variance (Eq. 3.8). In
  // [0, 40].
  int balanced_levels = 8;
  // Depth of the deepest leaf, in [1, 40].
  int max_depth = 25;
  // A node with fewer samples than twice this is a leaf, in [1, 1000].
  int min_leaf_samples = 2;
  // Leaves with fewer samples are left out of the tree once it is grown, and
  // the splits above those that have none left, in [0, 1000]: what two or three
  // samples share is chance, and most leaves have no more
  // (docs/research/model-size.md). 0: all stay; TrainScene takes what serves
  // the method.
  int min_kept_samples = 0;
  // A node whose samples lie within this root mean square distance of their
  // mean is a leaf (m), in [0, 10].
  double min_spread_m = 0.05;
  // Random features tried at each node, in [1, 1000].
  int split_candidates = 32;
  // Features look up to this far in x and y (px m, at 525 px focal length;
  // see PixelDifference), in [1, 127]; px if not depth-adaptive.
  double max_offset_px_m = 90;
  // Offsets shrink with depth (thesis Eq. 4.2); else they are the same at any
  // depth (Eq. 3.2), and queries need none.
  bool depth_adaptive = true;
  // Samples are points on line segments (thesis 5.4.1), not of all the image.
  bool line_points = false;
  SplitObjective objective = SplitObjective::kVariance;
  // Leaves have the modes that mean shift finds with this bandwidth (m, thesis
  // 5.4.4), in [0, 10]; 0: one mode, the mean.
  double mode_bandwidth_m = 0;
  // Objectives are computed on at most so many samples of a node, in
  // [10, 60000].
  int max_split_samples = 2000;
  // Decoded images kept in memory at a time (bytes). Trees are grown in groups
  // whose frames fit; a group has at least one tree.
  int64_t image_memory_bytes = int64_t{1} << 30;

  absl::Status Validate() const;
};

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_TRAINING_OPTIONS_H_
