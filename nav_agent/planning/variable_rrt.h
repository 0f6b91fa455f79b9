// Two trees that grow towards one another in steps as long as there is room.
#ifndef NAV_AGENT_PLANNING_VARIABLE_RRT_H_
#define NAV_AGENT_PLANNING_VARIABLE_RRT_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "nav_agent/planning/configuration_space.h"

namespace treeline::planning {

// A place with a heading, in the frame of the grids.
struct Stand {
  Spot spot;
  double yaw_rad = 0;
};

// A way: the robot turns at each point to look at the next one, and drives
// there; at the last it turns to the goal's heading.
using Polyline = std::vector<Spot>;

// Grows a tree from the start and one from the goal in turns. Each step goes
// from the nearest node towards the sample, at most as far as the nearest
// obstacle is from that node, whatever its direction: wide steps in open space
// and short ones in narrow places, without a step size to be tuned. The other
// tree then grows towards the new node until it reaches it or something is in
// its way (after Kuffner and LaValle, "RRT-Connect", ICRA 2000). All edges, and
// the turns between them, are checked with the footprint.
class VariableRrt {
 public:
  VariableRrt(const ConfigurationSpace& space, const Stand& start,
              const Stand& goal);
  ~VariableRrt();
  VariableRrt(const VariableRrt&) = delete;
  VariableRrt& operator=(const VariableRrt&) = delete;

  // Goes on for as many iterations at most, each with one `sample` of the
  // iteration's number, until the trees meet or `is_over`, asked now and then,
  // says so. Whether they have met.
  bool Grow(int iterations, const std::function<Spot(uint64_t)>& sample,
            const std::function<bool()>& is_over);

  // The first node of the start's tree, or the goal's, where the robot can turn
  // right round: from there any way may go on. The root if there is none yet.
  Stand Hub(bool is_of_goal) const;
  // Grows the start's tree from its hub along a way that begins there, as far
  // as it can be driven. Whether the trees have met: a way that ends at the
  // goal's hub joins them.
  bool Plant(const Polyline& way);

  int iterations() const { return iterations_; }
  // From the start to the goal; empty until the trees meet.
  Polyline Way() const;
  // Pairs of points: the start's tree.
  std::vector<geometry::Vec2> Edges() const;
  // And the goal's.
  std::vector<geometry::Vec2> GoalEdges() const;

 private:
  class Tree;
  void Connect(size_t own, int node);
  // Whether nodes of the start's and the goal's tree are one; they meet there.
  bool Meet(int of_start, int of_goal);

  const ConfigurationSpace* space_;
  // The start's and the goal's.
  std::array<std::unique_ptr<Tree>, 2> trees_;
  // Their nodes that met; -1 until then.
  std::array<int, 2> met_ = {-1, -1};
  int iterations_ = 0;
};

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_VARIABLE_RRT_H_
