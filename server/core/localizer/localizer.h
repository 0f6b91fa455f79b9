// Where is this camera? The interface every method stands behind.
#ifndef SERVER_CORE_LOCALIZER_LOCALIZER_H_
#define SERVER_CORE_LOCALIZER_LOCALIZER_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/camera/camera.h"
#include "common/geometry/pose_prior.h"
#include "common/geometry/rigid3.h"
#include "common/image/frame.h"
#include "server/core/forest/model_info.h"
#include "server/core/localizer/query_options.h"

namespace treeline::keyframes {
class KeyframeMap;
}  // namespace treeline::keyframes

namespace treeline::localizer {

// What a method does with a frame's depth. kWhereGiven: it answers with and
// without.
enum class DepthUse { kIgnored, kRequired, kWhereGiven };

enum class Outcome { kLocalized, kNotLocalized };

// Why a frame was not localized. Stable: they appear in the wire contract.
enum class NotLocalizedReason {
  kNone,               // it was localized
  kTooFewSamples,      // hardly a pixel had depth and lay inside the image
  kTooFewInliers,      // no pose explained enough of the predictions
  kPoorlyConstrained,  // the inliers leave the pose uncertain
  kLowConfidence,      // what else is known speaks against the pose
  kContradictsPrior,   // it is farther from the prior than that allows
  kContradictsDepth,   // the frame's depth is not what is seen from the pose
  // What is seen does not tell the focal length of a camera that is assumed.
  kUnknownCamera
};

// Milliseconds spent per stage, in order of the pipeline.
struct LocalizeTimings {
  double sample_ms = 0;  // choosing pixels, back-projecting
  double forest_ms = 0;  // descriptors and scene coordinates
  double pose_ms = 0;    // hypotheses to verification
  double total_ms = 0;
  // Parts of pose_ms.
  double features_ms = 0;  // finding features, matching them to keyframes
  double verify_ms = 0;    // alignment to keyframes, evidence, confidence
};

// Sets total_ms, and pose_ms to what the other stages leave of it.
void SetTotal(double total_ms, LocalizeTimings& timings);

void Add(const LocalizeTimings& more, LocalizeTimings& sums);

// One sample that supported or contradicted the answer: for pictures.
struct Correspondence {
  camera::Pixel color_pixel;
  geometry::Vec3 point_in_camera;
  geometry::Vec3 point_in_world;  // as the forest predicted it
  bool inlier = false;
};

struct PoseEstimate {
  Outcome outcome = Outcome::kNotLocalized;
  NotLocalizedReason reason = NotLocalizedReason::kTooFewSamples;
  // Meaningful when localized. The pose of the scene's pose sensor.
  geometry::Rigid3 world_from_camera;
  geometry::PoseCovariance covariance{};
  int inliers = 0;
  int samples = 0;
  // inliers / samples, in [0, 1].
  double inlier_ratio = 0;
  // Probability that the pose is right: that its error is below 5 cm and 5
  // degrees (outdoors: the model's own bounds, see ModelInfo). In [0, 1]; 0 if
  // there is no pose.
  double confidence = 0;
  // What it was computed from.
  forest::PoseEvidence evidence;
  LocalizeTimings timings;
  // The pose is of a camera whose focal length is so many times the stated one
  // (or the scene's), since that fits what was seen better; 1: the stated one
  // fits.
  double focal_scale = 1;
  // Where nobody stated a camera, or a guess whose lens does not fit, the one
  // that the pose is of.
  std::optional<camera::Camera> found_camera;
  // By how many standard deviations, as they state them, matched features speak
  // for another focal length than the stated one; 0: they do not tell.
  double focal_error_sigmas = 0;
  // Depth was taken so many times what the frame states, since that fits what
  // was seen better; 1: as stated.
  double depth_scale = 1;
  // Filled if the query asked for it.
  std::vector<Correspondence> correspondences;
};

// Whether `a` is the better answer: what is localized, and then what is more
// probable.
bool IsBetter(const PoseEstimate& a, const PoseEstimate& b);

struct LocalizeOptions {
  // The same seed, frame and model give the same pose, bit for bit, whatever
  // else the process does.
  uint64_t seed = 0;
  bool keep_correspondences = false;
  // Least confidence of what is localized, in [0, 1]; nullopt: the model's
  // threshold.
  std::optional<double> min_confidence = std::nullopt;
  // Where the pose is expected. Keyframes there are tried first, and a pose
  // that contradicts them is not localized.
  geometry::PosePriors priors = {};
  // Polled in sampling, backtracking and RANSAC: CANCELLED soon after.
  std::stop_token stop;
};

// A loaded scene's way of answering. Immutable; Localize may be called from
// many threads at once, and runs on the calling one alone.
class Localizer {
 public:
  virtual ~Localizer() = default;

  // "Not localized" is an OK result. Errors: INVALID_ARGUMENT for a frame that
  // this method cannot use (no depth where depth is needed, image and camera
  // of different sizes); CANCELLED.
  virtual absl::StatusOr<PoseEstimate> Localize(
      const image::Frame& frame, const LocalizeOptions& options) const = 0;

  virtual const forest::ModelInfo& info() const = 0;
  virtual DepthUse depth_use() const = 0;
  // Of the model; null, or empty: it has none. As long as this lives.
  virtual const keyframes::KeyframeMap* keyframes() const { return nullptr; }
};

// Maps, verifies and opens a model file. NOT_FOUND: no such file. DATA_LOSS:
// truncated, corrupt, or not a Treeline model. UNIMPLEMENTED: written by a
// newer version. Safe on hostile files.
absl::StatusOr<std::unique_ptr<Localizer>> OpenLocalizer(
    const std::string& model_path, const QueryOptions& options = {});

absl::string_view OutcomeName(Outcome outcome);
absl::string_view ReasonName(NotLocalizedReason reason);

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_LOCALIZER_H_
