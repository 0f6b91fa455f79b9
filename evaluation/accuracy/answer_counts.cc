#include "evaluation/accuracy/answer_counts.h"

#include <algorithm>

#include "evaluation/accuracy/confidence_report.h"
#include "evaluation/accuracy/thresholds.h"

namespace treeline::accuracy {
namespace {

// Beyond so many times the threshold a pose is grossly wrong: 10 cm where 5 cm
// is right.
constexpr double kGross = 2;

std::optional<double> Share(int part, int whole) {
  if (whole == 0) return std::nullopt;
  return static_cast<double>(part) / whole;
}

// Whether answers are to be told apart by their confidence.
bool StatesConfidence(const std::vector<FrameResult>& results) {
  return std::ranges::any_of(results, [](const FrameResult& result) {
    return result.localized() && result.estimate.confidence > 0;
  });
}

void AddTimes(const std::vector<FrameResult>& results, AnswerCounts& counts) {
  const EvaluationSummary summary = Summarize(results);
  counts.latency_ms = summary.latency_ms;
  counts.cpu_ms = summary.cpu_ms;
}

}  // namespace

PoseThreshold RightWithin(const std::vector<FrameResult>& results,
                          bool units_are_metres) {
  if (units_are_metres) return {};
  const ThresholdRequest one_percent{
      .translation = 1, .relative = true, .rotation_deg = 5};
  return Resolve(one_percent, SceneSize_m(results)).value_or(PoseThreshold{});
}

std::optional<double> AnswerCounts::ShareRight() const {
  return Share(right, frames);
}
std::optional<double> AnswerCounts::ShareAnswered() const {
  return Share(answered, frames);
}
std::optional<double> AnswerCounts::ShareFound() const {
  return Share(found, frames);
}
std::optional<double> AnswerCounts::Coverage() const {
  return Share(right, found);
}
std::optional<double> AnswerCounts::Precision() const {
  return Share(relied_on - wrong, relied_on);
}

AnswerCounts CountAnswers(const std::vector<FrameResult>& results,
                          const PoseThreshold& right_within,
                          double confidence_threshold) {
  const double least = StatesConfidence(results) ? confidence_threshold : 0;
  const PoseThreshold gross_beyond{kGross * right_within.translation_m,
                                   kGross * right_within.rotation_deg};
  AnswerCounts counts;
  for (const FrameResult& result : results) {
    if (!result.true_world_from_camera) continue;
    ++counts.frames;
    counts.answered += result.localized();
    const bool right = IsWithin(result, right_within);
    counts.right += right;
    counts.found += right || IsWithin(result.refused_error, right_within);
    if (!result.localized() || result.estimate.confidence < least) continue;
    ++counts.relied_on;
    counts.wrong += !right;
    counts.gross += !IsWithin(result, gross_beyond);
  }
  counts.calibration_error =
      AssessConfidence(results, right_within, confidence_threshold)
          .expected_calibration_error;
  AddTimes(results, counts);
  return counts;
}

AnswerCounts CountForeignAnswers(const std::vector<FrameResult>& results,
                                 double confidence_threshold) {
  const double least = StatesConfidence(results) ? confidence_threshold : 0;
  AnswerCounts counts;
  for (const FrameResult& result : results) {
    counts.frames += result.status.ok();
    if (!result.localized()) continue;
    ++counts.answered;
    counts.relied_on += result.estimate.confidence >= least;
  }
  counts.wrong = counts.gross = counts.relied_on;
  AddTimes(results, counts);
  return counts;
}

}  // namespace treeline::accuracy
