// The device's own tracking of the last seconds, and how uncertain it becomes.
#ifndef CLIENT_FUSION_TRACK_HISTORY_H_
#define CLIENT_FUSION_TRACK_HISTORY_H_

#include <chrono>
#include <deque>
#include <optional>

#include "client/fusion/drift_options.h"
#include "common/geometry/rigid3.h"

namespace treeline::drift {

// Seconds from `from` to `to`.
double SecondsBetween(std::chrono::nanoseconds from,
                      std::chrono::nanoseconds to);

struct TrackedPose {
  std::chrono::nanoseconds time{0};
  geometry::Rigid3 device_from_camera = {};
  // Since tracking began.
  double moved_m = 0;
  double turned_rad = 0;
};

// The poses of the last history_s.
class TrackHistory {
 public:
  // `options` outlives this.
  explicit TrackHistory(const DriftOptions& options) : options_(options) {}

  // nullptr: none. Valid until the next change.
  const TrackedPose* oldest() const;
  const TrackedPose* newest() const;

  void Clear() { samples_.clear(); }

  // Whether a sample cannot be the continuation of what came before: too late,
  // too far or turned too much.
  bool IsBroken(std::chrono::nanoseconds time,
                const geometry::Rigid3& device_from_camera) const;

  // A sample later than all others.
  const TrackedPose& Add(std::chrono::nanoseconds time,
                         const geometry::Rigid3& device_from_camera);

  // Where the camera was, between two samples on the line and the shorter arc;
  // nullopt before the first and after the last.
  std::optional<TrackedPose> At(std::chrono::nanoseconds time) const;

  // Covariance of the drift between two moments: it grows with the way.
  geometry::PoseCovariance Drift(const TrackedPose& from,
                                 const TrackedPose& to) const;

 private:
  const DriftOptions& options_;
  std::deque<TrackedPose> samples_;
};

}  // namespace treeline::drift

#endif  // CLIENT_FUSION_TRACK_HISTORY_H_
