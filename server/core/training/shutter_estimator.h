// Whether a recording's rows were exposed one after the other, and how fast.
#ifndef SERVER_CORE_TRAINING_SHUTTER_ESTIMATOR_H_
#define SERVER_CORE_TRAINING_SHUTTER_ESTIMATOR_H_

#include <optional>
#include <span>
#include <stop_token>

#include "absl/status/statusor.h"
#include "common/camera/rgbd_calibration.h"
#include "common/dataset/dataset.h"
#include "common/geometry/rigid3.h"
#include "common/image/rolling_shutter.h"

namespace treeline::training {

// A frame as the estimator knows it: the colour camera at its time stamp.
struct MovingView {
  geometry::Rigid3 world_from_color;
  // About the colour camera's axes (rad/s).
  geometry::Vec3 turn_rate_rad_s;
};

// A point that two views saw.
struct SharedPoint {
  int from = 0;
  int to = 0;
  // Measured in `from`, on the ray of its pixel, colour camera's frame.
  geometry::Vec3 point_in_from;
  camera::Pixel ray_in_to;  // (x/z, y/z)
  // RowShare of its pixel in each.
  double share_in_from = 0;
  double share_in_to = 0;
};

struct ShutterEstimate {
  image::RollingShutter shutter;
  double readout_sigma_s = 0;
  // Median distance of points from where they are seen (in units of rays), all
  // rows at once and row by row.
  double median_before = 0;
  double median_after = 0;
};

// The readout time and the offset with which shared points fit best:
//   point_in_world = W_i exp(w_i s_i) r X_i
// of view i with pose W_i, turn rate w_i and s_i = offset + readout * share_i,
// seen likewise from view j; minimised is the robust sum of squares of its
// distance from the ray in j. What is common to all views (r, a rotation of
// the pose sensor in the camera, and a factor of the focal length) is free.
// The stated sigma takes what is seen from one view for one observation.
// nullopt: too few points.
std::optional<ShutterEstimate> EstimateShutter(
    std::span<const MovingView> views, std::span<const SharedPoint> points,
    double pixel);

// Whether the estimate is sure enough to be used: a readout time of a camera,
// far from 0, that explains something.
bool IsRolling(const ShutterEstimate& estimate);

// Of the frames of a recording that have depth, a pose and a known motion, by
// their SIFT features. nullopt: it is not to be told from an instantaneous
// shutter. CANCELLED after `stop`, and whatever reading a frame gives.
absl::StatusOr<std::optional<ShutterEstimate>> FindShutter(
    const dataset::Dataset& dataset, const camera::RgbdCalibration& calibration,
    int threads, bool quiet, const std::stop_token& stop);

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_SHUTTER_ESTIMATOR_H_
