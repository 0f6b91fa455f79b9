// One goal from its acceptance to its end: which state follows which. What a
// state does is in a class of its own: planning_state.h, driving_state.h,
// recovering_state.h.
#ifndef NAV_AGENT_BEHAVIOR_GOAL_EXECUTOR_H_
#define NAV_AGENT_BEHAVIOR_GOAL_EXECUTOR_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "nav_agent/behavior/driving_state.h"
#include "nav_agent/behavior/goal_course.h"
#include "nav_agent/behavior/goal_tools.h"
#include "nav_agent/behavior/planning_state.h"
#include "nav_agent/behavior/recovering_state.h"
#include "nav_agent/behavior/travel_meter.h"

namespace treeline::behavior {

// What the robot does to reach its goal. docs/explanation/navigator.md draws
// the transitions.
enum class GoalPhase : uint8_t {
  kNone,      // no goal is active
  kToPlan,    // a plan from where the robot is, in the next step
  kPlanning,  // waits for it, standing
  kDriving,
  kRecovering
};
// What people are shown of it.
NavigatorMode ModeOf(GoalPhase phase);

// Not thread-safe. What is given must outlive it.
class GoalExecutor {
 public:
  GoalExecutor(std::shared_ptr<const traversability::NavigationMap> map,
               PlannerWorker& planner, control::LocalController& controller,
               const NavigatorOptions& options, EventLog& events);

  // A goal with at least one pose, all finite; what there is, is preempted.
  uint64_t Start(const NavigationGoal& goal);
  // Ends the goal there is, if it is active.
  void End(const GoalEnd& end);
  // The robot stands for another reason, or is somewhere else: a plan is needed
  // before it goes on.
  void Suspend();

  // Of the map; null: none. What is driven to is planned anew.
  void SetZones(std::shared_ptr<const zones::ZoneMap> zones);

  // Something that stood in the way is gone: no need to wait for it.
  void NoteWayIsFree();

  // What to do now. Only while the robot may move, and knows where it is.
  core::VelocityCommand Step(const control::ControlPose& pose,
                             base::MonotonicTime now);

  GoalPhase phase() const;
  bool is_active() const { return phase() != GoalPhase::kNone; }
  // Of the last goal; nullopt: there was none.
  std::optional<GoalStatus> status() const;
  // About straight ahead, at more than a crawl.
  bool DrivesStraight() const;
  // What it recovers from, or waits for at its goal; kNone: neither.
  core::NavigationCause trouble() const;

  ObstacleMemory& blockages() { return tools_.blockages; }
  const ObstacleMemory& blockages() const { return tools_.blockages; }
  const PlannedRoute& route() const { return tools_.route; }

 private:
  struct NoGoalState {};
  struct ToPlanState {};
  // In GoalPhase's order.
  using State = std::variant<NoGoalState, ToPlanState, PlanningState,
                             DrivingState, RecoveringState>;

  // What of the map is gone: plans may lead over it.
  void LookThroughMap();
  void StepPlanning(const core::LevelPose& robot, base::MonotonicTime now);
  core::VelocityCommand StepDriving(const control::ControlPose& pose,
                                    base::MonotonicTime now);
  core::VelocityCommand StepRecovering(const control::ControlPose& pose,
                                       base::MonotonicTime now);
  void NextLeg(const core::LevelPose& robot);
  void Recover(GoalTrouble trouble, base::MonotonicTime now);
  void NextManeuver(base::MonotonicTime now);

  GoalTools tools_;
  TravelMeter travel_;
  uint64_t last_id_ = 0;
  // The active goal, or the last.
  std::optional<GoalCourse> goal_;
  State state_;
  // Of this goal.
  bool has_told_of_gone_ = false;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_GOAL_EXECUTOR_H_
