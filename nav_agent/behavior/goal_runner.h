// One goal from its acceptance to its end: plans, drives, goes around what
// stands in the way, and tries what else there is before it gives up.
#ifndef NAV_AGENT_BEHAVIOR_GOAL_RUNNER_H_
#define NAV_AGENT_BEHAVIOR_GOAL_RUNNER_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nav_agent/behavior/blockage_memory.h"
#include "nav_agent/behavior/event_log.h"
#include "nav_agent/behavior/maneuver.h"
#include "nav_agent/behavior/plan_runner.h"
#include "nav_agent/behavior/progress_watch.h"

namespace treeline {

// What it does about its goal. docs/navigator.md draws the transitions.
enum class GoalPhase : uint8_t {
  kNone,      // no goal is active
  kToPlan,    // a plan from where the robot is, in the next step
  kPlanning,  // waits for it, standing
  kDriving,
  kRecovering
};

// Not thread-safe. What is given must outlive it.
class GoalRunner {
 public:
  GoalRunner(std::shared_ptr<const NavigationMap> map, PlanRunner& planner,
             LocalController& controller, const NavigatorOptions& options,
             EventLog& events);

  // A goal with at least one pose, all finite; what there is, is preempted.
  uint64_t Start(const NavigationGoal& goal);
  // Ends the goal there is, if it is active.
  void End(GoalState state, NavigationCause cause, const std::string& why);
  // The robot stands for another reason, or is somewhere else: a plan is needed
  // before it goes on.
  void Suspend();

  // Something that stood in the way is gone: no need to wait for it.
  void NoteWayIsFree();

  // What to do now. Only while the robot may move, and knows where it is.
  VelocityCommand Step(const ControlPose& pose, MonotonicTime now);

  GoalPhase phase() const { return phase_; }
  bool is_active() const { return phase_ != GoalPhase::kNone; }
  const std::optional<GoalStatus>& status() const { return status_; }
  // About straight ahead, at more than a crawl.
  bool DrivesStraight() const;
  // Of the drive or the maneuver: why it does not get on.
  NavigationCause trouble() const { return trouble_cause_; }

  BlockageMemory& blockages() { return blockages_; }
  const BlockageMemory& blockages() const { return blockages_; }
  const std::vector<LevelPose>& path() const { return path_; }
  const std::vector<Vec2>& tree_edges() const { return tree_edges_; }

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
    MonotonicTime since;
    bool has_blockages = false;
  };

  const LevelPose& Target() const { return goal_.poses[status_->next_pose]; }
  bool IsLastLeg() const {
    return status_->next_pose + 1 == goal_.poses.size();
  }
  void Ask(PlanPurpose purpose, const LevelPose& from, const LevelPose& to,
           MonotonicTime now);
  void StepPlanning(const ControlPose& pose, MonotonicTime now);
  void TakePlan(const ControlPose& pose, const PlanResult& result,
                MonotonicTime now);
  void TakeNoPlan(const ControlPose& pose, const PlanResult& result,
                  MonotonicTime now);
  // had_blockages: the planner was told of what stands about.
  void TakePath(const PlanResult& result, bool had_blockages, const char* what);
  // Plans while driving.
  void StepBackground(const ControlPose& pose, MonotonicTime now);
  VelocityCommand StepDriving(const ControlPose& pose, MonotonicTime now);
  bool PassesPose(const ControlPose& pose) const;
  void NextLeg(const LevelPose& robot);
  void Arrive(const ControlPose& pose, MonotonicTime now);
  void MeetObstacle(const ControlPose& pose, const ControlResult& result,
                    const std::string& what, MonotonicTime now);
  void BeginTrouble(Trouble trouble, NavigationCause cause,
                    const std::string& why, MonotonicTime now);
  void NextManeuver(MonotonicTime now);
  VelocityCommand StepManeuver(const ControlPose& pose, MonotonicTime now);
  void BlockAhead(const ControlPose& pose, MonotonicTime now);
  void Measure(const ControlPose& pose);

  std::shared_ptr<const NavigationMap> map_;
  PlanRunner* planner_;
  LocalController* controller_;
  NavigatorOptions options_;
  EventLog* events_;

  uint64_t last_id_ = 0;
  uint64_t plans_ = 0;
  NavigationGoal goal_;
  std::optional<GoalStatus> status_;
  GoalPhase phase_ = GoalPhase::kNone;

  std::optional<AskedPlan> asked_;
  // The last failure, while it is asked whether there is a way otherwise.
  PlanResult failure_;
  std::vector<LevelPose> path_;
  std::vector<Vec2> tree_edges_;
  // How far from the goal it ends, where there is room (m); whether that is
  // because of something seen at the goal, which may go.
  double beside_goal_m_ = 0;
  bool goal_is_taken_ = false;
  bool is_first_path_ = true;
  bool wants_better_ = false;
  // The path from the next pose on, if it was found already.
  std::optional<PlanResult> next_leg_;
  bool asked_next_leg_ = false;

  ControlResult control_;
  ProgressWatch progress_;
  BlockageMemory blockages_;
  int replans_ = 0;  // since it got on
  std::optional<MonotonicTime> waiting_since_;
  std::optional<MonotonicTime> arrived_since_;

  ManeuverLadder ladder_;
  std::optional<Maneuver> maneuver_;
  MonotonicTime maneuver_since_;
  bool way_is_free_ = false;
  Trouble trouble_ = Trouble::kNoWay;
  NavigationCause trouble_cause_ = NavigationCause::kNone;
  std::string trouble_why_;
  std::optional<Vec2> last_position_;
};

}  // namespace treeline

#endif  // NAV_AGENT_BEHAVIOR_GOAL_RUNNER_H_
