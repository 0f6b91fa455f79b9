// The robot follows a path to the next pose of its goal.
#ifndef NAV_AGENT_BEHAVIOR_DRIVING_STATE_H_
#define NAV_AGENT_BEHAVIOR_DRIVING_STATE_H_

#include <optional>
#include <string>
#include <variant>

#include "nav_agent/behavior/arrival_check.h"
#include "nav_agent/behavior/background_plans.h"
#include "nav_agent/behavior/goal_course.h"
#include "nav_agent/behavior/goal_tools.h"

namespace treeline::behavior {

// Waits for what moves, remembers what stands in the way, notices when the
// robot does not get on. What follows is the executor's.
class DrivingState {
 public:
  // Hands the path to the controller. what: for people.
  DrivingState(const PlannedPath& plan, const char* what, GoalCourse& goal,
               GoalTools& tools);

  struct GoesOn {};
  // Another plan is needed, from where the robot is.
  struct NeedsPlan {};
  // It has come to a pose that is driven through.
  struct PassedPose {};
  using Outcome =
      std::variant<GoesOn, NeedsPlan, PassedPose, GoalTrouble, GoalEnd>;
  struct Result {
    Outcome outcome;
    // The controller's, of this step.
    core::VelocityCommand command;
  };
  Result Step(const control::ControlPose& pose, GoalCourse& goal,
              GoalTools& tools, base::MonotonicTime now);

  // Something that stood in the way is gone.
  void NoteWayIsFree() { way_is_free_ = true; }
  // About straight ahead, at more than a crawl.
  bool DrivesStraight() const;
  // It stands at, or beside, a goal that something stands on.
  bool WaitsAtGoal() const { return waits_at_goal_; }
  // The path from the next pose on, if it was found already.
  const std::optional<planning::PlanResult>& next_leg() const {
    return background_.next_leg();
  }

 private:
  void Follow(const PlannedPath& plan, const char* what, GoalCourse& goal,
              GoalTools& tools);
  void StepBackground(const control::ControlPose& pose, GoalCourse& goal,
                      GoalTools& tools, base::MonotonicTime now);
  bool PassesPose(const core::LevelPose& robot, const GoalTools& tools) const;
  Outcome Arrive(const control::ControlPose& pose, GoalCourse& goal,
                 GoalTools& tools, base::MonotonicTime now);
  GoalEnd EndAt(std::string where, GoalCourse& goal) const;
  // The robot is as near as it comes to a goal that it cannot take: waits, or
  // ends. nullopt: it is not so near.
  std::optional<Outcome> MeetAtGoal(const control::ControlPose& pose,
                                    const char* what, GoalCourse& goal,
                                    GoalTools& tools, base::MonotonicTime now);
  static GoalEnd EndBeside(const core::LevelPose& robot, const char* what,
                           GoalCourse& goal, const GoalTools& tools);
  Outcome Wait(const control::ControlPose& pose, GoalCourse& goal,
               GoalTools& tools, base::MonotonicTime now);
  Outcome MeetObstacle(const control::ControlPose& pose,
                       const std::string& what, GoalCourse& goal,
                       GoalTools& tools, base::MonotonicTime now);
  Outcome CheckProgress(const core::LevelPose& robot, GoalCourse& goal,
                        GoalTools& tools, base::MonotonicTime now) const;

  BackgroundPlans background_;
  ArrivalCheck arrival_;
  // The controller's last.
  control::ControlResult control_;
  std::optional<base::MonotonicTime> waiting_since_;
  // Since the path is followed.
  bool way_is_free_ = false;
  bool waits_at_goal_ = false;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_DRIVING_STATE_H_
