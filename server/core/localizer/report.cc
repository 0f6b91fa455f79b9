#include "server/core/localizer/report.h"

#include <utility>

namespace treeline::localizer {

PoseEstimate Report(Candidate candidate, const Verdict* verdict) {
  PoseEstimate estimate;
  estimate.samples = candidate.samples;
  estimate.reason = candidate.reason;
  if (verdict != nullptr) {
    estimate.inliers = candidate.pose->inliers;
    estimate.inlier_ratio = candidate.inlier_ratio();
    estimate.reason = verdict->reason;
    estimate.outcome =
        verdict->is_believed() ? Outcome::kLocalized : Outcome::kNotLocalized;
    estimate.world_from_camera = verdict->world_from_camera;
    estimate.covariance = verdict->covariance;
    estimate.confidence = verdict->confidence;
    estimate.evidence = verdict->evidence;
  }
  estimate.correspondences = std::move(candidate.correspondences);
  return estimate;
}

}  // namespace treeline::localizer
