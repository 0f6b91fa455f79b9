// Baselines: SIFT or ORB features of training keyframes with depth, matched
// against a query's, and a pose from 3D-2D matches (OpenCV throughout, but for
// the extractor that is our own).
#ifndef EVALUATION_ACCURACY_FEATURE_PNP_BASELINE_H_
#define EVALUATION_ACCURACY_FEATURE_PNP_BASELINE_H_

#include <memory>
#include <optional>
#include <stop_token>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/camera/rgbd_calibration.h"
#include "common/dataset/dataset.h"
#include "server/core/localizer/localizer.h"

namespace treeline::accuracy {

enum class FeatureKind {
  kSift,      // 128 floats, compared by Euclidean distance
  kOrb,       // 256 bits, compared by Hamming distance
  kFastSift,  // our own SIFT, see FastSift
};

// "sift-pnp", "orb-pnp" or "fast-sift-pnp": what --baseline and
// ModelInfo::method call it.
const char* BaselineName(FeatureKind kind);
// nullopt: no such baseline.
std::optional<FeatureKind> BaselineOfName(absl::string_view name);

struct FeaturePnpOptions {
  FeatureKind kind = FeatureKind::kSift;
  // Training frames to use, evenly spread over the list; 0: all of them.
  int keyframes = 140;
  // Features kept per image, strongest first; 0: all of SIFT's, 1000 of ORB's,
  // which has no end of its own, and as many of FastSift's as usual.
  int features = 0;
  // Where the training frames have a structure from motion: features kept of a
  // query, those of the largest regions, as method sift takes them; 0: as
  // above.
  int structure_features = 3000;
  // A match is kept if its descriptor distance is below this times that of the
  // nearest feature elsewhere in the scene (Lowe's ratio test), in (0, 1].
  double match_ratio = 0.8;
  // Features nearer than this (m) to the best match's place are the same
  // place seen from other keyframes, and no competition in the ratio test.
  double same_place_m = 0.1;
  // SIFT: leaves that FLANN's kd-trees look at per feature, in [1, 100000].
  // ORB is looked up by locality-sensitive hashing, which has none.
  int flann_checks = 128;
  // Reprojection error of an inlier (px).
  double inlier_px = 4;
  int ransac_iterations = 2000;
  // Fewer inliers are no answer.
  int min_inliers = 12;
  uint64_t seed = 0;
  bool quiet = false;  // no progress bar
  std::stop_token stop;

  absl::Status Validate() const;
};

// Learns the keyframes of `training`: features with depth, or those on points
// of its structure from motion, whose features and labels are those that
// method sift is trained on. `calibration` says how its depth camera
// sits beside its colour camera (its pose_sensor is ignored: the dataset's
// own holds). The result's poses are of the colour camera whatever those of
// the training frames are; its info().file_bytes is the memory of descriptors
// and points. OpenCV runs on one thread from here on. INVALID_ARGUMENT: bad
// options, or no keyframe gave a feature with depth and pose; CANCELLED.
absl::StatusOr<std::unique_ptr<localizer::Localizer>> BuildFeaturePnpBaseline(
    const dataset::Dataset& training,
    const camera::RgbdCalibration& calibration,
    const FeaturePnpOptions& options);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_FEATURE_PNP_BASELINE_H_
