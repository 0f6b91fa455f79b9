#include "nav_agent/control/escape_regulator.h"

#include <chrono>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "nav_agent/control/manoeuvre_parameters.h"

namespace treeline::control {
namespace {

constexpr double kAhead_s[] = {kEscapeAhead_s, 2 * kEscapeAhead_s};
constexpr double kSpeeds_mps[] = {kSlowSpeed_mps, 0.5 * kSlowSpeed_mps, 0.0,
                                  -0.5 * kSlowSpeed_mps, -kSlowSpeed_mps};
constexpr double kYawRates_radps[] = {0.0, kSlowTurn_radps, -kSlowTurn_radps,
                                      2 * kSlowTurn_radps,
                                      -2 * kSlowTurn_radps};

std::vector<GuardPoint> SeenFrom(const geometry::Rigid2& base_from_there,
                                 std::span<const GuardPoint> points) {
  const geometry::Rigid2 there_from_base = base_from_there.Inverse();
  std::vector<GuardPoint> seen(points.begin(), points.end());
  for (GuardPoint& point : seen)
    point.in_base = there_from_base * point.in_base;
  return seen;
}

// The point of the track that the robot should look at.
geometry::Vec2 TargetOn(std::span<const TrackPoint> track) {
  double along_m = 0;
  for (size_t i = 1; i < track.size(); ++i) {
    along_m += geometry::Norm(track[i].in_map - track[i - 1].in_map);
    if (along_m >= kEscapeLook_m) return track[i].in_map;
  }
  return track.back().in_map;
}

// What a motion has brought, and whether the robot may go on from there: the
// less the better (rad).
double PriceOf(const geometry::Rigid2& motion, const RegulatorInput& input,
               geometry::Vec2 target) {
  const geometry::Rigid2 at = input.pose.pose.map_from_base * motion;
  const geometry::Vec2 to = at.Inverse() * target;
  const double angle_rad = std::atan2(to.y, to.x);
  const double room_m = input.costmap.FootprintDistance_m(at, kRoomWorthMax_m);
  const core::VelocityCommand turn = {
      .forward_mps = 0,
      .yaw_rate_radps = std::copysign(kSlowTurn_radps, angle_rad)};
  const bool is_held =
      input.guard.Check(turn, SeenFrom(motion, input.points)).is_limited;
  return std::abs(angle_rad) + geometry::Norm(to) - kRoomWorth * room_m +
         (is_held ? double{kHeldCost_rad} : 0);
}

}  // namespace

void EscapeRegulator::Regulate(const RegulatorInput& input,
                               RegulatedVelocity& regulated) {
  if (!input.should_escape || regulated.is_at_goal || input.track.size() < 2) {
    return;
  }
  regulated.escapes = true;
  regulated.velocity =
      Find(input, regulated.velocity).value_or(regulated.velocity);
}

std::optional<core::VelocityCommand> EscapeRegulator::Find(
    const RegulatorInput& input, const core::VelocityCommand& wanted) {
  if (!input.guard.Check(wanted, input.points).is_limited &&
      !held_.has_value()) {
    return std::nullopt;
  }
  const base::MonotonicTime now = input.pose.stamp;
  const bool holds =
      held_.has_value() &&
      std::chrono::duration<double>(now - held_since_).count() < kEscapeAhead_s;
  if (holds && (input.may_back_up || held_->forward_mps >= 0) &&
      !input.guard.Check(*held_, input.points).is_limited) {
    return held_;
  }
  held_ = Best(input);
  held_since_ = now;
  return held_;
}

// A whole move passes what its first centimetres come nearer to.
bool EscapeRegulator::MayBegin(const RegulatorInput& input,
                               const core::VelocityCommand& command) const {
  const core::VelocityCommand first = LimitedTogether(
      input.start.velocity, command, input.start.interval_s, robot_);
  return !input.guard.Check(command, input.points).is_limited &&
         !input.guard.Check(first, input.points).is_limited;
}

std::optional<core::VelocityCommand> EscapeRegulator::Best(
    const RegulatorInput& input) const {
  const geometry::Vec2 target = TargetOn(input.track);
  std::optional<core::VelocityCommand> best;
  double best_price = PriceOf({}, input, target) - kEscapeGain_rad;
  for (const double speed : kSpeeds_mps) {
    if (speed < 0 && !input.may_back_up) continue;
    for (const double yaw_rate : kYawRates_radps) {
      const core::VelocityCommand command = {.forward_mps = speed,
                                             .yaw_rate_radps = yaw_rate};
      if (speed == 0 && yaw_rate == 0) continue;
      if (!MayBegin(input, command)) continue;
      for (const double ahead_s : kAhead_s) {
        const double price = PriceOf(MotionIn(ahead_s, command), input, target);
        if (price >= best_price) continue;
        best_price = price;
        best = command;
      }
    }
  }
  return best;
}

}  // namespace treeline::control
