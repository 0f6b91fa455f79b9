// A pose from colour alone, by forest and PnP: all of method rgb, and the first
// stage of hybrid.
#ifndef SERVER_CORE_LOCALIZER_FOREST_PNP_H_
#define SERVER_CORE_LOCALIZER_FOREST_PNP_H_

#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "common/camera/camera.h"
#include "server/core/forest/forest.h"
#include "server/core/localizer/forest_query.h"
#include "server/core/localizer/localizer.h"
#include "server/core/localizer/query_options.h"
#include "server/core/pose/pnp.h"

namespace treeline::localizer {

struct ForestPnpResult {
  // Sample i of `scratch`, in the same slot. Empty if there were too few.
  pose::PixelPredictions scene;
  // nullopt: no pose explains the predictions.
  std::optional<pose::PnpResult> pose;
};

// Samples pixels of scratch.image, asks the forest (trained without depth
// adaptation) for their scene coordinates and solves Perspective-n-Point.
// Sets estimate.samples, and of its timings sample_ms and forest_ms. CANCELLED
// after options.stop.
absl::StatusOr<ForestPnpResult> SolveForestPnp(
    const forest::ForestView& forest, const camera::Camera& camera,
    const QueryOptions& query_options, const LocalizeOptions& options,
    ForestScratch& scratch, PoseEstimate& estimate);

// Fills inliers, their ratio, pose and covariance from a pose; supported by
// so many of estimate.samples.
void TakePose(const pose::PnpResult& pose, PoseEstimate& estimate);

// The correspondences of the samples.
std::vector<Correspondence> CorrespondencesOf(const ForestPnpResult& result,
                                              const ForestScratch& scratch);

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_FOREST_PNP_H_
