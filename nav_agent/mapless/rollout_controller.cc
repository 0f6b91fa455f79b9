#include "nav_agent/mapless/rollout_controller.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "nav_agent/mapless/dead_reckoning.h"
#include "nav_agent/mapless/parameters.h"

namespace treeline::mapless {
namespace {

constexpr double kStep_s = 0.1;
// Of a command of somebody else, tried out in this order.
constexpr double kAllowedShares[] = {1, 0.75, 0.5, 0.25, 0.1};
// Shares of the fastest that are tried, forward and of the curve.
constexpr double kSpeeds[] = {0, 0.05, 0.12, 0.25, 0.4, 0.55, 0.75, 1};
// Of the fastest backwards, to give way.
constexpr double kBackwardShares[] = {0.3, 0.6, 1};
constexpr double kCurves[] = {-1,  -0.65, -0.4, -0.22, -0.1, 0,
                              0.1, 0.22,  0.4,  0.65,  1};
constexpr double kLaterCurves[] = {-0.8, -0.35, -0.12, 0, 0.12, 0.35, 0.8};
// Room beyond which it does not matter.
constexpr double kWantedRoom_m = 0.25;
// Of a metre that is driven faster than the room allows, and of a change of the
// curve by one rad/s.
constexpr double kHasteCost = 3;
constexpr double kCurveChangeCost_m = 0.01;
// As much of a threat is allowed to somebody else's command, a twentieth of a
// second of touching (m).
constexpr double kAllowedThreat_m = kTouchCost_mps / 20;
constexpr double kBackOff_mps = 0.25;

double Toward(double value, double target, double step) {
  return value < target ? std::min(target, value + step)
                        : std::max(target, value - step);
}

}  // namespace

RolloutController::RolloutController(const core::RobotModel& robot,
                                     const BodyShape& body,
                                     const RolloutLimits& limits)
    : robot_(robot), body_(body), limits_(limits) {}

void RolloutController::Advance(RobotMotion& motion, double forward_mps,
                                double yaw_rate_radps, double dt_s) const {
  const bool brakes = std::abs(forward_mps) < std::abs(motion.forward_mps) ||
                      forward_mps * motion.forward_mps < 0;
  const double old_mps = motion.forward_mps;
  const double old_radps = motion.yaw_rate_radps;
  motion.forward_mps = Toward(old_mps, forward_mps,
                              dt_s * (brakes ? robot_.max_deceleration_mps2
                                             : robot_.max_acceleration_mps2));
  motion.yaw_rate_radps = Toward(old_radps, yaw_rate_radps,
                                 dt_s * robot_.max_yaw_acceleration_radps2);
  motion.map_from_base =
      MovedOn(motion.map_from_base, 0.5 * (old_mps + motion.forward_mps),
              0.5 * (old_radps + motion.yaw_rate_radps), dt_s);
}

double RolloutController::ThreatAt_mps(const geometry::Rigid2& map_from_base,
                                       const std::vector<Mover>& movers,
                                       double time_s) const {
  double threat_mps = 0;
  for (const Mover& mover : movers) {
    threat_mps += ThreatRate_mps(
        body_.DistanceTo_m(map_from_base, mover.After(time_s)) - mover.radius_m,
        time_s);
  }
  return threat_mps;
}

std::optional<RolloutController::Outcome> RolloutController::TryOut(
    const RobotMotion& motion, const Choice& choice,
    const Surroundings& around) const {
  RobotMotion at = motion;
  // A body that stands too near already may move to where there is more room.
  const double begin_m = std::min(
      0.0, body_.RoomAt_m(around.clearance, at.map_from_base, kWantedRoom_m));
  Outcome outcome;
  outcome.min_room_m = kWantedRoom_m;
  for (double time_s = 0; time_s < kHorizon_s; time_s += kStep_s) {
    Advance(at, choice.first.forward_mps,
            time_s < kFirstPart_s ? choice.first.yaw_rate_radps
                                  : choice.later_yaw_rate_radps,
            kStep_s);
    const double room_m =
        body_.RoomAt_m(around.clearance, at.map_from_base, kWantedRoom_m);
    if (room_m < begin_m) return std::nullopt;
    outcome.min_room_m = std::min(outcome.min_room_m, room_m);
    const double allowed_mps =
        kSlowest_mps + kSpeedOfRoom_ps * std::max(0.0, room_m);
    outcome.haste_m +=
        kStep_s * std::max(0.0, std::abs(at.forward_mps) - allowed_mps);
    if (!around.movers.empty()) {
      // Backwards it does not see who comes.
      outcome.threat_m +=
          kStep_s *
          (ThreatAt_mps(at.map_from_base, around.movers, time_s + kStep_s) +
           kBlindCost * std::max(0.0, -at.forward_mps));
    }
  }
  outcome.end = at.map_from_base;
  while (std::abs(at.forward_mps) > 0.05) {
    Advance(at, 0, at.yaw_rate_radps, kStep_s);
    if (body_.RoomAt_m(around.clearance, at.map_from_base, kWantedRoom_m) <
        begin_m)
      return std::nullopt;
  }
  return outcome;
}

bool RolloutController::IsAllowed(const RobotMotion& motion,
                                  const Choice& choice,
                                  const Surroundings& around) const {
  const std::optional<Outcome> outcome = TryOut(motion, choice, around);
  return outcome.has_value() && outcome->threat_m < kAllowedThreat_m;
}

double RolloutController::CostOf(const Outcome& outcome, const Choice& choice,
                                 const WayField& way,
                                 const TimedWay& timed) const {
  const double to_go_m = way.ToGo(outcome.end.translation);
  // Not beyond the goal, or it would stand before it.
  const geometry::Vec2 ahead =
      outcome.end * geometry::Vec2{std::min(kAhead_m.value, to_go_m), 0};
  // Ahead may lie in an obstacle: that is a reason against, not a proof.
  const double ahead_m = std::min(way.ToGo(ahead), to_go_m + kAhead_m * 4);
  double cost_m = 0.5 * (to_go_m + ahead_m) + kHasteCost * outcome.haste_m;
  if (!timed.empty() && to_go_m < WayField::kNoWay) {
    // The way on is that among what is foretold; the heading counts as before.
    cost_m += timed.ToGo(outcome.end.translation, kHorizon_s) - to_go_m +
              outcome.threat_m;
  }
  if (last_.has_value()) {
    cost_m += kCurveChangeCost_m * std::abs(choice.first.yaw_rate_radps -
                                            last_->first.yaw_rate_radps);
  }
  return cost_m;
}

std::optional<core::VelocityCommand> RolloutController::Best(
    const RobotMotion& motion, const Surroundings& around, const WayField& way,
    const TimedWay& timed) {
  double best_m = std::numeric_limits<double>::infinity();
  std::optional<Choice> best;
  const auto consider = [&](const Choice& choice) {
    const std::optional<Outcome> outcome = TryOut(motion, choice, around);
    if (!outcome.has_value()) return;
    const double cost_m = CostOf(*outcome, choice, way, timed);
    if (cost_m < best_m) {
      best_m = cost_m;
      best = choice;
    }
  };
  if (last_.has_value()) consider(*last_);
  std::vector<double> speeds_mps;
  for (const double speed : kSpeeds) {
    speeds_mps.push_back(speed * limits_.max_forward_mps);
  }
  if (!timed.empty()) {
    for (const double share : kBackwardShares) {
      speeds_mps.push_back(-share * robot_.max_backward_mps);
    }
  }
  for (const double speed_mps : speeds_mps) {
    for (const double curve : kCurves) {
      for (const double later : kLaterCurves) {
        consider(
            {.first = {.forward_mps = speed_mps,
                       .yaw_rate_radps = curve * limits_.max_yaw_rate_radps},
             .later_yaw_rate_radps = later * limits_.max_yaw_rate_radps});
      }
    }
  }
  last_ = best;
  if (!best.has_value()) return std::nullopt;
  return best->first;
}

core::VelocityCommand RolloutController::BackOff(const RobotMotion& motion,
                                                 const Surroundings& around) {
  last_.reset();
  double best_m = -std::numeric_limits<double>::infinity();
  core::VelocityCommand best;
  for (const double forward_mps :
       {-std::min(kBackOff_mps, robot_.max_backward_mps), 0.0}) {
    for (const double curve : kCurves) {
      const Choice choice = {
          .first = {.forward_mps = forward_mps,
                    .yaw_rate_radps = 0.5 * curve * limits_.max_yaw_rate_radps},
          .later_yaw_rate_radps = 0};
      const std::optional<Outcome> outcome = TryOut(motion, choice, around);
      if (!outcome.has_value()) continue;
      // Standing is no way out.
      const double gain_m =
          body_.RoomAt_m(around.clearance, outcome->end, kWantedRoom_m) +
          (forward_mps < 0 ? 0.1 : 0) - outcome->threat_m;
      if (gain_m > best_m) {
        best_m = gain_m;
        best = choice.first;
      }
    }
  }
  return best;
}

core::VelocityCommand RolloutController::Turn(const RobotMotion& motion,
                                              const Surroundings& around,
                                              double by_rad) const {
  const double fastest_radps = std::min(1.0, limits_.max_yaw_rate_radps);
  const Choice choice = {
      .first = {.forward_mps = 0,
                .yaw_rate_radps =
                    std::clamp(2 * by_rad, -fastest_radps, fastest_radps)},
      .later_yaw_rate_radps = 0};
  return IsAllowed(motion, choice, around) ? choice.first
                                           : core::VelocityCommand();
}

core::VelocityCommand RolloutController::Allow(
    const RobotMotion& motion, const Surroundings& around,
    const core::VelocityCommand& wanted) const {
  const double forward_mps = std::clamp(
      wanted.forward_mps, -limits_.max_forward_mps, limits_.max_forward_mps);
  const double yaw_rate_radps =
      std::clamp(wanted.yaw_rate_radps, -limits_.max_yaw_rate_radps,
                 limits_.max_yaw_rate_radps);
  for (const double share : kAllowedShares) {
    const Choice choice = {.first = {.forward_mps = share * forward_mps,
                                     .yaw_rate_radps = share * yaw_rate_radps},
                           .later_yaw_rate_radps = share * yaw_rate_radps};
    if (IsAllowed(motion, choice, around)) return choice.first;
  }
  return {};
}

}  // namespace treeline::mapless
