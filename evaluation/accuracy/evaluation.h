// How well a localizer does on a recording with known poses.
#ifndef EVALUATION_ACCURACY_EVALUATION_H_
#define EVALUATION_ACCURACY_EVALUATION_H_

#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "common/camera/rgbd_calibration.h"
#include "common/dataset/dataset.h"
#include "common/geometry/rigid3.h"
#include "evaluation/accuracy/perturbation.h"
#include "server/core/localizer/localizer.h"

namespace treeline::accuracy {

struct EvaluationOptions {
  // Given to every query, so that a frame's pose does not depend on which
  // other frames are evaluated.
  uint64_t seed = 0;
  // Frames localized at a time, in [1, 1024]. Latencies describe a single
  // query only with 1.
  int threads = 1;
  // What every query is said to be taken with; see QueryCalibration. nullopt:
  // what its frame says, or else the calibration stored with the scene.
  std::optional<camera::RgbdCalibration> calibration;
  // Least confidence of an answer, in [0, 1]; nullopt: the model's threshold.
  std::optional<double> min_confidence;
  // What Evaluate does to every frame before it is asked about, with `seed`.
  Perturbation perturbation;
  bool quiet = false;  // no progress bar
  std::stop_token stop;

  absl::Status Validate() const;
  // What a query is asked with.
  localizer::LocalizeOptions Query() const;
};

// What became of one frame.
struct FrameResult {
  std::string stem;
  // Which camera took it, where a recording has several: model, size and
  // parameters. Empty: the recording's only one.
  std::string camera{};
  // Not OK: the frame could not be read, or the localizer refused it. The
  // message names the file.
  absl::Status status;
  // Meaningful if status is OK. Holds no correspondences.
  localizer::PoseEstimate estimate;
  // Of the localizer's pose sensor, in the picture as it was asked about;
  // nullopt: not known, or there is none (see Perturbation::is_foreign).
  std::optional<geometry::Rigid3> true_world_from_camera;
  // Present where the frame was localized and the truth is known.
  std::optional<geometry::PoseError> error;
  // The same of the pose that was refused, where the frame was not localized
  // but one was found.
  std::optional<geometry::PoseError> refused_error;
  // Decoding colour and depth, files already read. nullopt: it failed.
  std::optional<double> decode_ms;
  // Localizer::Localize alone. nullopt: never came to it, or it refused.
  std::optional<double> latency_ms;
  // Processor time of the same: what it costs on a machine that others use.
  std::optional<double> cpu_ms;

  bool localized() const {
    return status.ok() && estimate.outcome == localizer::Outcome::kLocalized;
  }
  // Not localized, though there was a pose: it was not believed.
  bool refused_pose() const {
    return status.ok() && !localized() && estimate.inliers > 0;
  }
};

// Bounds on both errors of a pose: a frame is correct if it is below both.
struct PoseThreshold {
  // In units of the world: metres indoors, arbitrary for a scene whose labels
  // come from structure from motion.
  double translation_m = 0.05;
  double rotation_deg = 5;

  bool operator==(const PoseThreshold&) const = default;
};

struct Percentiles {
  double p50 = 0;
  double p95 = 0;
  double p99 = 0;
};

// Figures over all frames of an evaluation. nullopt: nothing to compute from.
struct EvaluationSummary {
  int frames = 0;
  int scored = 0;  // have ground truth
  int localized = 0;
  int errors = 0;  // could not be read or were refused
  // Fractions of the scored frames, in [0, 1]: errors and frames that were not
  // localized count as wrong.
  std::optional<double> correct_5cm_5deg;
  std::optional<double> correct_2cm_2deg;
  // Over localized frames with ground truth.
  std::optional<double> median_translation_m;
  std::optional<double> median_rotation_deg;
  // Over the frames that have them.
  std::optional<Percentiles> latency_ms;
  std::optional<Percentiles> cpu_ms;
  std::optional<Percentiles> decode_ms;
  // By stage, as the localizer states them.
  std::optional<Percentiles> sample_ms;
  std::optional<Percentiles> forest_ms;
  std::optional<Percentiles> pose_ms;
};

// Localizes every frame of `dataset`, in any order, on options.threads
// threads; result i belongs to frame i. The first frame that can be read is
// localized once more beforehand and this query not counted, so that caches
// and page tables are warm. A frame that fails is recorded and the rest goes
// on. CANCELLED if options.stop was requested.
absl::StatusOr<std::vector<FrameResult>> Evaluate(
    const localizer::Localizer& localizer, const dataset::Dataset& dataset,
    const EvaluationOptions& options, const base::Clock& clock);

EvaluationSummary Summarize(const std::vector<FrameResult>& results);

// Whether a frame was localized within both bounds.
bool IsWithin(const FrameResult& result, const PoseThreshold& threshold);

// Whether there is an error and it is within both bounds.
bool IsWithin(const std::optional<geometry::PoseError>& error,
              const PoseThreshold& threshold);

// The fraction of the scored frames that are within the threshold. nullopt: no
// frame is scored.
std::optional<double> CorrectShare(const std::vector<FrameResult>& results,
                                   const PoseThreshold& threshold);

// The p-th percentile, p in [0, 100], interpolated linearly between the two
// nearest ranks (NumPy's default). nullopt if `values` is empty.
std::optional<double> Percentile(std::vector<double> values, double p);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_EVALUATION_H_
