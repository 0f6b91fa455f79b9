#include "nav_agent/planning/variable_rrt.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "nav_agent/planning/planner_parameters.h"

namespace treeline::planning {
namespace {

double YawOf(geometry::Vec2 way) { return std::atan2(way.y, way.x); }

struct Node {
  Spot spot;
  // Of the robot when it is driven to from the parent, or (in the goal's
  // tree) from here to the parent; the root's own.
  double yaw_rad = 0;
  int parent = -1;
};

// Whether a node of the start's tree and one of the goal's at the same place
// can be one: the robot turns there.
bool AreOne(const ConfigurationSpace& space, const Node& from, const Node& to) {
  return from.spot.level == to.spot.level &&
         geometry::Norm(from.spot.at - to.spot.at) < 1e-6 &&
         space.CanTurn(from.spot, from.yaw_rad, to.yaw_rad);
}

}  // namespace

class VariableRrt::Tree {
 public:
  Tree(const ConfigurationSpace& space, const Stand& root, bool is_of_goal)
      : space_(&space), is_of_goal_(is_of_goal) {
    nodes_.push_back({.spot = root.spot, .yaw_rad = root.yaw_rad});
    if (!space.FitsTurning(root.spot)) Leave();
  }

  const Node& node(int index) const {
    return nodes_[static_cast<size_t>(index)];
  }
  int size() const { return static_cast<int>(nodes_.size()); }

  int Nearest(const Spot& to) const {
    int nearest = 0;
    double nearest_squared = std::numeric_limits<double>::infinity();
    for (int i = 0; i < size(); ++i) {
      const geometry::Vec2 way = node(i).spot.at - to.at;
      double squared = geometry::Dot(way, way);
      if (node(i).spot.level != to.level) {
        squared += kLevelDistance_m * kLevelDistance_m;
      }
      if (squared < nearest_squared) {
        nearest_squared = squared;
        nearest = i;
      }
    }
    return nearest;
  }

  // A step from a node; the new one, or -1.
  int Step(int from, geometry::Vec2 towards) {
    const Spot& spot = node(from).spot;
    const geometry::Vec2 way = towards - spot.at;
    const double length_m = geometry::Norm(way);
    if (!(length_m > 1e-6)) return -1;
    const double step_m =
        std::clamp(space_->RoomAtLeast_m(spot), kMinStep_m, kMaxStep_m.value);
    return step_m >= length_m ? Add(from, towards)
                              : Add(from, spot.at + (step_m / length_m) * way);
  }

  // The new node at `to`, or -1 if it cannot be driven to.
  int Add(int from, geometry::Vec2 to) {
    const Node& parent = node(from);
    const geometry::Vec2 way = to - parent.spot.at;
    const double yaw_rad = YawOf(is_of_goal_ ? -1 * way : way);
    if (!space_->CanTurn(parent.spot, parent.yaw_rad, yaw_rad)) return -1;
    const std::optional<Spot> end = space_->Drive(parent.spot, to, is_of_goal_);
    if (!end.has_value()) return -1;
    nodes_.push_back({.spot = *end, .yaw_rad = yaw_rad, .parent = from});
    return size() - 1;
  }

  // From a node to the root.
  Polyline ToRoot(int from) const {
    Polyline way;
    for (int i = from; i >= 0; i = node(i).parent) way.push_back(node(i).spot);
    return way;
  }

  // Searched on from where it was last looked for.
  int Hub() const {
    for (; hub_ < size(); ++hub_) {
      if (space_->FitsTurning(node(hub_).spot)) return hub_;
    }
    return 0;
  }

  std::vector<geometry::Vec2> Edges() const {
    std::vector<geometry::Vec2> edges;
    for (const Node& child : nodes_) {
      if (child.parent < 0) continue;
      edges.push_back(node(child.parent).spot.at);
      edges.push_back(child.spot.at);
    }
    return edges;
  }

 private:
  // Straight ahead from the start, straight back from the goal.
  void Leave() {
    const geometry::Vec2 ahead = {std::cos(nodes_[0].yaw_rad),
                                  std::sin(nodes_[0].yaw_rad)};
    int from = 0;
    for (int i = 0; i < kRootSteps && from >= 0; ++i) {
      from = Add(from, node(from).spot.at +
                           (is_of_goal_ ? -kRootStep_m : +kRootStep_m) * ahead);
    }
  }

  const ConfigurationSpace* space_;
  bool is_of_goal_;
  std::vector<Node> nodes_;
  mutable int hub_ = 0;
};

VariableRrt::VariableRrt(const ConfigurationSpace& space, const Stand& start,
                         const Stand& goal)
    : space_(&space),
      trees_{std::make_unique<Tree>(space, start, false),
             std::make_unique<Tree>(space, goal, true)} {
  Connect(0, 0);
}

VariableRrt::~VariableRrt() = default;

// The other tree grows towards a node of this one.
void VariableRrt::Connect(size_t own, int node) {
  const size_t other = 1 - own;
  const Spot target = trees_[own]->node(node).spot;
  int from = trees_[other]->Nearest(target);
  while (from >= 0) {
    if (own == 0 ? Meet(node, from) : Meet(from, node)) return;
    from = trees_[other]->Step(from, target.at);
  }
}

bool VariableRrt::Grow(int iterations,
                       const std::function<Spot(uint64_t)>& sample,
                       const std::function<bool()>& is_over) {
  for (int i = 0; i < iterations && met_[0] < 0; ++i, ++iterations_) {
    if (i % kStopEvery == 0 && is_over()) break;
    const size_t own = static_cast<size_t>(iterations_) % 2;
    const Spot to = sample(static_cast<uint64_t>(iterations_));
    const int node = trees_[own]->Step(trees_[own]->Nearest(to), to.at);
    if (node >= 0) Connect(own, node);
  }
  return met_[0] >= 0;
}

bool VariableRrt::Meet(int of_start, int of_goal) {
  if (!AreOne(*space_, trees_[0]->node(of_start), trees_[1]->node(of_goal))) {
    return false;
  }
  met_ = {of_start, of_goal};
  return true;
}

Stand VariableRrt::Hub(bool is_of_goal) const {
  const Tree& tree = *trees_[is_of_goal ? 1 : 0];
  const Node& hub = tree.node(tree.Hub());
  return {.spot = hub.spot, .yaw_rad = hub.yaw_rad};
}

bool VariableRrt::Plant(const Polyline& way) {
  int from = trees_[0]->Hub();
  for (size_t i = 1; i < way.size() && from >= 0; ++i) {
    from = trees_[0]->Add(from, way[i].at);
  }
  return from >= 0 && Meet(from, trees_[1]->Hub());
}

std::vector<geometry::Vec2> VariableRrt::Edges() const {
  return trees_[0]->Edges();
}

std::vector<geometry::Vec2> VariableRrt::GoalEdges() const {
  return trees_[1]->Edges();
}

Polyline VariableRrt::Way() const {
  if (met_[0] < 0) return {};
  Polyline way = trees_[0]->ToRoot(met_[0]);
  std::ranges::reverse(way);
  const Polyline rest = trees_[1]->ToRoot(met_[1]);
  way.insert(way.end(), rest.begin() + 1, rest.end());
  return way;
}

}  // namespace treeline::planning
