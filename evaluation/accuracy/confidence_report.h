// Whether stated confidences are true probabilities.
#ifndef EVALUATION_ACCURACY_CONFIDENCE_REPORT_H_
#define EVALUATION_ACCURACY_CONFIDENCE_REPORT_H_

#include <optional>
#include <vector>

#include "evaluation/accuracy/evaluation.h"

namespace treeline::accuracy {

// At or above it an answer may be relied on: below it, models do not give one
// as localized unless they were fitted otherwise. See ConfidenceModel.
inline constexpr double kPublishedConfidence = 0.5;

// Answers whose confidence lies in [low, high); the last bin has its end too.
struct ReliabilityBin {
  double low = 0;
  double high = 0;
  int frames = 0;
  // Means over the bin, in [0, 1]; 0 in an empty one.
  double confidence = 0;
  double correct = 0;
};

struct ConfidenceReport {
  // Localized frames with ground truth: those that something is said about.
  int frames = 0;
  // Whether any of them states a confidence above 0.
  bool stated = false;
  double threshold = 0;
  // Frames at or above the threshold, those of them that are correct, and all
  // correct ones.
  int confident = 0;
  int confident_correct = 0;
  int correct = 0;
  // Sum over bins of the share of frames in it times |mean confidence - share
  // that is correct| (Naeini et al. 2015), in [0, 1]. nullopt: nothing stated.
  std::optional<double> expected_calibration_error;
  std::vector<ReliabilityBin> bins;

  // confident_correct / confident; nullopt: there is none, or none is stated.
  std::optional<double> Precision() const;
  // confident_correct / correct.
  std::optional<double> Recall() const;
};

// correct_within: what PoseEstimate::confidence is the probability of. Ten bins
// of equal width. threshold in [0, 1].
ConfidenceReport AssessConfidence(const std::vector<FrameResult>& results,
                                  const PoseThreshold& correct_within,
                                  double threshold);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_CONFIDENCE_REPORT_H_
