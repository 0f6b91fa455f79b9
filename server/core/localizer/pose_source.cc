#include "server/core/localizer/pose_source.h"

#include "server/core/localizer/parameters.h"

namespace treeline::localizer {
namespace {

// The prediction that a sample supports; -1: none.
int SupportedBy(const std::optional<pose::RefinedPose>& pose, size_t i) {
  return pose ? pose->supported[i] : -1;
}

}  // namespace

std::vector<Correspondence> CorrespondencesOf(
    const PointObservations& seen,
    const std::optional<pose::RefinedPose>& pose) {
  std::vector<Correspondence> correspondences;
  for (size_t i = 0; i < seen.size(); ++i) {
    const int k = SupportedBy(pose, i);
    correspondences.push_back({seen.pixel[i], seen.scene.point_in_camera[i],
                               seen.scene.at(i, std::max(k, 0)).mean_in_world,
                               k >= 0});
  }
  return correspondences;
}

std::vector<Correspondence> CorrespondencesOf(
    const RayObservations& seen, const std::optional<pose::RefinedPose>& pose) {
  std::vector<Correspondence> correspondences;
  for (size_t i = 0; i < seen.size(); ++i) {
    const int k = SupportedBy(pose, i);
    correspondences.push_back({seen.pixel[i],
                               {},
                               seen.scene.at(i, std::max(k, 0)).mean_in_world,
                               k >= 0});
  }
  return correspondences;
}

std::vector<Correspondence> MatchesOf(
    const RayObservations& seen, const std::optional<pose::RefinedPose>& pose) {
  std::vector<Correspondence> correspondences = CorrespondencesOf(seen, pose);
  if (!pose) return correspondences;
  const geometry::Rigid3 camera_from_world = pose->world_from_camera.Inverse();
  for (Correspondence& match : correspondences) {
    match.point_in_camera = camera_from_world * match.point_in_world;
  }
  return correspondences;
}

std::optional<AssumedLens> LensOf(const Query& query,
                                  const pose::RayPredictions& scene,
                                  const pose::RefinedPose& pose,
                                  double robust_scale) {
  if (!query.is_lens_open()) return std::nullopt;
  return FindAssumedLens(
      scene, pose.world_from_camera, robust_scale, query.camera(),
      query.is_camera_assumed() ? kMinUsualLensOdds : kMinGuessedLensOdds);
}

}  // namespace treeline::localizer
