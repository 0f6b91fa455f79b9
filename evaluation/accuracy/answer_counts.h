// What a group of frames shows: how many were answered, how many of the answers
// are right, and how many right poses were found and refused.
#ifndef EVALUATION_ACCURACY_ANSWER_COUNTS_H_
#define EVALUATION_ACCURACY_ANSWER_COUNTS_H_

#include <optional>
#include <vector>

#include "evaluation/accuracy/evaluation.h"

namespace treeline::accuracy {

// When a pose is right: within 5 cm and 5 degrees or, where the unit of length
// is arbitrary, within 1 % of the scene's size (SceneSize_m) and 5 degrees.
PoseThreshold RightWithin(const std::vector<FrameResult>& results,
                          bool units_are_metres);

// Shares are in [0, 1]; nullopt: of nothing.
struct AnswerCounts {
  int frames = 0;    // with ground truth
  int answered = 0;  // of them, localized
  int right = 0;     // of these, within the threshold
  int found = 0;     // right poses, whether answered or refused
  // Answers at or above the confidence threshold; all where a method states no
  // confidence. Those of them that are not right, and that are beyond twice the
  // threshold.
  int relied_on = 0;
  int wrong = 0;
  int gross = 0;
  // See ConfidenceReport.
  std::optional<double> calibration_error;
  std::optional<Percentiles> latency_ms;
  std::optional<Percentiles> cpu_ms;

  std::optional<double> ShareRight() const;
  std::optional<double> ShareAnswered() const;
  std::optional<double> ShareFound() const;
  // right / found: the share of the right poses that was answered.
  std::optional<double> Coverage() const;
  // Of what was relied on.
  std::optional<double> Precision() const;
};

AnswerCounts CountAnswers(const std::vector<FrameResult>& results,
                          const PoseThreshold& right_within,
                          double confidence_threshold);

// Of pictures that show no place of the scene: frames are all that could be
// asked about, and every answer that would be relied on is wrong and gross.
AnswerCounts CountForeignAnswers(const std::vector<FrameResult>& results,
                                 double confidence_threshold);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_ANSWER_COUNTS_H_
