// The robot stands and waits for a path to the next pose of its goal.
#ifndef NAV_AGENT_BEHAVIOR_PLANNING_STATE_H_
#define NAV_AGENT_BEHAVIOR_PLANNING_STATE_H_

#include <optional>
#include <variant>

#include "nav_agent/behavior/goal_course.h"
#include "nav_agent/behavior/goal_tools.h"

namespace treeline::behavior {

// Asks for a path; with more time if that was too short; and whether there
// would be one but for what was seen, so that it can be waited for.
class PlanningState {
 public:
  // Asks for a path from where the robot is.
  PlanningState(const GoalCourse& goal, const core::LevelPose& robot,
                GoalTools& tools, base::MonotonicTime now);

  // monostate: there is no answer yet.
  using Outcome =
      std::variant<std::monostate, PlannedPath, GoalTrouble, GoalEnd>;
  Outcome Step(const GoalCourse& goal, const core::LevelPose& robot,
               GoalTools& tools, base::MonotonicTime now);

  // Something that stood in the way is gone: a failure of a plan that was asked
  // for before is out of date.
  void NoteWayIsFree() { way_is_free_ = true; }

 private:
  // nullopt: another plan was asked for.
  std::optional<Outcome> TakeAnswer(PlanRequests::Answer answer,
                                    const GoalCourse& goal,
                                    const core::LevelPose& robot,
                                    GoalTools& tools, base::MonotonicTime now);

  // The last failure, while it is asked whether there is a way otherwise.
  planning::PlanResult failure_;
  // Since the last plan for a route was asked for.
  bool way_is_free_ = false;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_PLANNING_STATE_H_
