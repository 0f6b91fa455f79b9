#include "server/core/localizer/forest_query.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline::localizer {
namespace {

// Leaves of few samples say little about their own spread: their covariance is
// averaged with this standard deviation (m) as if it came from this many
// samples.
constexpr double kPriorSigma_m = 0.02;
constexpr double kPriorSamples = 4;

absl::Status CheckSize(absl::string_view what, int width, int height,
                       const camera::Camera& camera) {
  if (width == camera.width() && height == camera.height()) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("the ", what, " image has ", width, " x ", height,
                   " pixels, but its camera is calibrated for ", camera.width(),
                   " x ", camera.height()));
}

}  // namespace

absl::Status CheckColor(const image::Frame& frame,
                        const camera::Camera& camera) {
  return CheckSize("colour", frame.color.width, frame.color.height, camera);
}

absl::Status CheckDepth(const image::Frame& frame, const camera::Camera& camera,
                        absl::string_view method) {
  if (!frame.depth) {
    return absl::InvalidArgumentError(
        absl::StrCat("this scene's method (", method,
                     ") needs a depth image, and the frame has none"));
  }
  return CheckSize("depth", frame.depth->width, frame.depth->height, camera);
}

SampleBatch NextBatch(const QueryOptions& options, size_t begin,
                      size_t samples) {
  const size_t first = static_cast<size_t>(options.first_samples);
  return {begin, begin == 0 ? std::min(first, samples) : samples};
}

bool IsSettled(const QueryOptions& options, int inliers) {
  return inliers >= options.settled_inliers;
}

absl::Status PredictScene(const forest::ForestView& forest,
                          const QueryOptions& options, const SampleBatch& batch,
                          const std::stop_token& stop, ForestScratch& scratch,
                          std::vector<pose::ScenePrediction>& predictions) {
  const features::RgbdSamples& all = scratch.samples;
  const size_t count = batch.end - batch.begin;
  const forest::SampleView samples{
      std::span(all.x).subspan(batch.begin, count),
      std::span(all.y).subspan(batch.begin, count),
      std::span(all.inverse_depth_q12).subspan(batch.begin, count)};
  scratch.descriptors.resize(count);
  features::ComputeWht(scratch.image, samples.x, samples.y,
                       scratch.descriptors);
  scratch.matches.resize(count * static_cast<size_t>(forest.trees()));
  const forest::BacktrackingOptions backtracking{
      .leaves = options.backtracking_leaves,
      .first_leaves = options.first_leaves,
      .good_squared_distance = options.good_distance * options.good_distance};
  forest::PredictLeaves(forest, scratch.image, samples, scratch.descriptors,
                        backtracking, stop, scratch.backtracking,
                        scratch.matches);
  if (stop.stop_requested()) {
    return absl::CancelledError("the query was cancelled");
  }
  predictions.reserve(predictions.size() + scratch.matches.size());
  for (const forest::LeafMatch& match : scratch.matches) {
    predictions.push_back(PredictionOf(forest, match.leaf));
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
