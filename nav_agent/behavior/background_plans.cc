#include "nav_agent/behavior/background_plans.h"

#include <utility>

#include "nav_agent/behavior/pose_lists.h"

namespace treeline::behavior {

std::optional<PlannedPath> BackgroundPlans::Step(const GoalCourse& goal,
                                                 const core::LevelPose& robot,
                                                 GoalTools& tools,
                                                 base::MonotonicTime now) {
  if (!tools.plans.IsOpen()) {
    if (wants_better_) {
      wants_better_ = false;
      tools.plans.Ask(PlanPurpose::kBetter, robot, goal.Target(),
                      tools.blockages.All(), now);
    } else if (!goal.IsLastLeg() && !asked_next_leg_) {
      asked_next_leg_ = true;
      tools.plans.Ask(PlanPurpose::kNextLeg, tools.route.path.back(),
                      goal.goal.poses[goal.status.next_pose + 1],
                      tools.blockages.All(), now);
    }
    return std::nullopt;
  }
  std::optional<PlanRequests::Answer> answer = tools.plans.Take();
  if (!answer.has_value() || !answer->HasPath()) return std::nullopt;
  if (answer->purpose == PlanPurpose::kNextLeg) {
    next_leg_ = *std::move(answer->result);
    return std::nullopt;
  }
  return PlannedPath{.result = *std::move(answer->result),
                     .had_blockages = answer->had_blockages,
                     .may_be_better = false};
}

planning::PlanResult JoinLeg(const std::vector<core::LevelPose>& path,
                             const core::LevelPose& robot,
                             planning::PlanResult leg) {
  std::vector<core::LevelPose> joined = RestOf(path, robot);
  if (joined.size() < 2) return leg;
  leg.length_m += Distance_m(joined.front(), joined.back());
  joined.insert(joined.end(), leg.path.begin() + 1, leg.path.end());
  leg.path = std::move(joined);
  return leg;
}

}  // namespace treeline::behavior
