#include "server/core/localizer/pose_source.h"

#include <algorithm>
#include <cmath>

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

int CountPlaces(const RayObservations& seen, const pose::RefinedPose& pose,
                double apart_px, int enough) {
  std::vector<camera::Pixel> places;
  for (size_t i = 0; i < seen.size(); ++i) {
    if (static_cast<int>(places.size()) >= enough) break;
    if (pose.supported[i] < 0) continue;
    const camera::Pixel& pixel = seen.pixel[i];
    const bool is_another =
        std::ranges::all_of(places, [&](const camera::Pixel& place) {
          return std::hypot(pixel.x - place.x, pixel.y - place.y) >= apart_px;
        });
    if (is_another) places.push_back(pixel);
  }
  return static_cast<int>(places.size());
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
