// Results frame by frame for spreadsheets and scripts.
#ifndef EVALUATION_ACCURACY_EVALUATION_CSV_H_
#define EVALUATION_ACCURACY_EVALUATION_CSV_H_

#include <string>
#include <vector>

#include "evaluation/accuracy/evaluated_method.h"

namespace treeline::accuracy {

// A header, then a line a frame and method (RFC 4180, lines end with \n):
// lengths in metres, angles in degrees, times in milliseconds. What is
// undefined, or not finite, is empty. A method that failed has no lines; after
// the frames of one that did not follow those that were perturbed.
std::string EvaluationCsv(const std::vector<EvaluatedMethod>& methods);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_EVALUATION_CSV_H_
