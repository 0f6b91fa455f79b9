#include "client/fusion/hypothesis.h"

#include <algorithm>
#include <cmath>

#include "client/fusion/radians.h"

namespace treeline::drift {
namespace {

using geometry::Rigid3;

bool AreDistinct(const Rigid3& a, const Rigid3& b, double distance_m,
                 double angle_rad) {
  const geometry::PoseError difference = ErrorBetween(a, b);
  return difference.translation_m >= distance_m ||
         difference.rotation_rad >= angle_rad;
}

}  // namespace

void DistinctViews::Add(const Rigid3& device_from_camera) {
  if (AreEnough()) return;
  if (std::ranges::all_of(views_, [&](const Rigid3& other) {
        return AreDistinct(device_from_camera, other, distance_m_, angle_rad_);
      })) {
    views_.push_back(device_from_camera);
  }
}

Hypothesis::Hypothesis(const CarriedFix& first, const DriftOptions& options)
    : options_(&options),
      pose_(first.now),
      last_view_(first.captured.device_from_camera),
      supported_(first.captured.time),
      lock_views_(options.lock_views, options.lock_view_m,
                  Radians(options.lock_view_deg)),
      contradiction_views_(options.contradiction_views,
                           options.contradiction_view_m,
                           Radians(options.contradiction_view_deg)) {
  Count(first);
}

void Hypothesis::Follow(const TrackedPose& from, const TrackedPose& to,
                        const geometry::PoseCovariance& drift) {
  const Rigid3 world_from_camera = pose_.world_from_camera *
                                   from.device_from_camera.Inverse() *
                                   to.device_from_camera;
  const geometry::Vec3 moved_in_world =
      world_from_camera.translation - pose_.world_from_camera.translation;
  pose_ = {world_from_camera,
           Sum(Transported(pose_.covariance, moved_in_world), drift)};
}

void Hypothesis::Support(const CarriedFix& fix) {
  const Rigid3& view = fix.captured.device_from_camera;
  const double factor = AreDistinct(view, last_view_, options_->lock_view_m,
                                    Radians(options_->lock_view_deg))
                            ? 1
                            : options_->repeated_view_factor;
  pose_ = Fused(
      pose_, {fix.now.world_from_camera, Scaled(fix.now.covariance, factor)});
  last_view_ = view;
  supported_ = std::max(supported_, fix.captured.time);
  Count(fix);
}

bool Hypothesis::MayLock() const {
  return AreOddsEnough() &&
         (lock_views_.AreEnough() || fixes_ >= options_->lock_fixes);
}

bool Hypothesis::MayContradict() const {
  return AreOddsEnough() && contradiction_views_.AreEnough();
}

bool Hypothesis::AreOddsEnough() const {
  return log_odds_ >= std::log(options_->min_odds);
}

void Hypothesis::Count(const CarriedFix& fix) {
  const double most = options_->max_odds_of_fix;
  const double odds = fix.confidence * (1 + most) >= most
                          ? most
                          : fix.confidence / (1 - fix.confidence);
  log_odds_ += std::log(odds);
  ++fixes_;
  lock_views_.Add(fix.captured.device_from_camera);
  contradiction_views_.Add(fix.captured.device_from_camera);
}

}  // namespace treeline::drift
