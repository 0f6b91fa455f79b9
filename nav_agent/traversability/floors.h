// Which ground is part of a floor, and which is stairs, furniture or an edge.
#ifndef NAV_AGENT_TRAVERSABILITY_FLOORS_H_
#define NAV_AGENT_TRAVERSABILITY_FLOORS_H_

#include <cstdint>
#include <vector>

#include "nav_agent/traversability/ground.h"
#include "nav_agent/traversability/traversability_options.h"

namespace treeline::traversability {

inline constexpr uint32_t kNoNode = 0xffffffff;
inline constexpr uint8_t kSmallFloor = 1;
inline constexpr uint8_t kLargeFloor = 2;

// What is said of each node besides what GroundNode says.
struct NodeFacts {
  std::vector<float> slope_rad;
  std::vector<uint8_t> good;  // not steep, narrow or an edge
  // 0, or good and in a patch that is no furniture: kSmallFloor or kLargeFloor.
  std::vector<uint8_t> floor;
  // The edge of a drop that a floor ends in.
  std::vector<uint8_t> rim;
};

NodeFacts FindFacts(const GroundColumns& ground,
                    const TraversabilityOptions& options, double resolution_m);

}  // namespace treeline::traversability

#endif  // NAV_AGENT_TRAVERSABILITY_FLOORS_H_
