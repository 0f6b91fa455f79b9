#include "nav_agent/behavior/scan_watch.h"

#include <algorithm>
#include <cmath>

namespace treeline::behavior {

ScanVerdict ScanWatch::Watch(const localization::RobotTracker& tracker,
                             const ScanFitLimits& limits) {
  const std::optional<base::MonotonicTime> stamp = tracker.ScanStamp();
  if (!stamp.has_value() || stamp == last_) return ScanVerdict::kNothingNew;
  last_ = stamp;
  const std::optional<localization::TrackedPose> pose = tracker.PoseAt(*stamp);
  if (!pose.has_value()) return ScanVerdict::kNothingNew;
  const std::optional<localization::ScanFit> fit = tracker.FitAt(pose->pose);
  if (!fit.has_value() || fit->judged < limits.min_judged) {
    return ScanVerdict::kNothingNew;
  }
  return fit->explained >= limits.min_explained &&
                 fit->contradicted <= limits.max_contradicted
             ? ScanVerdict::kGood
             : ScanVerdict::kBad;
}

void ScanWatch::Count(ScanVerdict verdict) {
  good_ += verdict == ScanVerdict::kGood ? 1 : 0;
  bad_ += verdict == ScanVerdict::kBad ? 1 : 0;
}

void ScanWatch::CountInRow(ScanVerdict verdict) {
  if (verdict == ScanVerdict::kBad) good_ = 0;
  Count(verdict);
}

void ScanWatch::ForgetCounts() {
  good_ = 0;
  bad_ = 0;
}

double TurnMeter::Add_rad(double yaw_rad) {
  const double turned_rad =
      last_yaw_rad_.has_value()
          ? std::abs(geometry::NormalizedAngle_rad(yaw_rad - *last_yaw_rad_))
          : 0;
  last_yaw_rad_ = yaw_rad;
  return turned_rad;
}

bool IsPoseGathered(const localization::RobotTracker& tracker, double min_share,
                    double max_std_m) {
  const std::optional<localization::TrackedPose> pose = tracker.Pose();
  return pose.has_value() && pose->share >= min_share && !pose->is_searching &&
         std::sqrt(std::max(pose->covariance[0], pose->covariance[4])) <=
             max_std_m;
}

bool IsPoseTight(const localization::RobotTracker& tracker, double min_share,
                 double max_std_m) {
  return IsPoseGathered(tracker, min_share, max_std_m) &&
         !tracker.Pose()->in_doubt;
}

}  // namespace treeline::behavior
