#include "nav_agent/planning/ompl_variable_rrt.h"

#include <algorithm>

#include "nav_agent/planning/planner_parameters.h"
#include "ompl/base/goals/GoalSampleableRegion.h"
#include "ompl/geometric/PathGeometric.h"

namespace treeline::planning {
namespace {

namespace ob = ompl::base;

// As in variable_rrt.cc.
constexpr double kReached_m = 1e-9;

}  // namespace

OmplVariableRrt::OmplVariableRrt(const ob::SpaceInformationPtr& space)
    : Planner(space, "VariableRRT") {
  specs_.recognizedGoal = ob::GOAL_SAMPLEABLE_REGION;
}

OmplVariableRrt::~OmplVariableRrt() { Free(); }

void OmplVariableRrt::setup() {
  Planner::setup();
  for (std::unique_ptr<Tree>& tree : trees_) {
    if (tree != nullptr) continue;
    tree = std::make_unique<Tree>();
    tree->setDistanceFunction([this](const Node* a, const Node* b) {
      return si_->distance(a->state, b->state);
    });
  }
}

void OmplVariableRrt::clear() {
  Planner::clear();
  sampler_.reset();
  Free();
}

void OmplVariableRrt::Free() {
  for (const std::unique_ptr<Tree>& tree : trees_) {
    if (tree == nullptr) continue;
    std::vector<Node*> nodes;
    tree->list(nodes);
    for (Node* node : nodes) {
      si_->freeState(node->state);
      delete node;
    }
    tree->clear();
  }
  if (scratch_ != nullptr) si_->freeState(scratch_);
  scratch_ = nullptr;
}

OmplVariableRrt::Node* OmplVariableRrt::Add(size_t tree, const ob::State* state,
                                            Node* parent) {
  // The tree owns it until Free.
  auto node = std::make_unique<Node>();
  node->state = si_->cloneState(state);
  node->parent = parent;
  trees_[tree]->add(node.get());
  Node* added = node.get();
  static_cast<void>(node.release());
  return added;
}

OmplVariableRrt::Node* OmplVariableRrt::Step(size_t tree,
                                             const ob::State* towards) {
  Node target = {.state = const_cast<ob::State*>(towards), .parent = nullptr};
  Node* nearest = trees_[tree]->nearest(&target);
  const double distance_m = si_->distance(nearest->state, towards);
  if (distance_m < kReached_m) return nearest;
  const double step_m =
      std::clamp(si_->getStateValidityChecker()->clearance(nearest->state),
                 kMinStep_m, kMaxStep_m.value);
  si_->getStateSpace()->interpolate(
      nearest->state, towards, std::min(1.0, step_m / distance_m), scratch_);
  // The goal's tree is driven towards its root.
  const bool can_drive = tree == 0
                             ? si_->checkMotion(nearest->state, scratch_)
                             : si_->isValid(scratch_) &&
                                   si_->checkMotion(scratch_, nearest->state);
  return can_drive ? Add(tree, scratch_, nearest) : nullptr;
}

void OmplVariableRrt::Report(Node* from_start, Node* from_goal) {
  std::vector<const ob::State*> states;
  for (const Node* node = from_start; node != nullptr; node = node->parent) {
    states.push_back(node->state);
  }
  std::ranges::reverse(states);
  for (const Node* node = from_goal->parent; node != nullptr;
       node = node->parent) {
    states.push_back(node->state);
  }
  auto path = std::make_shared<ompl::geometric::PathGeometric>(si_);
  for (const ob::State* state : states) path->append(state);
  pdef_->addSolutionPath(path, false, 0.0, getName());
}

ob::PlannerStatus OmplVariableRrt::solve(
    const ob::PlannerTerminationCondition& is_over) {
  checkValidity();
  if (scratch_ == nullptr) scratch_ = si_->allocState();
  if (sampler_ == nullptr) sampler_ = si_->allocStateSampler();
  while (const ob::State* state = pis_.nextStart()) Add(0, state, nullptr);
  if (trees_[0]->size() == 0) return ob::PlannerStatus::INVALID_START;
  if (const ob::State* state = pis_.nextGoal(is_over)) Add(1, state, nullptr);
  if (trees_[1]->size() == 0) return ob::PlannerStatus::INVALID_GOAL;
  ob::State* sample = si_->allocState();
  bool is_solved = false;
  for (size_t own = 0; !is_solved && !is_over; own = 1 - own) {
    sampler_->sampleUniform(sample);
    Node* node = Step(own, sample);
    if (node == nullptr) continue;
    // The other tree grows towards it as long as it gets on.
    Node* last = nullptr;
    for (Node* other = Step(1 - own, node->state);
         other != nullptr && other != last;
         other = Step(1 - own, node->state)) {
      last = other;
      if (si_->distance(other->state, node->state) < kReached_m) {
        Report(own == 0 ? node : other, own == 0 ? other : node);
        is_solved = true;
        break;
      }
    }
  }
  si_->freeState(sample);
  return is_solved ? ob::PlannerStatus::EXACT_SOLUTION
                   : ob::PlannerStatus::TIMEOUT;
}

void OmplVariableRrt::getPlannerData(ob::PlannerData& data) const {
  Planner::getPlannerData(data);
  for (size_t tree = 0; tree < trees_.size(); ++tree) {
    if (trees_[tree] == nullptr) continue;
    std::vector<Node*> nodes;
    trees_[tree]->list(nodes);
    for (const Node* node : nodes) {
      const int tag = static_cast<int>(tree) + 1;
      const ob::PlannerDataVertex own(node->state, tag);
      if (node->parent == nullptr) {
        if (tree == 0) {
          data.addStartVertex(own);
        } else {
          data.addGoalVertex(own);
        }
        continue;
      }
      const ob::PlannerDataVertex parent(node->parent->state, tag);
      if (tree == 0) {
        data.addEdge(parent, own);
      } else {
        data.addEdge(own, parent);
      }
    }
  }
}

}  // namespace treeline::planning
