#include "nav_agent/control/collision_guard.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "absl/strings/str_cat.h"

namespace treeline::control {

absl::Status CollisionGuardOptions::Validate() const {
  if (!(point_margin_m >= 0 && cell_margin_m >= 0 && margin_per_speed_s >= 0 &&
        reaction_s >= 0 && approach_mps >= 0 && moving_margin_m >= 0)) {
    return absl::InvalidArgumentError(
        "the collision guard's margins, times and speeds must not be negative");
  }
  if (!(braking_share > 0 && braking_share <= 1)) {
    return absl::InvalidArgumentError(
        absl::StrCat("braking_share must be in (0, 1], not ", braking_share));
  }
  return absl::OkStatus();
}

CollisionGuard::CollisionGuard(const core::RobotModel& robot,
                               const CollisionGuardOptions& options)
    : robot_(robot),
      options_(options),
      footprint_(Footprint::Of(robot)),
      max_looks_(std::max(
          2, LooksAt(std::max(robot.max_forward_mps, robot.max_backward_mps),
                     robot.max_yaw_rate_radps))) {}

// Both brake together along the arc, as long as the slower one takes.
double CollisionGuard::StopTime_s(double forward_mps,
                                  double yaw_rate_radps) const {
  const double brake = options_.braking_share * robot_.max_deceleration_mps2;
  const double yaw_brake =
      kYawBrakingShare * robot_.max_yaw_acceleration_radps2;
  return std::max(std::abs(forward_mps) / brake,
                  std::abs(yaw_rate_radps) / yaw_brake);
}

int CollisionGuard::LooksAt(double forward_mps, double yaw_rate_radps) const {
  const double edge_mps =
      std::abs(forward_mps) +
      std::abs(yaw_rate_radps) * footprint_.Circumradius_m();
  const double total_s =
      options_.reaction_s + StopTime_s(forward_mps, yaw_rate_radps);
  // A command of any size may be asked about.
  constexpr double kCountable = 1e6;
  return static_cast<int>(
      std::ceil(std::min(kCountable, edge_mps * total_s / kSweepStep_m)));
}

double CollisionGuard::Reach_m() const {
  const double v = std::max(robot_.max_forward_mps, robot_.max_backward_mps);
  const double brake = options_.braking_share * robot_.max_deceleration_mps2;
  const double stop_s = options_.reaction_s + v / brake;
  return footprint_.Circumradius_m() + v * options_.reaction_s +
         v * v / (2 * brake) + options_.approach_mps * stop_s +
         v * options_.margin_per_speed_s +
         std::max({options_.point_margin_m, options_.cell_margin_m,
                   options_.body_margin_m});
}

const GuardPoint* CollisionGuard::FirstHit(
    const core::VelocityCommand& command, std::span<const GuardPoint> points,
    std::span<const double> now_m) const {
  const double v = command.forward_mps;
  const double w = command.yaw_rate_radps;
  const double stop_s = StopTime_s(v, w);
  const double total_s = options_.reaction_s + stop_s;
  // No more than for the fastest that the robot can do.
  const int looks = std::clamp(LooksAt(v, w), 2, max_looks_);
  const double extra_m = options_.margin_per_speed_s * std::abs(v);
  geometry::Vec2 at;
  double yaw_rad = 0;
  const double step_s = total_s / looks;
  for (int look = 1; look <= looks; ++look) {
    const double time_s = look * step_s;
    const double middle_s = time_s - 0.5 * step_s;
    const double share =
        middle_s <= options_.reaction_s || stop_s <= 0
            ? 1.0
            : std::max(0.0, 1 - (middle_s - options_.reaction_s) / stop_s);
    const double turn_rad = share * w * step_s;
    const double way_m = share * v * step_s;
    at = at + way_m * geometry::Vec2{std::cos(yaw_rad + 0.5 * turn_rad),
                                     std::sin(yaw_rad + 0.5 * turn_rad)};
    yaw_rad += turn_rad;
    const double c = std::cos(yaw_rad);
    const double s = std::sin(yaw_rad);
    for (size_t i = 0; i < points.size(); ++i) {
      const GuardPoint& point = points[i];
      const geometry::Vec2 off = point.in_base - at;
      const geometry::Vec2 in_base = {c * off.x + s * off.y,
                                      -s * off.x + c * off.y};
      const double distance_m = footprint_.DistanceTo_m(in_base);
      const double needed_m =
          point.margin_m + extra_m + point.approach_mps * time_s;
      if (distance_m >= needed_m) continue;
      const bool is_hit =
          point.is_of_body
              ? footprint_.OutwardSpeed_mps({share * v, share * w}, in_base,
                                            needed_m) > options_.outward_mps
              : distance_m < now_m[i] - kGuardSlack_m;
      if (is_hit) return &point;
    }
  }
  return nullptr;
}

GuardVerdict CollisionGuard::Check(const core::VelocityCommand& wanted,
                                   std::span<const GuardPoint> points) const {
  GuardVerdict verdict;
  if (!std::isfinite(wanted.forward_mps) ||
      !std::isfinite(wanted.yaw_rate_radps)) {
    verdict.is_limited = true;
    return verdict;
  }
  if (wanted.forward_mps == 0 && wanted.yaw_rate_radps == 0) return verdict;
  std::vector<double> now_m(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    now_m[i] = footprint_.DistanceTo_m(points[i].in_base);
  }
  for (const double share : kGuardShares.value) {
    const core::VelocityCommand command = {
        .forward_mps = share * wanted.forward_mps,
        .yaw_rate_radps = share * wanted.yaw_rate_radps};
    // What is left of a command is no motion any more.
    if (verdict.is_limited && std::abs(command.forward_mps) < kMinSpeed_mps &&
        std::abs(command.yaw_rate_radps) < kMinTurn_radps) {
      break;
    }
    const GuardPoint* hit = FirstHit(command, points, now_m);
    if (hit == nullptr) {
      verdict.command = command;
      return verdict;
    }
    if (!verdict.is_limited) {
      verdict.point_in_base = hit->in_base;
      verdict.point_moves = hit->approach_mps > 0;
    }
    verdict.is_limited = true;
  }
  return verdict;
}

}  // namespace treeline::control
