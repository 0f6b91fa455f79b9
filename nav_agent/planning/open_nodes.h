// What a best-first search over numbered nodes has yet to look at.
#ifndef NAV_AGENT_PLANNING_OPEN_NODES_H_
#define NAV_AGENT_PLANNING_OPEN_NODES_H_

#include <cstdint>
#include <queue>
#include <vector>

namespace treeline::planning {

struct OpenNode {
  float estimate_m = 0;
  uint32_t number = 0;
};

// Of equal estimates the lower number comes first: ways do not depend on the
// order in which nodes were found.
struct IsWorseNode {
  bool operator()(const OpenNode& a, const OpenNode& b) const {
    return a.estimate_m != b.estimate_m ? a.estimate_m > b.estimate_m
                                        : a.number > b.number;
  }
};

// The least estimate is on top.
using OpenNodes =
    std::priority_queue<OpenNode, std::vector<OpenNode>, IsWorseNode>;

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_OPEN_NODES_H_
