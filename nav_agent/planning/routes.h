// Ways over regions: from where to where, roughly.
#ifndef NAV_AGENT_PLANNING_ROUTES_H_
#define NAV_AGENT_PLANNING_ROUTES_H_

#include <cstdint>
#include <limits>
#include <vector>

#include "nav_agent/planning/regions.h"
#include "nav_agent/planning/variable_rrt.h"

namespace treeline::planning {

// The edges from the start's region to the goal's; none if they are one.
struct Route {
  bool is_found = false;
  float cost_m = 0;
  std::vector<Regions::Edge> edges;
};

// The cheapest route (A*), with one-way zones where there is such a route.
// `weights` has one number, at least 1, for each region that its edges' costs
// are multiplied by; empty: 1.
Route FindRoute(const Regions& regions, uint32_t start, uint32_t goal,
                const std::vector<float>& weights);

// The cheapest routes from everywhere to one region (Dijkstra).
class RouteField {
 public:
  // Those that cost more than reach_m are not looked for. `price`: what an
  // edge costs (m).
  RouteField(const Regions& regions, uint32_t root,
             float reach_m = std::numeric_limits<float>::infinity(),
             float Regions::Edge::*price = &Regions::Edge::cost_m);

  // Between the centres (m); infinite where there is none.
  float cost_m(uint32_t region) const { return cost_m_[region]; }
  float length_m(uint32_t region) const { return length_m_[region]; }
  // From a region to the root.
  Route RouteFrom(uint32_t region) const;

 private:
  const Regions* regions_;
  std::vector<float> cost_m_;
  std::vector<float> length_m_;
  // The edge towards the root, as an index of EdgesOf; -1 at the root.
  std::vector<int32_t> next_;
};

// The same route, the other way.
Route Reversed(const Regions& regions, const Route& route, uint32_t from);

// The cells' centres that a route leads over, from `start` to `goal`, which are
// its first and last points; within each region the cheapest way.
Polyline CellsAlong(const ConfigurationSpace& space, const Regions& regions,
                    const Spot& start, const Spot& goal, const Route& route);

// How far it is for the inscribed disc from anywhere to a goal (m).
class DistanceToGoal {
 public:
  DistanceToGoal(const GroundIndex& ground, const Regions& regions,
                 const Spot& goal, float reach_m);
  // Infinite where no way leads to the goal, and where it costs more than
  // reach_m.
  float Of_m(const Spot& spot) const;

 private:
  const GroundIndex* ground_;
  const Regions* regions_;
  Spot goal_;
  uint32_t goal_region_;
  RouteField field_;
};

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_ROUTES_H_
