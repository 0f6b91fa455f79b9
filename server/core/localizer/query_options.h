// How hard a query tries: accuracy against time.
#ifndef SERVER_CORE_LOCALIZER_QUERY_OPTIONS_H_
#define SERVER_CORE_LOCALIZER_QUERY_OPTIONS_H_

#include "absl/status/status.h"

namespace treeline::localizer {

// Defaults are what served best on held-out blocks of training frames of
// 7-Scenes red kitchen; see docs/research/benchmarks.md.
struct QueryOptions {
  // Pixels sampled from a frame, in [30, 20000].
  int samples = 500;
  // SIFT features taken from a frame by method sift, in [100, 100000].
  int features = 3000;
  // N_max of thesis Algorithm 3: leaves visited in each tree, in [1, 32].
  int backtracking_leaves = 6;
  // A pose is first sought with so many of the samples, in [30, 20000], ...
  int first_samples = 200;
  // ... and they are enough if so many support it.
  int settled_inliers = 100;
  // A sample visits so many leaves in each tree at first, in [1, 32]; only if
  // the best descriptor is further than good_distance (in [0, 2000]) from its
  // own, backtracking_leaves of them (thesis 7.2.1). No less than those: all
  // samples visit as many.
  int first_leaves = 32;
  int good_distance = 0;
  // Hypotheses of preemptive RANSAC, in [1, 10000].
  int hypotheses = 128;
  // Whether a frame of which nobody said which way up it is is looked for in
  // other ways too, where it is not found; see OrientedLocalizer.
  bool other_turns = true;
  // Whether a focal length that does not fit is corrected. Where it is known,
  // nothing that features say against it is right.
  bool corrects_focal = true;

  absl::Status Validate() const;
};

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_QUERY_OPTIONS_H_
