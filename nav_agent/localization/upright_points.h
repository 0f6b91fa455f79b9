// The points of a scan that are not on the ground.
#ifndef NAV_AGENT_LOCALIZATION_UPRIGHT_POINTS_H_
#define NAV_AGENT_LOCALIZATION_UPRIGHT_POINTS_H_

#include <cstddef>

#include "nav_agent/localization/scan_points.h"

namespace treeline::localization {

// Those higher than ground_m above the ground that the robot stands on, if they
// have heights: beams that end on the ground fit anywhere and nowhere.
inline ScanPoints UprightPoints(const ScanPoints& points, double ground_m) {
  if (!points.has_heights()) return points;
  ScanPoints upright;
  for (size_t i = 0; i < points.size(); ++i) {
    if (points.z_m[i] > ground_m) upright.Add(points, i);
  }
  return upright;
}

}  // namespace treeline::localization

#endif  // NAV_AGENT_LOCALIZATION_UPRIGHT_POINTS_H_
