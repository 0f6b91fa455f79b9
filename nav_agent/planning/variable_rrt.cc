#include "nav_agent/planning/variable_rrt.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace treeline {
namespace {

// Steps are no shorter than this, to get away from walls that are touched, and
// no longer, to leave nodes for others to begin at.
constexpr double kLeastStep_m = 0.1;
constexpr double kMostStep_m = 2.0;
// What another level is further away.
constexpr double kLevelDistance_m = 2.0;
// A root whose robot cannot turn leaves it along its heading: in this many
// steps of this.
constexpr int kLeavingSteps = 6;
constexpr double kLeavingStep_m = 0.2;
constexpr int kStopEvery = 32;

double YawOf(Vec2 way) { return std::atan2(way.y, way.x); }

struct Node {
  Spot spot;
  // Of the robot when it is driven to from the parent, or (in the goal's
  // tree) from here to the parent; the root's own.
  double yaw_rad = 0;
  int parent = -1;
};

class Tree {
 public:
  Tree(const DriveSpace& space, const Stand& root, bool is_of_goal)
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
      const Vec2 way = node(i).spot.at - to.at;
      double squared = Dot(way, way);
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
  int Step(int from, Vec2 towards) {
    const Spot& spot = node(from).spot;
    const Vec2 way = towards - spot.at;
    const double length_m = Norm(way);
    if (!(length_m > 1e-6)) return -1;
    const double step_m =
        std::clamp(space_->RoomAtLeast_m(spot), kLeastStep_m, kMostStep_m);
    return step_m >= length_m ? Add(from, towards)
                              : Add(from, spot.at + (step_m / length_m) * way);
  }

  // The new node at `to`, or -1 if it cannot be driven to.
  int Add(int from, Vec2 to) {
    const Node& parent = node(from);
    const Vec2 way = to - parent.spot.at;
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

  void AppendEdges(std::vector<Vec2>& edges) const {
    for (const Node& child : nodes_) {
      if (child.parent < 0) continue;
      edges.push_back(node(child.parent).spot.at);
      edges.push_back(child.spot.at);
    }
  }

 private:
  // Straight ahead from the start, straight back from the goal.
  void Leave() {
    const Vec2 ahead = {std::cos(nodes_[0].yaw_rad),
                        std::sin(nodes_[0].yaw_rad)};
    int from = 0;
    for (int i = 0; i < kLeavingSteps && from >= 0; ++i) {
      from = Add(from,
                 node(from).spot.at +
                     (is_of_goal_ ? -kLeavingStep_m : kLeavingStep_m) * ahead);
    }
  }

  const DriveSpace* space_;
  bool is_of_goal_;
  std::vector<Node> nodes_;
};

// Whether a node of the start's tree and one of the goal's at the same place
// can be one: the robot turns there.
bool AreOne(const DriveSpace& space, const Node& from, const Node& to) {
  return from.spot.level == to.spot.level &&
         Norm(from.spot.at - to.spot.at) < 1e-6 &&
         space.CanTurn(from.spot, from.yaw_rad, to.yaw_rad);
}

}  // namespace

RrtResult GrowVariableRrt(const DriveSpace& space, const RrtRequest& request) {
  std::array<Tree, 2> trees = {Tree(space, request.start, false),
                               Tree(space, request.goal, true)};
  RrtResult result;
  // Of the start's and of the goal's tree, once they meet.
  std::array<int, 2> met = {-1, -1};
  // A node of one tree, and the other one grows towards it.
  const auto connect = [&space, &trees, &met](size_t own, int node) {
    const size_t other = 1 - own;
    const Spot target = trees[own].node(node).spot;
    int from = trees[other].Nearest(target);
    while (from >= 0 && met[0] < 0) {
      std::array<int, 2> ends{};
      ends[own] = node;
      ends[other] = from;
      if (AreOne(space, trees[0].node(ends[0]), trees[1].node(ends[1]))) {
        met = ends;
        return;
      }
      from = trees[other].Step(from, target.at);
    }
  };
  connect(0, 0);
  for (; met[0] < 0 && result.iterations < request.max_iterations;
       ++result.iterations) {
    if (result.iterations % kStopEvery == 0 && request.is_over()) break;
    const size_t own = static_cast<size_t>(result.iterations) % 2;
    const Spot sample =
        request.sample(static_cast<uint64_t>(result.iterations));
    const int node = trees[own].Step(trees[own].Nearest(sample), sample.at);
    if (node >= 0) connect(own, node);
  }
  trees[0].AppendEdges(result.edges);
  trees[1].AppendEdges(result.edges);
  if (met[0] < 0) return result;
  result.way = trees[0].ToRoot(met[0]);
  std::ranges::reverse(result.way);
  const Polyline rest = trees[1].ToRoot(met[1]);
  result.way.insert(result.way.end(), rest.begin() + 1, rest.end());
  return result;
}

}  // namespace treeline
