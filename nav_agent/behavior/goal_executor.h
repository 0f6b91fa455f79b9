// One goal from its acceptance to its end: plans, drives, goes around what
// stands in the way, and tries what else there is before it gives up.
#ifndef NAV_AGENT_BEHAVIOR_GOAL_EXECUTOR_H_
#define NAV_AGENT_BEHAVIOR_GOAL_EXECUTOR_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nav_agent/behavior/event_log.h"
#include "nav_agent/behavior/maneuver.h"
#include "nav_agent/behavior/obstacle_memory.h"
#include "nav_agent/behavior/planner_worker.h"
#include "nav_agent/behavior/progress_checker.h"

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

// Not thread-safe. What is given must outlive it.
class GoalExecutor {
 public:
  GoalExecutor(std::shared_ptr<const traversability::NavigationMap> map,
               PlannerWorker& planner, control::LocalController& controller,
               const NavigatorOptions& options, EventLog& events);

  // A goal with at least one pose, all finite; what there is, is preempted.
  uint64_t Start(const NavigationGoal& goal);
  // Ends the goal there is, if it is active.
  void End(GoalState state, core::NavigationCause cause,
           const std::string& why);
  // The robot stands for another reason, or is somewhere else: a plan is needed
  // before it goes on.
  void Suspend();

  // Something that stood in the way is gone: no need to wait for it.
  void NoteWayIsFree();

  // What to do now. Only while the robot may move, and knows where it is.
  core::VelocityCommand Step(const control::ControlPose& pose,
                             base::MonotonicTime now);

  GoalPhase phase() const { return phase_; }
  bool is_active() const { return phase_ != GoalPhase::kNone; }
  const std::optional<GoalStatus>& status() const { return status_; }
  // About straight ahead, at more than a crawl.
  bool DrivesStraight() const;
  // Of the drive or the maneuver: why it does not get on.
  core::NavigationCause trouble() const { return trouble_cause_; }

  ObstacleMemory& blockages() { return blockages_; }
  const ObstacleMemory& blockages() const { return blockages_; }
  const std::vector<core::LevelPose>& path() const { return path_; }
  const std::vector<geometry::Vec2>& tree_edges() const { return tree_edges_; }

 private:
  // What a plan is for.
  enum class PlanPurpose : uint8_t {
    kRoute,      // the first path
    kFullRoute,  // the same, with more time
    kUnblocked,  // whether there is a way but for what was seen
    kBetter,     // a shorter one, while driving
    kNextLeg     // to the pose after the next, while driving
  };
  struct AskedPlan {
    PlanPurpose purpose = PlanPurpose::kRoute;
    base::MonotonicTime since;
    bool has_blockages = false;
  };

  const core::LevelPose& Target() const {
    return goal_.poses[status_->next_pose];
  }
  bool IsLastLeg() const {
    return status_->next_pose + 1 == goal_.poses.size();
  }
  void Ask(PlanPurpose purpose, const core::LevelPose& from,
           const core::LevelPose& to, base::MonotonicTime now);
  void StepPlanning(const control::ControlPose& pose, base::MonotonicTime now);
  void TakePlan(const control::ControlPose& pose,
                const planning::PlanResult& result, base::MonotonicTime now);
  void TakeNoPlan(const control::ControlPose& pose,
                  const planning::PlanResult& result, base::MonotonicTime now);
  // had_blockages: the planner was told of what stands about.
  void TakePath(const planning::PlanResult& result, bool had_blockages,
                const char* what);
  // Plans while driving.
  void StepBackground(const control::ControlPose& pose,
                      base::MonotonicTime now);
  core::VelocityCommand StepDriving(const control::ControlPose& pose,
                                    base::MonotonicTime now);
  bool PassesPose(const control::ControlPose& pose) const;
  void NextLeg(const core::LevelPose& robot);
  void Arrive(const control::ControlPose& pose, base::MonotonicTime now);
  void MeetObstacle(const control::ControlPose& pose,
                    const control::ControlResult& result,
                    const std::string& what, base::MonotonicTime now);
  void BeginTrouble(Trouble trouble, core::NavigationCause cause,
                    const std::string& why, base::MonotonicTime now);
  void NextManeuver(base::MonotonicTime now);
  core::VelocityCommand StepManeuver(const control::ControlPose& pose,
                                     base::MonotonicTime now);
  void BlockAhead(const control::ControlPose& pose, base::MonotonicTime now);
  void Measure(const control::ControlPose& pose);

  std::shared_ptr<const traversability::NavigationMap> map_;
  PlannerWorker* planner_;
  control::LocalController* controller_;
  NavigatorOptions options_;
  EventLog* events_;

  uint64_t last_id_ = 0;
  uint64_t plans_ = 0;
  NavigationGoal goal_;
  std::optional<GoalStatus> status_;
  GoalPhase phase_ = GoalPhase::kNone;

  std::optional<AskedPlan> asked_;
  // The last failure, while it is asked whether there is a way otherwise.
  planning::PlanResult failure_;
  std::vector<core::LevelPose> path_;
  std::vector<geometry::Vec2> tree_edges_;
  // How far from the goal it ends, where there is room (m); whether that is
  // because of something seen at the goal, which may go.
  double beside_goal_m_ = 0;
  bool goal_is_taken_ = false;
  bool is_first_path_ = true;
  bool wants_better_ = false;
  // The path from the next pose on, if it was found already.
  std::optional<planning::PlanResult> next_leg_;
  bool asked_next_leg_ = false;

  control::ControlResult control_;
  ProgressChecker progress_;
  ObstacleMemory blockages_;
  int replans_ = 0;  // since it got on
  std::optional<base::MonotonicTime> waiting_since_;
  std::optional<base::MonotonicTime> arrived_since_;

  RecoverySequence ladder_;
  std::optional<RecoveryBehavior> maneuver_;
  base::MonotonicTime maneuver_since_;
  bool way_is_free_ = false;
  Trouble trouble_ = Trouble::kNoWay;
  core::NavigationCause trouble_cause_ = core::NavigationCause::kNone;
  std::string trouble_why_;
  std::optional<geometry::Vec2> last_position_;
};

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_GOAL_EXECUTOR_H_
