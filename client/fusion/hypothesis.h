// Where the world may be, and which fixes say so.
#ifndef CLIENT_FUSION_HYPOTHESIS_H_
#define CLIENT_FUSION_HYPOTHESIS_H_

#include <chrono>
#include <cstdint>
#include <vector>

#include "client/fusion/drift_options.h"
#include "client/fusion/gaussian_pose.h"
#include "client/fusion/track_history.h"

namespace treeline::drift {

// A fix, carried along the tracking to the newest tracked pose.
struct CarriedFix {
  GaussianPose now;
  double confidence = 0;
  TrackedPose captured;
};

// device_from_camera of views, no two of which are alike. No more are kept than
// are asked for, so that neither memory nor work grows with time.
class DistinctViews {
 public:
  // Views differ if they are so far apart or turned so much.
  DistinctViews(int enough, double distance_m, double angle_rad)
      : enough_(enough), distance_m_(distance_m), angle_rad_(angle_rad) {}

  void Add(const geometry::Rigid3& device_from_camera);
  // At most `enough`.
  int count() const { return static_cast<int>(views_.size()); }
  bool AreEnough() const { return count() >= enough_; }

 private:
  int enough_;
  double distance_m_;
  double angle_rad_;
  std::vector<geometry::Rigid3> views_;
};

class Hypothesis {
 public:
  // `options` outlives this.
  Hypothesis(const CarriedFix& first, const DriftOptions& options);

  // At the newest tracked pose.
  const GaussianPose& pose() const { return pose_; }
  // Capture time of the newest fix that supports it.
  std::chrono::nanoseconds supported() const { return supported_; }
  int64_t fixes() const { return fixes_; }
  // At most contradiction_views.
  int contradiction_views() const { return contradiction_views_.count(); }

  // Along the tracking to its newest pose, whose drift since is `drift`.
  void Follow(const TrackedPose& from, const TrackedPose& to,
              const geometry::PoseCovariance& drift);

  // Takes a fix that agrees into account.
  void Support(const CarriedFix& fix);

  // Whether its fixes are enough for a world to begin with.
  bool MayLock() const;

  // Whether its fixes are enough against a world that contradicts them.
  bool MayContradict() const;

 private:
  bool AreOddsEnough() const;
  void Count(const CarriedFix& fix);

  const DriftOptions* options_;
  GaussianPose pose_;
  geometry::Rigid3 last_view_;  // device_from_camera
  double log_odds_ = 0;
  int64_t fixes_ = 0;
  std::chrono::nanoseconds supported_;
  DistinctViews lock_views_;
  DistinctViews contradiction_views_;
};

}  // namespace treeline::drift

#endif  // CLIENT_FUSION_HYPOTHESIS_H_
