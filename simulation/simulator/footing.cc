#include "simulation/simulator/footing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace treeline::simulator {
namespace {

// Stairs at most this far below make a lost foot one that enters stairs.
constexpr double kStairsBelow_m = 0.6;
constexpr double kSearch_m = 1000;
// A robot that is put down on a slope tilts until nothing changes.
constexpr int kPutDownRounds = 8;

size_t Index(int i) { return static_cast<size_t>(i); }

// Casters before and behind the axle. A body that reaches further to one side
// is carried there, too.
double FrontCaster_m(const core::RobotModel& robot) {
  return robot.caster_m + std::max(0.0, robot.front_m - robot.rear_m);
}
double RearCaster_m(const core::RobotModel& robot) {
  return robot.caster_m + std::max(0.0, robot.rear_m - robot.front_m);
}

}  // namespace

geometry::Rigid3 Stance::WorldFromBase() const {
  const geometry::Rotation3 rotation =
      geometry::Rotation3::FromAxisAngle({0, 0, yaw_rad}) *
      geometry::Rotation3::FromAxisAngle({0, pitch_rad, 0}) *
      geometry::Rotation3::FromAxisAngle({roll_rad, 0, 0});
  return {rotation, {position.x, position.y, height_m}};
}

double Stance::Tilt_rad() const {
  return std::acos(std::cos(pitch_rad) * std::cos(roll_rad));
}

Footing::Footing(const Terrain& terrain, const core::RobotModel& robot)
    : terrain_(&terrain),
      feet_in_base_{geometry::Vec2{0, robot.wheel_track_m / 2},
                    geometry::Vec2{0, -robot.wheel_track_m / 2},
                    geometry::Vec2{FrontCaster_m(robot), 0},
                    geometry::Vec2{-RearCaster_m(robot), 0}},
      max_step_m_(robot.max_step_m) {}

geometry::Vec2 Footing::FootAt(int foot, const Stance& tilted,
                               geometry::Vec2 position, double yaw_rad) const {
  // Rz Ry Rx of a point (x, y, 0), as seen from above.
  const geometry::Vec2 in_base = feet_in_base_[Index(foot)];
  const geometry::Vec2 level = {
      in_base.x * std::cos(tilted.pitch_rad) +
          in_base.y * std::sin(tilted.pitch_rad) * std::sin(tilted.roll_rad),
      in_base.y * std::cos(tilted.roll_rad)};
  return geometry::Rigid2{position, yaw_rad} * level;
}

bool Footing::IsAboveStairs(geometry::Vec3 at) const {
  const auto below =
      terrain_->GroundAt({at.x, at.y}, at.z - kStairsBelow_m, at.z);
  return below.has_value() && below->kind == worlds::SurfaceKind::kStair;
}

void Footing::Settle(Stance& stance) const {
  const auto slope = [&](int from, int to) {
    const geometry::Vec3 way =
        stance.contacts[Index(to)] - stance.contacts[Index(from)];
    return way.z / std::hypot(way.x, way.y);
  };
  stance.pitch_rad = std::atan(slope(kFrontCaster, kRearCaster));
  // In the world, the axle's direction is (sin r sin p, cos r, sin r cos p) but
  // for yaw, and its slope s that of z against the way seen from above.
  const double s = slope(kRightWheel, kLeftWheel);
  const double cos_pitch = std::cos(stance.pitch_rad);
  const double sin_pitch = std::sin(stance.pitch_rad);
  stance.roll_rad = std::atan2(
      s, std::sqrt(std::max(
             1e-9, cos_pitch * cos_pitch - s * s * sin_pitch * sin_pitch)));
  stance.height_m =
      0.5 * (stance.contacts[kLeftWheel].z + stance.contacts[kRightWheel].z);
}

Footing::Step Footing::Follow(const Stance& before, geometry::Vec2 position,
                              double yaw_rad) const {
  Stance stance = before;
  stance.position = position;
  stance.yaw_rad = yaw_rad;
  for (int foot = 0; foot < kFeet; ++foot) {
    const geometry::Vec2 at = FootAt(foot, before, position, yaw_rad);
    const double height_m = before.contacts[Index(foot)].z;
    const auto ground =
        terrain_->GroundAt(at, height_m - max_step_m_, height_m + max_step_m_);
    const geometry::Vec3 contact = {at.x, at.y, height_m};
    if (!ground.has_value()) {
      return {.stance = std::nullopt,
              .lost_at = contact,
              .above_stairs = IsAboveStairs(contact)};
    }
    stance.contacts[Index(foot)] = {at.x, at.y, ground->height_m};
  }
  Settle(stance);
  return {.stance = stance};
}

std::optional<double> Footing::NearestGround_m(geometry::Vec2 at,
                                               double height_m) const {
  std::optional<double> nearest;
  double highest_m = kSearch_m;
  // From the top down, from ground to ground.
  while (const auto ground = terrain_->GroundAt(at, -kSearch_m, highest_m)) {
    if (!nearest.has_value() ||
        std::abs(ground->height_m - height_m) < std::abs(*nearest - height_m)) {
      nearest = ground->height_m;
    }
    highest_m = ground->height_m - 1e-3;
  }
  return nearest;
}

std::optional<Stance> Footing::PutDown(geometry::Vec2 position, double yaw_rad,
                                       double height_m) const {
  const auto center_m = NearestGround_m(position, height_m);
  if (!center_m.has_value()) return std::nullopt;
  Stance stance = {.position = position, .yaw_rad = yaw_rad};
  stance.height_m = *center_m;
  for (int round = 0; round < kPutDownRounds; ++round) {
    for (int foot = 0; foot < kFeet; ++foot) {
      const geometry::Vec2 at = FootAt(foot, stance, position, yaw_rad);
      // Steeper than 45 degrees nobody stands.
      const double reach_m = Norm(at - position);
      const auto ground =
          terrain_->GroundAt(at, *center_m - reach_m, *center_m + reach_m);
      if (!ground.has_value()) return std::nullopt;
      stance.contacts[Index(foot)] = {at.x, at.y, ground->height_m};
    }
    Settle(stance);
  }
  return stance;
}

}  // namespace treeline::simulator
