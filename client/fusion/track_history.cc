#include "client/fusion/track_history.h"

#include <algorithm>

#include "client/fusion/gaussian_pose.h"
#include "client/fusion/radians.h"

namespace treeline::drift {
namespace {

using geometry::Rigid3;
using std::chrono::nanoseconds;

constexpr double Squared(double value) { return value * value; }

}  // namespace

double SecondsBetween(nanoseconds from, nanoseconds to) {
  return std::chrono::duration<double>(to - from).count();
}

const TrackedPose* TrackHistory::oldest() const {
  return samples_.empty() ? nullptr : &samples_.front();
}

const TrackedPose* TrackHistory::newest() const {
  return samples_.empty() ? nullptr : &samples_.back();
}

bool TrackHistory::IsBroken(nanoseconds time,
                            const Rigid3& device_from_camera) const {
  const TrackedPose* last = newest();
  if (last == nullptr) return false;
  const double passed_s = SecondsBetween(last->time, time);
  const geometry::PoseError step =
      ErrorBetween(device_from_camera, last->device_from_camera);
  return passed_s > options_.max_gap_s ||
         step.translation_m > options_.max_speed_mps * passed_s ||
         step.rotation_rad > Radians(options_.max_turn_degps) * passed_s;
}

const TrackedPose& TrackHistory::Add(nanoseconds time,
                                     const Rigid3& device_from_camera) {
  TrackedPose sample{.time = time, .device_from_camera = device_from_camera};
  if (const TrackedPose* last = newest(); last != nullptr) {
    const geometry::PoseError step =
        ErrorBetween(device_from_camera, last->device_from_camera);
    sample.moved_m = last->moved_m + step.translation_m;
    sample.turned_rad = last->turned_rad + step.rotation_rad;
  }
  samples_.push_back(sample);
  while (SecondsBetween(samples_.front().time, time) > options_.history_s) {
    samples_.pop_front();
  }
  return samples_.back();
}

std::optional<TrackedPose> TrackHistory::At(nanoseconds time) const {
  const auto after =
      std::ranges::lower_bound(samples_, time, {}, &TrackedPose::time);
  if (after == samples_.end()) return std::nullopt;
  if (after->time == time) return *after;
  if (after == samples_.begin()) return std::nullopt;
  const TrackedPose& a = *std::prev(after);
  const TrackedPose& b = *after;
  const double t =
      SecondsBetween(a.time, time) / SecondsBetween(a.time, b.time);
  const auto between = [t](auto from, auto to) {
    return from + t * (to - from);
  };
  return TrackedPose{
      .time = time,
      .device_from_camera = {Slerp(a.device_from_camera.rotation,
                                   b.device_from_camera.rotation, t),
                             between(a.device_from_camera.translation,
                                     b.device_from_camera.translation)},
      .moved_m = between(a.moved_m, b.moved_m),
      .turned_rad = between(a.turned_rad, b.turned_rad)};
}

geometry::PoseCovariance TrackHistory::Drift(const TrackedPose& from,
                                             const TrackedPose& to) const {
  const double moved_m = to.moved_m - from.moved_m;
  const double turned_rad = to.turned_rad - from.turned_rad;
  const double passed_s = SecondsBetween(from.time, to.time);
  return Diagonal(
      Squared(options_.drift_m_per_sqrt_m) * moved_m +
          Squared(options_.drift_m_per_sqrt_s) * passed_s,
      Squared(Radians(options_.drift_deg_per_sqrt_m)) * moved_m +
          Squared(Radians(options_.drift_deg_per_sqrt_rad)) * turned_rad +
          Squared(Radians(options_.drift_deg_per_sqrt_s)) * passed_s);
}

}  // namespace treeline::drift
