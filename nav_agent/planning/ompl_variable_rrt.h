// Our variable-step RRT as a planner of OMPL. Included by .cc files only: the
// headers of OMPL are heavy.
#ifndef NAV_AGENT_PLANNING_OMPL_VARIABLE_RRT_H_
#define NAV_AGENT_PLANNING_OMPL_VARIABLE_RRT_H_

#include <array>
#include <memory>
#include <vector>

#include "ompl/base/Planner.h"
#include "ompl/base/StateSampler.h"
#include "ompl/datastructures/NearestNeighborsLinear.h"

namespace treeline::planning {

// Bidirectional, like RRTConnect; but a step from a state is as long as the
// validity checker's clearance of it, so there is no range to set. Works in
// any metric space whose checker knows clearances.
class OmplVariableRrt final : public ompl::base::Planner {
 public:
  explicit OmplVariableRrt(const ompl::base::SpaceInformationPtr& space);
  ~OmplVariableRrt() override;

  void setup() override;
  void clear() override;
  ompl::base::PlannerStatus solve(
      const ompl::base::PlannerTerminationCondition& is_over) override;
  void getPlannerData(ompl::base::PlannerData& data) const override;

 private:
  struct Node {
    ompl::base::State* state = nullptr;
    Node* parent = nullptr;
  };
  using Tree = ompl::NearestNeighborsLinear<Node*>;

  Node* Add(size_t tree, const ompl::base::State* state, Node* parent);
  // A step towards a state; null if it cannot be driven.
  Node* Step(size_t tree, const ompl::base::State* towards);
  void Report(Node* from_start, Node* from_goal);
  void Free();

  // The start's and the goal's.
  std::array<std::unique_ptr<Tree>, 2> trees_;
  ompl::base::StateSamplerPtr sampler_;
  ompl::base::State* scratch_ = nullptr;
};

}  // namespace treeline::planning

#endif  // NAV_AGENT_PLANNING_OMPL_VARIABLE_RRT_H_
