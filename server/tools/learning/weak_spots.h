// Where more should be recorded, found on the plan of a scene's coverage.
#ifndef SERVER_TOOLS_LEARNING_WEAK_SPOTS_H_
#define SERVER_TOOLS_LEARNING_WEAK_SPOTS_H_

#include <optional>
#include <string>
#include <vector>

#include "server/core/keyframes/coverage.h"

namespace treeline::learning {

// A place from which much is missing. Coordinates are the plan's (m).
struct WeakSpot {
  double x_m = 0;
  double y_m = 0;
  // Of the disc that it stands for.
  double radius_m = 0;
  // Of the views from the open places in it, those that will not be answered.
  double missing_share = 0;
  // The middle of the headings that are missing, anticlockwise from the plan's
  // x axis (rad); nullopt: nearly all are.
  std::optional<double> towards_rad{};
};

// At most `count`, those with the most missing views first, well apart from
// each other. Places of which less than 40 % of the views are missing are none.
std::vector<WeakSpot> FindWeakSpots(const keyframes::CoverageMap& coverage,
                                    int count);

// "the top right of the plan", where x points right and y to the top.
std::string DirectionOnPlan(double heading_rad);

}  // namespace treeline::learning

#endif  // SERVER_TOOLS_LEARNING_WEAK_SPOTS_H_
