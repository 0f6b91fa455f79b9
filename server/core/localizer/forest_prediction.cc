#include "server/core/localizer/forest_prediction.h"

#include <algorithm>
#include <span>

#include "common/base/status_macros.h"
#include "server/core/forest/backtracking.h"
#include "server/core/localizer/parameters.h"

namespace treeline::localizer {
namespace {

// Leaves are fetched this many predictions ahead of their use.
constexpr size_t kPayloadsAhead = 16;

}  // namespace

SampleBatch NextBatch(const QueryOptions& options, size_t begin,
                      size_t samples) {
  const size_t first = static_cast<size_t>(options.first_samples);
  return {begin, begin == 0 ? std::min(first, samples) : samples};
}

absl::Status PredictScene(const forest::ForestView& forest,
                          const QueryOptions& options,
                          const features::RgbdSamples& samples,
                          const SampleBatch& batch, Query& query,
                          std::vector<pose::ScenePrediction>& predictions) {
  const size_t count = batch.end - batch.begin;
  const forest::SampleView view{
      std::span(samples.x).subspan(batch.begin, count),
      std::span(samples.y).subspan(batch.begin, count),
      std::span(samples.inverse_depth_q12).subspan(batch.begin, count)};
  QueryScratch& scratch = query.scratch();
  scratch.descriptors.resize(count);
  features::ComputeWht(query.image(), view.x, view.y, scratch.descriptors);
  scratch.matches.resize(count * static_cast<size_t>(forest.trees()));
  const forest::BacktrackingOptions backtracking{
      .leaves = options.backtracking_leaves,
      .first_leaves = options.first_leaves,
      .good_squared_distance = options.good_distance * options.good_distance};
  forest::PredictLeaves(forest, query.image(), view, scratch.descriptors,
                        backtracking, query.stop(), scratch.backtracking,
                        scratch.matches);
  TL_RETURN_IF_ERROR(query.CheckStop());
  predictions.reserve(predictions.size() + scratch.matches.size());
  const std::span<const forest::LeafMatch> matches(scratch.matches);
  for (size_t i = 0; i < matches.size(); ++i) {
    // Each is somewhere in memory.
    if (i + kPayloadsAhead < matches.size()) {
      __builtin_prefetch(&forest.payloads[matches[i + kPayloadsAhead].leaf]);
    }
    predictions.push_back(PredictionOf(forest, matches[i].leaf));
  }
  return absl::OkStatus();
}

pose::ScenePrediction PredictionOf(const forest::ForestView& forest,
                                   uint32_t mode) {
  const forest::LeafPayload& leaf = forest.payloads[mode];
  pose::ScenePrediction prediction;
  prediction.mean_in_world = forest.LeafMean(mode);
  const double total = leaf.count + kPriorSamples;
  for (size_t k = 0; k < 6; ++k) {
    prediction.covariance[k] =
        leaf.count / total *
        static_cast<double>(forest::FromBfloat16(leaf.covariance[k]));
  }
  const double prior = kPriorSamples / total * kPriorSigma_m * kPriorSigma_m;
  for (const size_t k : {0u, 3u, 5u}) prediction.covariance[k] += prior;
  return prediction;
}

}  // namespace treeline::localizer
