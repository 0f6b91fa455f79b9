// From a guide, a disc's way, to one that the footprint can drive.
#ifndef NAV_AGENT_PLANNING_GUIDE_H_
#define NAV_AGENT_PLANNING_GUIDE_H_

#include <functional>

#include "nav_agent/planning/configuration_space.h"
#include "nav_agent/planning/variable_rrt.h"

namespace treeline::planning {

struct PulledWay {
  // From the first of the points to the last; if it is not whole, as far as
  // came of it.
  Polyline way;
  bool is_whole = false;
  // The last point that was come to.
  Spot reached;
};

// A way over some of `points`, in their order: lines as long as there is room,
// that end where the robot can turn right round; short ones over points where
// it cannot, only where there is no other. Far from the cheapest, but soon
// found. Where lines over the points do not lead on, `bridge` may find other
// ways to a point further on; it gives an empty one if it does not.
using GuideBridge = std::function<Polyline(const Stand& from, const Stand& to)>;
PulledWay FollowGuide(const ConfigurationSpace& space, double start_yaw_rad,
                      double goal_yaw_rad, const Polyline& points,
                      double spacing_m, const GuideBridge& bridge);

// The cheapest way over some of `points`, in their order, from the first to the
// last, whose lines and turns can be driven: by dynamic programming over points
// spacing_m apart (m), each with the heading of the best way to it.
PulledWay PullTight(const ConfigurationSpace& space, double start_yaw_rad,
                    double goal_yaw_rad, const Polyline& points,
                    double spacing_m);
// The same; empty if there is none.
Polyline ShortcutPolyline(const ConfigurationSpace& space, double start_yaw_rad,
                          double goal_yaw_rad, const Polyline& points,
                          double spacing_m);

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_GUIDE_H_
