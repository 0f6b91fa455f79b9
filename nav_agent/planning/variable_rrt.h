// Two trees that grow towards one another in steps as long as there is room.
#ifndef NAV_AGENT_PLANNING_VARIABLE_RRT_H_
#define NAV_AGENT_PLANNING_VARIABLE_RRT_H_

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "nav_agent/planning/drive_space.h"

namespace treeline {

// A place with a heading, in the frame of the grids.
struct Stand {
  Spot spot;
  double yaw_rad = 0;
};

// A way: the robot turns at each point to look at the next one, and drives
// there; at the last it turns to the goal's heading.
using Polyline = std::vector<Spot>;

struct RrtRequest {
  Stand start;
  Stand goal;
  uint64_t seed = 0;
  int max_iterations = 20000;
  // Asked now and then; growing ends when it says so.
  std::function<bool()> is_over;
  // Gives a place to grow to; called once an iteration.
  std::function<Spot(uint64_t iteration)> sample;
};

struct RrtResult {
  // Empty: none was found.
  Polyline way;
  int iterations = 0;
  // Pairs of points.
  std::vector<Vec2> edges;
};

// Grows a tree from the start and one from the goal in turns. Each step goes
// from the nearest node towards the sample, at most as far as the nearest
// obstacle is from that node, whatever its direction: wide steps in open space
// and short ones in narrow places, without a step size to be tuned. The other
// tree then grows towards the new node until it reaches it or something is in
// its way (after Kuffner and LaValle, "RRT-Connect", ICRA 2000). All edges, and
// the turns between them, are checked with the footprint. Deterministic in
// iterations.
RrtResult GrowVariableRrt(const DriveSpace& space, const RrtRequest& request);

}  // namespace treeline

#endif  // NAV_AGENT_PLANNING_VARIABLE_RRT_H_
