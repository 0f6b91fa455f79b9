#include "simulation/simulator/robot_body.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "absl/strings/str_cat.h"

namespace treeline::simulator {
namespace {

// A contact that was there so short a time ago, and so near, goes on.
constexpr double kSameContact_s = 1.0;
constexpr double kSameContact_m = 0.3;
constexpr double kCausing_mps = 0.01;

double SincHalf(double angle_rad) {
  const double half = 0.5 * angle_rad;
  return std::abs(half) < 1e-6 ? 1 - half * half / 6 : std::sin(half) / half;
}

// v turned by an angle about a unit axis (Rodrigues), v at right angles to it.
geometry::Vec3 Turned(geometry::Vec3 v, geometry::Vec3 axis, double angle_rad) {
  return std::cos(angle_rad) * v + std::sin(angle_rad) * Cross(axis, v);
}

}  // namespace

RobotBody::RobotBody(const Terrain& terrain, const Stage& stage,
                     const core::RobotModel& robot,
                     const WheelOdometryErrors& errors, uint64_t seed)
    : stage_(&stage),
      robot_(robot),
      footing_(terrain, robot),
      collider_(terrain, stage, robot),
      drive_(robot, errors, seed) {}

absl::Status RobotBody::PutDown(geometry::Vec2 position, double yaw_rad,
                                double height_m, SimTime now) {
  const std::string place =
      absl::StrCat("at ", position.x, ", ", position.y, " near z = ", height_m);
  const auto stance = footing_.PutDown(position, yaw_rad, height_m);
  if (!stance.has_value()) {
    return absl::NotFoundError(
        absl::StrCat("no ground for the robot to stand on ", place));
  }
  if (stance->Tilt_rad() > robot_.max_slope_rad) {
    return absl::FailedPreconditionError(
        absl::StrCat("too steep for the robot to stand ", place));
  }
  auto contact = collider_.FindFixed(*stance);
  if (!contact.has_value()) {
    contact = collider_.FindMoving(*stance, stage_->ActorsAt(Seconds(now)));
  }
  if (contact.has_value()) {
    return absl::FailedPreconditionError(
        absl::StrCat("no room for the robot ", place, ": ", contact->what,
                     " is in the way"));
  }
  stance_ = *stance;
  drive_.Block();
  is_fallen_ = false;
  is_blocked_ = false;
  is_steep_ = false;
  forward_mps_ = 0;
  yaw_rate_radps_ = 0;
  touches_.clear();
  return absl::OkStatus();
}

RobotBody::Proposal RobotBody::Moved(const PlanarMotion& motion) const {
  // Exact for arcs in the plane that the robot stands in: the chord lies half
  // a turn off the old heading.
  const geometry::Rotation3 rotation = stance_.WorldFromBase().rotation;
  const geometry::Vec3 forward = rotation * geometry::Vec3{1, 0, 0};
  const geometry::Vec3 up = rotation * geometry::Vec3{0, 0, 1};
  const geometry::Vec3 chord = motion.forward_m * SincHalf(motion.turn_rad) *
                               Turned(forward, up, 0.5 * motion.turn_rad);
  const geometry::Vec3 heading = Turned(forward, up, motion.turn_rad);
  return {.position = stance_.position + geometry::Vec2{chord.x, chord.y},
          .yaw_rad = motion.turn_rad == 0 ? stance_.yaw_rad
                                          : std::atan2(heading.y, heading.x)};
}

void RobotBody::Fall(SimEventKind kind, geometry::Vec3 at, SimTime now,
                     std::vector<SimEvent>& events) {
  is_fallen_ = true;
  drive_.Block();
  forward_mps_ = 0;
  yaw_rate_radps_ = 0;
  events.push_back({.kind = kind,
                    .time = now,
                    .point_in_world = at,
                    .world_from_base = stance_.WorldFromBase(),
                    .what = SimEventName(kind),
                    .caused_by_robot = true});
}

void RobotBody::WatchSlope(SimTime now, std::vector<SimEvent>& events) {
  const double tilt_rad = stance_.Tilt_rad();
  if (tilt_rad > kTippingFactor * robot_.max_slope_rad) {
    const geometry::Vec3 at = stance_.WorldFromBase().translation;
    Fall(SimEventKind::kTipped, at, now, events);
    return;
  }
  const bool is_steep = tilt_rad > robot_.max_slope_rad;
  if (is_steep && !is_steep_) {
    const geometry::Rigid3 world_from_base = stance_.WorldFromBase();
    events.push_back({.kind = SimEventKind::kSteep,
                      .time = now,
                      .point_in_world = world_from_base.translation,
                      .world_from_base = world_from_base,
                      .what = "ground",
                      .caused_by_robot = true});
  }
  is_steep_ = is_steep;
}

double RobotBody::ApproachOfBody_mps(const Contact& contact,
                                     const std::vector<Actor>& actors,
                                     SimTime now,
                                     geometry::Vec2 outward) const {
  const double step_s = DifferentialDrive::kStep_s;
  const Actor& actor = actors[static_cast<size_t>(contact.actor)];
  for (const Actor& before : stage_->ActorsAt(Seconds(now) - step_s)) {
    if (before.name != actor.name) continue;
    // The point of the body that touches, where it was a step ago.
    const worlds::Placement& then = before.instance.world_from_body;
    const worlds::Placement& at = actor.instance.world_from_body;
    const geometry::Vec2 arm = {contact.point_in_world.x - at.origin.x,
                                contact.point_in_world.y - at.origin.y};
    const double turn_rad = geometry::NormalizedAngle_rad(
        static_cast<double>(at.yaw_rad - then.yaw_rad));
    const geometry::Vec2 velocity =
        (1 / step_s) *
        (geometry::Vec2{at.origin.x - then.origin.x - turn_rad * arm.y,
                        at.origin.y - then.origin.y + turn_rad * arm.x});
    return -Dot(velocity, outward);
  }
  return 0;
}

bool RobotBody::IsKnown(const Contact& contact, SimTime now) {
  std::erase_if(touches_, [&](const Touch& touch) {
    return Seconds(now - touch.last) > kSameContact_s;
  });
  for (Touch& touch : touches_) {
    const bool is_same =
        touch.actor >= 0 || contact.actor >= 0
            ? touch.actor >= 0 && contact.actor >= 0 &&
                  touch.what == contact.what
            : Norm(touch.point - contact.point_in_world) < kSameContact_m;
    if (!is_same) continue;
    touch.last = now;
    touch.point = contact.point_in_world;
    return true;
  }
  touches_.push_back(
      {contact.what, contact.actor, contact.point_in_world, now});
  return false;
}

geometry::Vec2 RobotBody::OutwardAt(geometry::Vec2 arm_in_world) const {
  const geometry::Vec2 at =
      geometry::Rigid2{{}, -stance_.yaw_rad} * arm_in_world;
  const std::pair<double, geometry::Vec2> faces[] = {
      {robot_.front_m - at.x, {1, 0}},
      {robot_.rear_m + at.x, {-1, 0}},
      {robot_.half_width_m - at.y, {0, 1}},
      {robot_.half_width_m + at.y, {0, -1}}};
  const auto* nearest = std::ranges::min_element(
      faces, {}, [](const auto& face) { return face.first; });
  return geometry::Rigid2{{}, stance_.yaw_rad} * nearest->second;
}

bool RobotBody::Meet(const Contact& contact, const PlanarMotion& motion,
                     const std::vector<Actor>& actors, SimTime now,
                     std::vector<SimEvent>& events) {
  const geometry::Vec2 arm =
      geometry::Vec2{contact.point_in_world.x, contact.point_in_world.y} -
      stance_.position;
  const geometry::Vec2 outward = OutwardAt(arm);
  const geometry::Vec2 heading = {std::cos(stance_.yaw_rad),
                                  std::sin(stance_.yaw_rad)};
  const geometry::Vec2 moved = motion.forward_m * heading +
                               motion.turn_rad * geometry::Vec2{-arm.y, arm.x};
  const double robot_mps = Dot(moved, outward) / DifferentialDrive::kStep_s;
  const bool is_fixed = contact.actor < 0;
  const double body_mps =
      is_fixed ? 0 : ApproachOfBody_mps(contact, actors, now, outward);
  if (!IsKnown(contact, now)) {
    events.push_back({.kind = SimEventKind::kCollision,
                      .time = now,
                      .point_in_world = contact.point_in_world,
                      .world_from_base = stance_.WorldFromBase(),
                      .what = contact.what,
                      .caused_by_robot = is_fixed || robot_mps > kCausing_mps,
                      .robot_approach_mps = robot_mps,
                      .body_approach_mps = body_mps});
  }
  return is_fixed || robot_mps > 0;
}

bool RobotBody::IsStopped(const Stance& next, const PlanarMotion& motion,
                          const std::vector<Actor>& actors, SimTime now,
                          std::vector<SimEvent>& events) {
  bool is_stopped = false;
  const bool moves = motion.forward_m != 0 || motion.turn_rad != 0;
  if (moves) {
    if (const auto contact = collider_.FindFixed(next); contact.has_value()) {
      is_stopped = Meet(*contact, motion, actors, now, events);
    }
  }
  size_t first = 0;
  while (const auto contact = collider_.FindMoving(next, actors, first)) {
    if (Meet(*contact, motion, actors, now, events)) is_stopped = true;
    first = static_cast<size_t>(contact->actor) + 1;
  }
  return is_stopped && moves;
}

void RobotBody::Step(const core::VelocityCommand& command,
                     const WheelFaults& faults, int64_t step, SimTime now,
                     std::vector<SimEvent>& events) {
  if (is_fallen_) return;
  const PlanarMotion motion = drive_.Advance(command, stance_.pitch_rad,
                                             stance_.Tilt_rad(), faults, step);
  const bool moves = motion.forward_m != 0 || motion.turn_rad != 0;
  const std::vector<Actor> actors = stage_->ActorsAt(Seconds(now));
  if (!moves && actors.empty()) {
    is_blocked_ = false;
    forward_mps_ = 0;
    yaw_rate_radps_ = 0;
    return;
  }
  const Proposal proposal = Moved(motion);
  const Footing::Step next =
      moves ? footing_.Follow(stance_, proposal.position, proposal.yaw_rad)
            : Footing::Step{.stance = stance_};
  // A step that is too high is something to run into; only without any ground
  // there is it a fall.
  Stance bumped = next.stance.value_or(stance_);
  if (!next.stance.has_value()) {
    bumped.position = proposal.position;
    bumped.yaw_rad = proposal.yaw_rad;
    for (geometry::Vec3& contact : bumped.contacts) {
      contact.x += proposal.position.x - stance_.position.x;
      contact.y += proposal.position.y - stance_.position.y;
    }
  }
  is_blocked_ = IsStopped(bumped, motion, actors, now, events);
  if (is_blocked_) {
    drive_.Block();
    forward_mps_ = 0;
    yaw_rate_radps_ = 0;
    return;
  }
  if (!next.stance.has_value()) {
    Fall(next.above_stairs ? SimEventKind::kStairs : SimEventKind::kFall,
         next.lost_at, now, events);
    return;
  }
  stance_ = *next.stance;
  drive_.Commit();
  distance_m_ += std::abs(motion.forward_m);
  turned_rad_ += std::abs(motion.turn_rad);
  forward_mps_ = motion.forward_m / DifferentialDrive::kStep_s;
  yaw_rate_radps_ = motion.turn_rad / DifferentialDrive::kStep_s;
  WatchSlope(now, events);
}

}  // namespace treeline::simulator
