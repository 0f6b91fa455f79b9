// How accuracy falls with the distance from the training cameras.
#ifndef EVALUATION_REPORT_REPORT_DISTANCE_H_
#define EVALUATION_REPORT_REPORT_DISTANCE_H_

#include <string>
#include <vector>

#include "evaluation/accuracy/evaluated_method.h"

namespace treeline::report {

// For each method the share of frames within 5 cm and 5 degrees, and the median
// position error, over five groups of as many frames, from those nearest to a
// training camera to those furthest away; see TrainingDistance. Empty if no
// method's training cameras are known.
std::string DistanceSection(
    const std::vector<accuracy::EvaluatedMethod>& methods);

}  // namespace treeline::report

#endif  // EVALUATION_REPORT_REPORT_DISTANCE_H_
