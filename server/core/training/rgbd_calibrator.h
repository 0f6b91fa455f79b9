// Estimates how depth and colour fit together, from the training frames.
#ifndef SERVER_CORE_TRAINING_RGBD_CALIBRATOR_H_
#define SERVER_CORE_TRAINING_RGBD_CALIBRATOR_H_

#include <stop_token>

#include "absl/status/statusor.h"
#include "common/camera/rgbd_calibration.h"
#include "common/dataset/dataset.h"

namespace treeline::training {

struct CalibratorOptions {
  // Frames looked at, spread evenly over the sequence, in [2, 1000].
  int frames = 60;
  // 0: one a processor.
  int threads = 0;
};

// What the calibration explains better than the nominal one did.
struct CalibrationReport {
  camera::RgbdCalibration calibration;
  int frames = 0;
  // Surfaces seen from two frames: root mean square distance (m) between them
  // along the surface normal, over overlapping pairs, before and after.
  int pairs = 0;
  double surface_rms_before_m = 0;
  double surface_rms_after_m = 0;
  // Mean strength of colour edges (grey levels per pixel, smoothed) found
  // where depth has its edges, before and after. 0: not used.
  double edge_strength_before = 0;
  double edge_strength_after = 0;
};

// Refines dataset.calibration() on the frames that have depth and a pose.
//
// Two sources are used. Surfaces: depth of one frame, carried by the poses into
// another, must lie on that frame's surfaces; this fixes the depth scale, and
// where the poses are the colour camera's, also color_from_depth (a hand-eye
// problem: the depth camera's motion is color_from_depth^-1 * motion *
// color_from_depth). Edges: depth jumps where one thing occludes another, and
// there colour usually changes too; this fixes how depth falls on the colour
// image: by the rotation between the cameras, or where the poses are the depth
// camera's by the colour camera, too. A colour camera that the poses are of
// stays as they were found with it. Depth that is already registered gets its
// scale alone. What few frames leave open stays near the nominal calibration.
//
// FAILED_PRECONDITION: fewer than two frames with depth and pose, no two that
// see the same surfaces, or poses that would fit the depth if they were meant
// otherwise (pose_convention.h). CANCELLED after `stop`.
absl::StatusOr<CalibrationReport> CalibrateRgbd(
    const dataset::Dataset& dataset, const CalibratorOptions& options,
    bool quiet, const std::stop_token& stop);

// FAILED_PRECONDITION if the poses would fit the depth when meant otherwise
// (pose_convention.h). Frames without depth or pose say nothing.
absl::Status CheckPoses(const dataset::Dataset& dataset,
                        const CalibratorOptions& options, bool quiet,
                        const std::stop_token& stop);

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_RGBD_CALIBRATOR_H_
