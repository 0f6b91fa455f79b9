// What the forests said before a pose was fitted.
#ifndef SERVER_TOOLS_REPORT_SCENE_COORDINATES_H_
#define SERVER_TOOLS_REPORT_SCENE_COORDINATES_H_

#include <string>
#include <vector>

#include "server/tools/evaluated_method.h"

namespace treeline {

// Cumulative scene-coordinate errors of all methods (thesis Fig. 4.5), heat
// maps of some frames (Fig. 3.6) and split ratios by level (Fig. 4.9). Parts
// that nothing is known for are left out.
std::string SceneCoordinatesSection(
    const std::vector<EvaluatedMethod>& methods);

}  // namespace treeline

#endif  // SERVER_TOOLS_REPORT_SCENE_COORDINATES_H_
