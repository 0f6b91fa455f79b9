// Methods side by side on frames that were changed.
#ifndef EVALUATION_ACCURACY_PERTURBATION_TABLE_H_
#define EVALUATION_ACCURACY_PERTURBATION_TABLE_H_

#include <string>
#include <vector>

#include "evaluation/accuracy/answer_counts.h"
#include "evaluation/accuracy/evaluated_method.h"
#include "evaluation/accuracy/evaluation_run.h"

namespace treeline::accuracy {

// One method under one perturbation.
struct PerturbationRow {
  std::string name;  // Perturbation::Name()
  bool is_foreign = false;
  AnswerCounts counts;
};

// In the order of method.perturbed.
std::vector<PerturbationRow> PerturbationRows(const EvaluatedMethod& method,
                                              double confidence_threshold);

// The shares of right answers over the rows that can have some, but for the
// first, the frames as they are. nullopt: there is no such row.
struct RightOverall {
  double mean = 0;
  double worst = 0;
};
std::optional<RightOverall> RightOverRows(
    const std::vector<PerturbationRow>& rows);

// A line a perturbation and four columns a method: the share of frames with a
// right answer, and with a right pose found, answered or refused (per cent);
// answers above the confidence threshold that are wrong, and grossly wrong in
// brackets; median latency (ms). Below, the mean and the worst share. Empty
// if nothing was perturbed.
std::string PerturbationTable(const std::vector<EvaluatedMethod>& methods,
                              const EvaluationRun& run);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_PERTURBATION_TABLE_H_
