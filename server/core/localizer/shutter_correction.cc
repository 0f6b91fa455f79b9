#include "server/core/localizer/shutter_correction.h"

#include <vector>

#include "server/core/keyframes/keyframe_features.h"
#include "server/core/localizer/parameters.h"

namespace treeline::localizer {

std::optional<pose::TurnEstimate> MeasureTurn(
    Query& query, const keyframes::KeyframeMap& map,
    const image::RollingShutter& shutter,
    const geometry::Rigid3& world_from_color) {
  const StageTimer timer(query.timings().features_ms);
  const std::vector<size_t> chosen =
      map.MostVisible(world_from_color, query.camera(), kTurnKeyframes);
  std::vector<pose::TimedRay> rays;
  for (const keyframes::KeyframeMatch& match :
       keyframes::MatchKeyframes(query.keyframe_features(map.sift_kind()), map,
                                 chosen, kMaxKeyframeRatio)) {
    const std::optional<camera::Pixel> ray =
        query.camera().Unproject(match.pixel);
    if (!ray) continue;
    rays.push_back({.point_in_world = match.point_in_world,
                    .ray = *ray,
                    .delay_s = shutter.offset_s +
                               shutter.readout_s *
                                   image::RowShare(match.pixel.y,
                                                   query.camera().height())});
  }
  const std::optional<pose::TurnEstimate> turn = pose::EstimateTurn(
      rays, world_from_color,
      {.robust_scale = kKeyframeRobustScale_px * query.pixel(),
       .inlier_distance = kTurnInlier_px * query.pixel(),
       .prior_sigma_rad_s = kTurnPriorSigma_rad_s,
       .min_inliers = kMinTurnMatches});
  if (!turn || turn->sigmas < kMinTurnSigmas) return std::nullopt;
  // Of the first and last row.
  const double moved =
      0.5 * shutter.readout_s * geometry::Norm(turn->turn_rate_rad_s);
  if (moved < kMinTurnedRows_px * query.pixel()) return std::nullopt;
  return turn;
}

}  // namespace treeline::localizer
