// What the forests said before a pose was fitted.
#ifndef EVALUATION_REPORT_REPORT_SCENE_COORDINATES_H_
#define EVALUATION_REPORT_REPORT_SCENE_COORDINATES_H_

#include <string>
#include <vector>

#include "evaluation/accuracy/evaluated_method.h"

namespace treeline::report {

// Cumulative scene-coordinate errors of all methods (thesis Fig. 4.5), heat
// maps of some frames (Fig. 3.6) and split ratios by level (Fig. 4.9). Parts
// that nothing is known for are left out.
std::string SceneCoordinatesSection(
    const std::vector<accuracy::EvaluatedMethod>& methods);

}  // namespace treeline::report

#endif  // EVALUATION_REPORT_REPORT_SCENE_COORDINATES_H_
