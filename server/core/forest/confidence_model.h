// How sure an answer is: evidence in, probability out.
#ifndef SERVER_CORE_FOREST_CONFIDENCE_MODEL_H_
#define SERVER_CORE_FOREST_CONFIDENCE_MODEL_H_

#include <array>
#include <cstddef>

#include "absl/strings/string_view.h"

namespace treeline::forest {

// What speaks for a pose.
struct PoseEvidence {
  // Share of the samples whose scene coordinates agree, in [0, 1].
  double inlier_ratio = 0;
  // What the keyframes around say; all zero if there are none. See Alignment.
  double correlation = 0;  // in [0, 1]
  double agreement = 0;    // in [0, 1]
  int visible = 0;
  double overlap = 0;          // in [0, 1]
  int measured = 0;            // 0: without depth
  double depth_agreement = 0;  // in [0, 1]
  // The share of the picture that looks like something else, in [0, 1]; see
  // CellAgreement.
  double contradicted = 0;
  // How far alignment moved the pose (m).
  double moved_m = 0;
  // Features of the frame that support the pose, each like one of a keyframe or
  // of a structure from motion; 0: it comes from a forest of samples.
  int matches = 0;
  // The share of them that is like nothing elsewhere in the scene, in [0, 1].
  double distinct = 1;
  // Standard deviation of the position by the pose's covariance (m); 0: not
  // known.
  double sigma_m = 0;
};

// Whether the pose may be that of another place that looks alike: what supports
// it is found elsewhere, too, and nothing sets the place apart, or the picture
// shows something else than was learnt there.
bool MayBeElsewhere(const PoseEvidence& evidence);

// Logistic regression on features of the evidence. Fitted by the trainer on
// frames that the model had not seen; see training/confidence_fitter.h.
struct ConfidenceModel {
  static constexpr size_t kFeatures = 10;
  using Features = std::array<double, kFeatures>;

  // Of feature i; the first is the constant's.
  Features weights{};
  // Answers of at least this probability are given as localized.
  double threshold = 0.5;
  // The standard deviation of a focal length, as matched features state it, has
  // to be taken so many times, at least 1: what a map has wrong, its points
  // have in common.
  double focal_sigma_scale = 1;

  // "constant", "inlier_ratio" and so on, as the model file names them.
  static const std::array<absl::string_view, kFeatures>& FeatureNames();
  static Features FeaturesOf(const PoseEvidence& evidence);

  // In [0, 1]. Below a half if MayBeElsewhere, whatever else speaks for the
  // pose: the weights are those of places that are not alike.
  double Probability(const PoseEvidence& evidence) const;

  // Learnt over scenes of many kinds, see docs/research/confidence.md: what a
  // scene's own begins with, and what serves models that have none.
  static ConfidenceModel Typical();
  static ConfidenceModel WithoutKeyframes();
  // For poses by SIFT features that a forest knows: by how many agree.
  static ConfidenceModel OfSiftMatches();

  bool operator==(const ConfidenceModel&) const = default;
};

}  // namespace treeline::forest

#endif  // SERVER_CORE_FOREST_CONFIDENCE_MODEL_H_
