// A goal of a robot without a map, from beginning to end.
#ifndef NAV_AGENT_MAPLESS_GOAL_DRIVE_H_
#define NAV_AGENT_MAPLESS_GOAL_DRIVE_H_

#include <cstdint>
#include <optional>
#include <string>

#include "nav_agent/behavior/event_log.h"
#include "nav_agent/behavior/navigator.h"
#include "nav_agent/mapless/dead_reckoning.h"
#include "nav_agent/mapless/mapless_navigator.h"
#include "nav_agent/mapless/rollout_controller.h"

namespace treeline::mapless {

// Plans, drives, backs off where it is stuck, turns at the goal. Not
// thread-safe. `events` must outlive it.
class GoalDrive {
 public:
  GoalDrive(const core::RobotModel& robot, const MaplessOptions& options,
            behavior::EventLog& events);

  // A goal with at least one pose, all finite; what there is, is preempted.
  uint64_t Begin(const behavior::NavigationGoal& goal, base::MonotonicTime now);
  void End(behavior::GoalState state, core::NavigationCause cause,
           std::string why);
  // The robot is somewhere else.
  void ForgetWay();

  // What to do now; command: what the base was told last. The map forgets all
  // when nothing leads to the goal any more.
  core::VelocityCommand Step(const ReckonedPose& pose,
                             const core::VelocityCommand& command,
                             EvidenceGrid& map, const MoverTracker& movers,
                             base::MonotonicTime now);

  // As much of a command of somebody else as what is seen allows.
  core::VelocityCommand Allow(const ReckonedPose& pose,
                              const core::VelocityCommand& command,
                              const core::VelocityCommand& wanted,
                              const EvidenceGrid& map,
                              const MoverTracker& movers,
                              base::MonotonicTime now) const;

  bool is_active() const { return is_active_; }
  bool is_backing_off() const { return back_off_until_.has_value(); }
  // Of the last goal; nullopt: there was none.
  std::optional<behavior::GoalStatus> status() const { return status_; }
  const WayField& way() const { return way_; }

 private:
  geometry::Rigid2 Target() const {
    return goal_.poses[status_->next_pose].map_from_base;
  }
  // When the next command is obeyed.
  RobotMotion MotionAhead(const ReckonedPose& pose,
                          const core::VelocityCommand& command,
                          base::MonotonicTime now) const;
  Surroundings AroundAt(const ReckonedPose& pose, const EvidenceGrid& map,
                        const MoverTracker& movers,
                        base::MonotonicTime now) const;
  bool Arrives(const RobotMotion& motion, base::MonotonicTime now);
  void Plan(const RobotMotion& motion, EvidenceGrid& map,
            base::MonotonicTime now);
  core::VelocityCommand Drive(const RobotMotion& motion,
                              const Surroundings& around,
                              base::MonotonicTime now);
  void WatchProgress(const RobotMotion& motion, base::MonotonicTime now);

  MaplessOptions options_;
  behavior::EventLog& events_;
  BodyShape body_;
  WayField way_;
  TimedWay timed_way_;
  RolloutController rollouts_;

  behavior::NavigationGoal goal_;
  std::optional<behavior::GoalStatus> status_;
  uint64_t last_id_ = 0;
  bool is_active_ = false;
  std::optional<base::MonotonicTime> planned_;
  bool has_way_ = false;
  int way_changes_ = 0;
  std::optional<base::MonotonicTime> no_way_since_;
  int forgot_ = 0;
  // Since when it stands on its way.
  std::optional<base::MonotonicTime> stands_since_;
  std::optional<base::MonotonicTime> back_off_until_;
  std::optional<geometry::Vec2> last_position_;
  double nearest_m_ = 0;
  base::MonotonicTime nearest_since_;
};

}  // namespace treeline::mapless

#endif  // NAV_AGENT_MAPLESS_GOAL_DRIVE_H_
