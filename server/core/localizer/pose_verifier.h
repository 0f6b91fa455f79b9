// The last stage of every localizer: a pose is made exact against the model's
// keyframes, what speaks for it is gathered, and it is believed or not.
#ifndef SERVER_CORE_LOCALIZER_POSE_VERIFIER_H_
#define SERVER_CORE_LOCALIZER_POSE_VERIFIER_H_

#include "absl/status/statusor.h"
#include "common/camera/rgbd_calibration.h"
#include "common/image/image.h"
#include "server/core/features/gray_pyramid.h"
#include "server/core/forest/model_file.h"
#include "server/core/keyframes/keyframe_map.h"
#include "server/core/localizer/localizer.h"

namespace treeline::localizer {

// The largest standard deviation of the position's axes (m).
double PositionSigma_m(const geometry::PoseCovariance& covariance);

// Immutable and thread-safe. The model must outlive it.
class PoseVerifier {
 public:
  // DATA_LOSS for corrupt keyframes.
  static absl::StatusOr<PoseVerifier> Create(const forest::ModelFile& model);

  const keyframes::KeyframeMap& keyframes() const { return keyframes_; }

  // `estimate` holds the pose that the predictions support, of
  // calibration.pose_sensor, with its covariance, inliers and inlier_ratio.
  // Aligns it with the keyframes around, where there are any; then sets
  // evidence, confidence, outcome and reason. depth may be null; of `options`,
  // min_confidence counts.
  void Judge(const features::GrayPyramid& image, const image::DepthImage* depth,
             const camera::RgbdCalibration& calibration,
             const LocalizeOptions& options, PoseEstimate& estimate) const;

 private:
  keyframes::KeyframeMap keyframes_;
  forest::ConfidenceModel confidence_;
};

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_POSE_VERIFIER_H_
