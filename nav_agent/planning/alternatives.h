// Other ways round things than those that are known.
#ifndef NAV_AGENT_PLANNING_ALTERNATIVES_H_
#define NAV_AGENT_PLANNING_ALTERNATIVES_H_

#include <cstdint>
#include <vector>

#include "nav_agent/planning/routes.h"

namespace treeline::planning {

// Routes from one place to another, each on another side of something than all
// before it, the shortest first. Every region has a shortest route over it; of
// those regions that cannot be seen from a route that is known, the one with
// the shortest is next.
class Alternatives {
 public:
  // known_m: the length of a way that can be driven (m).
  Alternatives(const ConfigurationSpace& space, const Regions& regions,
               const Spot& start, const Spot& goal, double known_m);

  // Points from start to goal. The first call gives the shortest route; empty
  // where none is left that is shorter than kAlternativeCost times what is
  // known: the shortest ones may be too narrow.
  Polyline Next();

 private:
  struct Via {
    float cost_m = 0;
    uint32_t region = 0;
  };
  // Marks the route's regions, and what can be seen from them near by.
  void Cover(const Route& route);
  bool Sees(uint32_t from, uint32_t to) const;

  const ConfigurationSpace* space_;
  const Regions* regions_;
  Spot start_;
  Spot goal_;
  uint32_t start_region_;
  RouteField from_start_;
  RouteField to_goal_;
  // By cost.
  std::vector<Via> vias_;
  size_t next_ = 0;
  std::vector<bool> is_covered_;
};

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_ALTERNATIVES_H_
