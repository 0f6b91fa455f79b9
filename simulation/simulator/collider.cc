#include "simulation/simulator/collider.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace treeline::simulator {
namespace {

// Half of a foot's box, along and across, at most.
constexpr double kFootAlong_m = 0.04;
constexpr double kFootAcross_m = 0.02;
// How far the robot moves before what is near is gathered again.
constexpr double kRoom_m = 0.25;

std::string NameOf(worlds::SurfaceKind kind, bool at_foot) {
  switch (kind) {
    case worlds::SurfaceKind::kWall:
      return "wall";
    case worlds::SurfaceKind::kCeiling:
      return "ceiling";
    case worlds::SurfaceKind::kGlass:
      return "glass";
    case worlds::SurfaceKind::kStair:
      return "stairs";
    case worlds::SurfaceKind::kFloor:
    case worlds::SurfaceKind::kRamp:
      return "step";
    case worlds::SurfaceKind::kOther:
      break;
  }
  return at_foot ? "low obstacle" : "furniture";
}

// Half of what a wheel takes up along the ground, as high above it as a step
// that it climbs: on a slope that rises as high there, a longer foot would hit
// the ground that it stands on.
double FootAlong_m(const core::RobotModel& robot) {
  const double step_m = std::min(robot.max_step_m, robot.wheel_radius_m);
  return std::min(kFootAlong_m,
                  std::sqrt(step_m * (2 * robot.wheel_radius_m - step_m)));
}

}  // namespace

Collider::Collider(const Terrain& terrain, const Stage& stage,
                   const core::RobotModel& robot)
    : terrain_(&terrain), stage_(&stage), robot_(robot) {}

std::vector<OrientedBox> Collider::BoxesAt(const Stance& stance) const {
  std::vector<OrientedBox> boxes;
  boxes.reserve(1 + kFeet);
  boxes.emplace_back(
      stance.WorldFromBase(),
      geometry::Vec3{-robot_.rear_m, -robot_.half_width_m,
                     robot_.ground_clearance_m},
      geometry::Vec3{robot_.front_m, robot_.half_width_m, robot_.height_m});
  const double along_m = FootAlong_m(robot_);
  const double across_m = std::min(kFootAcross_m, along_m);
  const geometry::Rotation3 yaw =
      geometry::Rotation3::FromAxisAngle({0, 0, stance.yaw_rad});
  for (const geometry::Vec3& contact : stance.contacts) {
    boxes.emplace_back(
        geometry::Rigid3{yaw, contact},
        geometry::Vec3{-along_m, -across_m, robot_.max_step_m},
        geometry::Vec3{along_m, across_m, robot_.ground_clearance_m});
  }
  return boxes;
}

std::optional<Contact> Collider::FindFixed(const Stance& stance) {
  if (!near_center_.has_value() ||
      Norm(*near_center_ - stance.position) > kRoom_m) {
    near_center_ = stance.position;
    // Tilting never makes the box reach further than this.
    const double reach_m =
        robot_.Circumradius_m() + robot_.height_m * 0.5 + kRoom_m;
    terrain_->Near(stance.position, reach_m, near_);
  }
  const std::vector<OrientedBox> boxes = BoxesAt(stance);
  for (const uint32_t i : near_) {
    const TerrainQuad& quad = terrain_->quads()[i];
    for (size_t box = 0; box < boxes.size(); ++box) {
      if (!Touch(boxes[box].bounds(), quad.bounds)) continue;
      const auto point = boxes[box].OverlapWith(quad.corners);
      if (!point.has_value()) continue;
      return Contact{.point_in_world = *point,
                     .what = NameOf(quad.kind, box > 0)};
    }
  }
  return std::nullopt;
}

std::optional<Contact> Collider::FindMoving(const Stance& stance,
                                            std::span<const Actor> actors,
                                            size_t first) const {
  // Made when the first actor is near enough.
  std::vector<OrientedBox> boxes;
  for (size_t i = first; i < actors.size(); ++i) {
    const worlds::BodyInstance& instance = actors[i].instance;
    const worlds::Float3 at = instance.world_from_body.origin;
    const double reach_m = robot_.Circumradius_m() + robot_.height_m * 0.5 +
                           stage_->RadiusOf_m(instance);
    if (Norm(geometry::Vec2{at.x, at.y} - stance.position) > reach_m) continue;
    if (boxes.empty()) boxes = BoxesAt(stance);
    for (const QuadCorners& quad : stage_->QuadsOf(instance)) {
      const Bounds bounds = BoundsOf(quad);
      for (const OrientedBox& box : boxes) {
        if (!Touch(box.bounds(), bounds)) continue;
        const auto point = box.OverlapWith(quad);
        if (!point.has_value()) continue;
        return Contact{.point_in_world = *point,
                       .what = actors[i].name,
                       .actor = static_cast<int>(i)};
      }
    }
  }
  return std::nullopt;
}

}  // namespace treeline::simulator
