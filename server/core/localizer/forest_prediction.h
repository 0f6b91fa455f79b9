// Scene coordinates from a pixel-difference forest: what the sources on such
// forests share.
#ifndef SERVER_CORE_LOCALIZER_FOREST_PREDICTION_H_
#define SERVER_CORE_LOCALIZER_FOREST_PREDICTION_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "server/core/features/rgbd_samples.h"
#include "server/core/forest/forest.h"
#include "server/core/localizer/query.h"
#include "server/core/localizer/query_options.h"
#include "server/core/pose/scene_predictions.h"

namespace treeline::localizer {

// Samples [begin, end).
struct SampleBatch {
  size_t begin = 0;
  size_t end = 0;
};

// The next samples to predict for: those after the first `begin`, up to
// options.first_samples of them at first, and all that are left then.
SampleBatch NextBatch(const QueryOptions& options, size_t begin,
                      size_t samples);

// Appends the scene coordinates that `forest` predicts at a batch of `samples`
// in the query's image, for each sample the best match of every tree, nearest
// descriptor first; leaf covariances are widened for leaves of few samples.
// CANCELLED after the query's stop.
absl::Status PredictScene(const forest::ForestView& forest,
                          const QueryOptions& options,
                          const features::RgbdSamples& samples,
                          const SampleBatch& batch, Query& query,
                          std::vector<pose::ScenePrediction>& predictions);

// A leaf's mode as a prediction.
pose::ScenePrediction PredictionOf(const forest::ForestView& forest,
                                   uint32_t mode);

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_FOREST_PREDICTION_H_
