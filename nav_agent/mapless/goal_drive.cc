#include "nav_agent/mapless/goal_drive.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "absl/strings/str_format.h"
#include "nav_agent/mapless/parameters.h"

namespace treeline::mapless {
namespace {

// What rollouts need of the map around the robot (m).
constexpr double kWindow_m = 4;
constexpr double kProgress_m = 0.3;
constexpr double kStanding_mps = 0.05;
constexpr double kStanding_radps = 0.1;
// Without a way for so long, what was seen is forgotten: something of it was
// wrong, or has gone. So often; then the goal fails.
constexpr double kForget_s = 3;
constexpr int kMaxForgot = 2;

base::MonotonicTime After(base::MonotonicTime now, double seconds) {
  return now + std::chrono::duration_cast<base::MonotonicTime::duration>(
                   std::chrono::duration<double>(seconds));
}

double LimitOf(double wanted, double robot) {
  return wanted > 0 ? std::min(wanted, robot) : robot;
}

}  // namespace

GoalDrive::GoalDrive(const core::RobotModel& robot,
                     const MaplessOptions& options, behavior::EventLog& events)
    : options_(options),
      events_(events),
      body_(robot, kBodyMargin_m),
      way_(body_),
      timed_way_(0.5 * (body_.inner_m() + body_.outer_m()) - kBodyMargin_m,
                 LimitOf(options.max_forward_mps, robot.max_forward_mps)),
      rollouts_(robot, body_,
                {.max_forward_mps =
                     LimitOf(options.max_forward_mps, robot.max_forward_mps),
                 .max_yaw_rate_radps = robot.max_yaw_rate_radps}) {}

uint64_t GoalDrive::Begin(const behavior::NavigationGoal& goal,
                          base::MonotonicTime now) {
  if (is_active_) {
    End(behavior::GoalState::kCancelled, core::NavigationCause::kPreempted,
        "another goal took its place");
  }
  goal_ = goal;
  status_.emplace();
  status_->id = ++last_id_;
  status_->state = behavior::GoalState::kActive;
  is_active_ = true;
  forgot_ = 0;
  last_position_.reset();
  ForgetWay();
  nearest_since_ = now;
  const geometry::Vec2 at = goal_.poses.back().map_from_base.translation;
  events_.Add("goal", absl::StrFormat("goal %d: to (%.2f, %.2f)", status_->id,
                                      at.x, at.y));
  return status_->id;
}

void GoalDrive::ForgetWay() {
  way_.Restart();
  timed_way_.Clear();
  rollouts_.Restart();
  planned_.reset();
  has_way_ = false;
  way_changes_ = 0;
  no_way_since_.reset();
  stands_since_.reset();
  back_off_until_.reset();
  nearest_m_ = WayField::kNoWay;
}

void GoalDrive::End(behavior::GoalState state, core::NavigationCause cause,
                    std::string why) {
  is_active_ = false;
  back_off_until_.reset();
  status_->state = state;
  status_->cause = cause;
  events_.Add("goal", absl::StrFormat("goal %d: %s", status_->id, why));
  status_->why = std::move(why);
}

bool GoalDrive::Arrives(const RobotMotion& motion, base::MonotonicTime now) {
  const geometry::Rigid2 target = Target();
  const double distance_m =
      geometry::Norm(target.translation - motion.map_from_base.translation);
  const bool is_last = status_->next_pose + 1 == goal_.poses.size();
  if (!is_last) {
    if (distance_m > std::max(0.3, options_.goal_tolerance_m)) return false;
    ++status_->next_pose;
    ForgetWay();
    nearest_since_ = now;
    return false;
  }
  return distance_m <=
         options_.goal_tolerance_m + (has_way_ ? way_.moved_goal_m() : 0.0);
}

void GoalDrive::Plan(const RobotMotion& motion, EvidenceGrid& map,
                     base::MonotonicTime now) {
  if (planned_.has_value() &&
      base::SecondsBetween(*planned_, now) < kReplan_s) {
    return;
  }
  planned_ = now;
  has_way_ =
      way_.Update(map, motion.map_from_base.translation, Target().translation);
  if (way_.changes() != way_changes_) {
    way_changes_ = way_.changes();
    ++status_->replans;
    events_.Add("plan",
                absl::StrFormat("another way of %.1f m", way_.length_m()));
  }
  if (has_way_) {
    no_way_since_.reset();
    status_->to_go_m = way_.length_m();
    return;
  }
  if (!no_way_since_.has_value()) no_way_since_ = now;
  if (base::SecondsBetween(*no_way_since_, now) < kForget_s) return;
  if (forgot_++ >= kMaxForgot) {
    End(behavior::GoalState::kFailed, core::NavigationCause::kNoPath,
        "what was seen leaves no way to the goal");
    return;
  }
  events_.Add("recovery", "no way: what was seen is forgotten");
  ++status_->recoveries;
  no_way_since_.reset();
  map.Clear();
}

void GoalDrive::WatchProgress(const RobotMotion& motion,
                              base::MonotonicTime now) {
  const double to_go_m = way_.ToGo(motion.map_from_base.translation);
  if (to_go_m < nearest_m_ - kProgress_m) {
    nearest_m_ = to_go_m;
    nearest_since_ = now;
  } else if (base::SecondsBetween(nearest_since_, now) > options_.patience_s) {
    End(behavior::GoalState::kFailed, core::NavigationCause::kNoProgress,
        absl::StrFormat("no nearer for %.0f s", options_.patience_s));
  }
}

core::VelocityCommand GoalDrive::Drive(const RobotMotion& motion,
                                       const Surroundings& around,
                                       base::MonotonicTime now) {
  if (back_off_until_.has_value()) {
    if (now < *back_off_until_) return rollouts_.BackOff(motion, around);
    back_off_until_.reset();
    stands_since_.reset();
    rollouts_.Restart();
  }
  const std::optional<core::VelocityCommand> best =
      has_way_ ? rollouts_.Best(motion, around, way_, timed_way_)
               : std::nullopt;
  const bool stands = std::abs(motion.forward_mps) < kStanding_mps &&
                      std::abs(motion.yaw_rate_radps) < kStanding_radps;
  if (!stands) {
    stands_since_.reset();
  } else if (!stands_since_.has_value()) {
    stands_since_ = now;
  } else if (has_way_ && base::SecondsBetween(*stands_since_, now) > kStuck_s) {
    back_off_until_ = After(now, kBackOff_s);
    ++status_->recoveries;
    events_.Add("recovery", "stuck: it backs off");
  }
  return best.value_or(core::VelocityCommand());
}

RobotMotion GoalDrive::MotionAhead(const ReckonedPose& pose,
                                   const core::VelocityCommand& command,
                                   base::MonotonicTime now) const {
  // One step from now.
  const double ahead_s =
      std::clamp(base::SecondsBetween(pose.stamp, now), 0.0, 0.1) +
      1 / options_.control_hz;
  return {
      .map_from_base = MovedOn(
          pose.map_from_base, 0.5 * (pose.forward_mps + command.forward_mps),
          0.5 * (pose.yaw_rate_radps + command.yaw_rate_radps), ahead_s),
      .forward_mps = pose.forward_mps,
      .yaw_rate_radps = pose.yaw_rate_radps};
}

Surroundings GoalDrive::AroundAt(const ReckonedPose& pose,
                                 const EvidenceGrid& map,
                                 const MoverTracker& movers,
                                 base::MonotonicTime now) const {
  const geometry::Vec2 position = pose.map_from_base.translation;
  const geometry::Vec2 reach = {kWindow_m, kWindow_m};
  return {.clearance = ClearanceWindow(map, position - reach, position + reach),
          .movers = movers.MoversAt(After(now, 1 / options_.control_hz))};
}

core::VelocityCommand GoalDrive::Allow(const ReckonedPose& pose,
                                       const core::VelocityCommand& command,
                                       const core::VelocityCommand& wanted,
                                       const EvidenceGrid& map,
                                       const MoverTracker& movers,
                                       base::MonotonicTime now) const {
  return rollouts_.Allow(MotionAhead(pose, command, now),
                         AroundAt(pose, map, movers, now), wanted);
}

core::VelocityCommand GoalDrive::Step(const ReckonedPose& pose,
                                      const core::VelocityCommand& command,
                                      EvidenceGrid& map,
                                      const MoverTracker& movers,
                                      base::MonotonicTime now) {
  if (!is_active_) return {};
  const geometry::Vec2 position = pose.map_from_base.translation;
  if (last_position_.has_value()) {
    status_->driven_m += geometry::Norm(position - *last_position_);
  }
  last_position_ = position;
  const RobotMotion motion = MotionAhead(pose, command, now);
  const Surroundings around = AroundAt(pose, map, movers, now);
  if (Arrives(motion, now)) {
    const double off_rad = geometry::NormalizedAngle_rad(
        Target().yaw_rad - motion.map_from_base.yaw_rad);
    status_->to_go_m = 0;
    const bool is_turned = !options_.turns_at_goal ||
                           std::abs(off_rad) < options_.goal_tolerance_rad;
    if (!is_turned) {
      const core::VelocityCommand turn =
          rollouts_.Turn(motion, around, off_rad);
      if (turn.yaw_rate_radps != 0 ||
          std::abs(pose.forward_mps) > kStanding_mps) {
        return turn;
      }
    }
    if (std::abs(pose.forward_mps) < kStanding_mps) {
      ++status_->next_pose;
      End(behavior::GoalState::kSucceeded, core::NavigationCause::kNone,
          absl::StrFormat("arrived after %.1f m", status_->driven_m));
    }
    return {};
  }
  Plan(motion, map, now);
  if (!is_active_) return {};
  WatchProgress(motion, now);
  if (!is_active_) return {};
  timed_way_.Update(way_, around.movers, motion.map_from_base.translation);
  return Drive(motion, around, now);
}

}  // namespace treeline::mapless
