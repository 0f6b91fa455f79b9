// Drives a robot into its dock, and out before it does anything else.
#ifndef NAV_AGENT_DOCKING_DOCK_PILOT_H_
#define NAV_AGENT_DOCKING_DOCK_PILOT_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "nav_agent/behavior/event_log.h"
#include "nav_agent/behavior/navigator.h"
#include "nav_agent/core/battery.h"
#include "nav_agent/docking/dock.h"
#include "nav_agent/docking/dock_sight.h"
#include "nav_agent/docking/docking_status.h"

namespace treeline::docking {

using Docks = std::shared_ptr<const std::vector<Dock>>;

// Above the navigator, as a route is. To its staging pose the robot drives as
// to any goal. From there it is steered, slowly, along the dock's line; the
// guard stops it before all that stands in the way, and lets it come up to the
// dock itself (control::CloseApproach). It is docked when it stands within the
// tolerances, or when the battery has begun to charge; where the battery says
// that it does not, it presses on a little, and that was a try in vain. After
// such a one, or where it does not get on, it backs out and tries again.
//
// A robot that stands so far in a dock that it cannot turn is steered straight
// out, to the staging pose, before any goal is driven, whoever set it. If
// something holds it there, its goal drives it as it can.
//
// Where a robot has stood in a dock, it knows what the laser sees there
// (Dock::view), and goes by that from the staging pose on. A robot that charges
// and does not know where it is, is told so by that.
//
// Not thread-safe: everything is called by the thread that steps the navigator.
class DockPilot {
 public:
  explicit DockPilot(const core::RobotModel& robot)
      : robot_(robot), sight_(robot) {}

  // Those there are; never null. A dock that is gone while it is driven to ends
  // that; one that was moved is driven to where it is now.
  void SetDocks(Docks docks) { docks_ = std::move(docks); }
  const Docks& docks() const { return docks_; }

  // Whether it may stand in this dock now: as Navigator's Steer. Nothing moves.
  static absl::Status Check(behavior::Navigator& navigator, const Dock& dock);
  // Replaces the goal and the docking there are. Its number. Errors: as
  // Navigator's SetGoal and Steer.
  absl::StatusOr<uint64_t> Begin(behavior::Navigator& navigator,
                                 const Dock& dock);
  // FAILED_PRECONDITION: it is in no dock, or on its way to one; stopped.
  absl::Status DriveOut(behavior::Navigator& navigator);
  // NOT_FOUND: there is no docking, and it does not drive out by itself.
  absl::Status Cancel(behavior::Navigator& navigator);
  // A dock whose view is known now, to be kept; once.
  std::optional<Dock> TakeLearned() {
    return std::exchange(learned_, std::nullopt);
  }
  // For the end of the program, before the navigator halts.
  void Halt() { is_halted_ = true; }

  // After each step of the navigator. battery: nullopt: it does not tell.
  void Step(behavior::Navigator& navigator, base::MonotonicTime now,
            const std::optional<core::Battery>& battery);

  const DockingStatus& status() const { return status_; }
  bool IsUnderWay() const {
    return status_.outcome == DockingOutcome::kUnderWay;
  }
  bool IsDocked() const { return status_.state == DockingState::kDocked; }
  // The battery says so, in the dock.
  bool IsCharging() const {
    return IsDocked() && charging_ == core::Charging::kYes;
  }
  // Of its docking, the navigator's goal; 0: none.
  uint64_t goal_id() const { return goal_id_; }
  // Where that leads.
  const core::LevelPose& target() const { return target_; }
  // "dock", since the last call.
  std::vector<behavior::NavigatorEvent> TakeEvents() { return events_.Take(); }

 private:
  // ---- a docking ----
  void FollowDocks(behavior::Navigator& navigator);
  absl::Status GoToStaging(behavior::Navigator& navigator);
  void StepToStaging(behavior::Navigator& navigator);
  void StepIn(behavior::Navigator& navigator);
  void StepInAt(behavior::Navigator& navigator, const DockOffset& off);
  // The battery has begun to charge: a little further, to stand well.
  void StepCharging(behavior::Navigator& navigator, const DockOffset& off);
  void StepTouching(behavior::Navigator& navigator, const DockOffset& off);
  void StepOut(behavior::Navigator& navigator);
  void FailTry(const std::string& why);
  void Arrive(behavior::Navigator& navigator, const DockOffset& off,
              const std::string& by);
  void End(DockingOutcome outcome, const std::string& why);
  // ---- out of a dock ----
  void LookAtGoal(behavior::Navigator& navigator);
  void BeginOut(const Dock& dock);
  // why_not: empty: it is out.
  void EndOut(const std::string& why_not);
  // The goal there is drives as it can from now on.
  void Release(const behavior::Navigator& navigator);
  // ---- what it sees ----
  // The navigator knows what stands at the docks.
  void TellThings(behavior::Navigator& navigator);
  void WakeUp(behavior::Navigator& navigator);
  void HoldWhereItCharges(behavior::Navigator& navigator, bool is_lost,
                          const behavior::NavigatorSnapshot& shot);
  bool WasCarried(const behavior::NavigatorSnapshot& shot) const;
  void LearnView(const behavior::Navigator& navigator);
  // dock_ as it is seen.
  void LookForDock(const behavior::Navigator& navigator);
  // ---- all ----
  void LookWhereItIs(const behavior::Navigator& navigator);
  bool IsSteered() const;
  // False: that ended it.
  bool MaySteer(behavior::Navigator& navigator);
  // An error ends what it does.
  void Steer(behavior::Navigator& navigator, const Dock& dock,
             const core::VelocityCommand& wanted, const std::string& what);
  void Enter(DockingState state);
  // It got on, or nothing is to be expected of it now.
  void NoteProgress(double along_m, double turned_rad);
  double Stood_s() const;
  std::optional<core::LevelPose> PoseOf(
      const behavior::Navigator& navigator) const;

  const core::RobotModel robot_;
  Docks docks_ = std::make_shared<const std::vector<Dock>>();
  behavior::EventLog events_;
  DockingStatus status_;
  DockSight sight_;
  // That it drives to, and the same where it is seen.
  Dock dock_;
  Dock seen_;
  bool is_move_told_ = false;
  std::optional<Dock> learned_;
  // What the navigator knows of; when it was last looked for a robot in one.
  Docks told_;
  std::optional<base::MonotonicTime> woke_;
  // Where it stands still since it charges, if it knows, and in which dock: it
  // was not carried, unless it sees something else.
  std::optional<core::LevelPose> charges_at_;
  std::string charges_in_;
  // Until it charges no more, or knows its dock again: it is not held there.
  std::string carried_from_;
  base::MonotonicTime now_;
  core::Charging charging_ = core::Charging::kUnknown;
  bool is_full_ = false;
  bool is_halted_ = false;
  // ---- a docking ----
  uint64_t goal_id_ = 0;
  core::LevelPose target_;
  // It charged before it drove in, if one believes that: no contact shows.
  bool charged_before_ = false;
  bool is_straight_ = false;
  // Where the battery began to charge (m).
  std::optional<double> contact_along_m_;
  std::string failed_why_;
  // Where it got on last, and when.
  DockOffset best_;
  std::optional<base::MonotonicTime> got_on_;
  // ---- out of a dock ----
  Dock out_of_;
  // Goals up to this one are looked at; and that drives as it can.
  uint64_t seen_goal_ = 0;
  uint64_t released_goal_ = 0;
  bool is_out_asked_for_ = false;
  std::optional<base::MonotonicTime> looked_;
};

}  // namespace treeline::docking

#endif  // NAV_AGENT_DOCKING_DOCK_PILOT_H_
