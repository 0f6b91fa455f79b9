// What is planned while the robot drives.
#ifndef NAV_AGENT_BEHAVIOR_BACKGROUND_PLANS_H_
#define NAV_AGENT_BEHAVIOR_BACKGROUND_PLANS_H_

#include <optional>
#include <vector>

#include "nav_agent/behavior/goal_course.h"
#include "nav_agent/behavior/goal_tools.h"

namespace treeline::behavior {

// First a better path than that of the first budget, then the way on from the
// next pose. Not thread-safe.
class BackgroundPlans {
 public:
  explicit BackgroundPlans(bool wants_better) : wants_better_(wants_better) {}

  // Asks one thing at a time. A path to the next pose, if one came.
  std::optional<PlannedPath> Step(const GoalCourse& goal,
                                  const core::LevelPose& robot,
                                  GoalTools& tools, base::MonotonicTime now);

  // The path from the next pose to the one after it, if it was found.
  const std::optional<planning::PlanResult>& next_leg() const {
    return next_leg_;
  }

 private:
  bool wants_better_;
  bool asked_next_leg_ = false;
  std::optional<planning::PlanResult> next_leg_;
};

// A leg that begins where `path` ends, for a robot that has not quite come
// there: what is left of the path, then the leg.
planning::PlanResult JoinLeg(const std::vector<core::LevelPose>& path,
                             const core::LevelPose& robot,
                             planning::PlanResult leg);

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_BACKGROUND_PLANS_H_
