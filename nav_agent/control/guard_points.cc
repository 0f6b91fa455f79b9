#include "nav_agent/control/guard_points.h"

#include <chrono>

#include "nav_agent/control/obstacle_parameters.h"

namespace treeline::control {
namespace {

double MarginOf_m(const ObservedPoint& point, bool knows_movers,
                  const CollisionGuardOptions& options) {
  if (point.is_moving) {
    return knows_movers ? options.body_margin_m : options.moving_margin_m;
  }
  return point.is_new ? options.new_margin_m : options.point_margin_m;
}

// Those of one sensor, beam after beam.
void AddSeen(const geometry::Rigid2& base_from_map,
             std::span<const ObservedPoint> seen, bool knows_movers,
             const CollisionGuard& guard, const CloseApproach* approach,
             std::vector<GuardPoint>& points) {
  const double reach_m = guard.Reach_m();
  const CollisionGuardOptions& options = guard.options();
  geometry::Vec2 last = {1e9, 1e9};
  for (const ObservedPoint& point : seen) {
    const geometry::Vec2 in_base = base_from_map * point.in_map;
    // Neighbouring beams that end side by side say the same.
    if (geometry::Norm(in_base) > reach_m ||
        geometry::Norm(in_base - last) < kSameBeam_m)
      continue;
    last = in_base;
    if (approach != nullptr &&
        approach->IsOfThing(point.in_map, guard.footprint())) {
      points.push_back({.in_base = in_base});
      continue;
    }
    points.push_back(
        {.in_base = in_base,
         .margin_m = MarginOf_m(point, knows_movers, options),
         .approach_mps = point.is_moving ? options.approach_mps : 0,
         .is_of_body = point.is_moving && knows_movers});
  }
}

}  // namespace

std::vector<GuardPoint> GuardPointsOf(const ControlPose& pose,
                                      const LocalCostmap& costmap,
                                      std::span<const DynamicObstacle> movers,
                                      const CollisionGuard& guard,
                                      const CloseApproach* approach) {
  const geometry::Rigid2 base_from_map = pose.pose.map_from_base.Inverse();
  const double reach_m = guard.Reach_m();
  const CollisionGuardOptions& options = guard.options();
  // Walls seem to move to a robot that turns and does not know the map.
  const bool knows_movers = !pose.map_is_unknown;
  std::vector<GuardPoint> points;
  const auto add_seen = [&](std::span<const ObservedPoint> seen) {
    AddSeen(base_from_map, seen, knows_movers, guard, approach, points);
  };
  add_seen(costmap.scan_points(core::LaserMount::kFront));
  add_seen(costmap.scan_points(core::LaserMount::kRear));
  if (costmap.last_depth().has_value() &&
      std::chrono::duration<double>(pose.stamp - *costmap.last_depth())
              .count() < kDepthLifetime_s) {
    add_seen(costmap.depth_points());
  }
  for (const RememberedObstacle& unseen : costmap.UnseenObstacles(
           pose.pose.map_from_base.translation, reach_m, pose.stamp)) {
    if (approach != nullptr &&
        approach->IsOfThing(unseen.in_map, guard.footprint())) {
      continue;
    }
    points.push_back({.in_base = base_from_map * unseen.in_map,
                      .margin_m = unseen.is_new ? options.new_margin_m
                                                : options.cell_margin_m});
  }
  for (const core::LevelPose& supposed : pose.supposed) {
    const geometry::Rigid2 base_from_supposed =
        supposed.map_from_base.Inverse();
    for (const geometry::Vec2& in_map :
         costmap.MapObstacles(supposed, reach_m)) {
      points.push_back({.in_base = base_from_supposed * in_map,
                        .margin_m = options.cell_margin_m});
    }
  }
  // Somebody who went out of sight behind the robot is still about.
  for (const DynamicObstacle& mover : movers) {
    if (mover.unseen_s == 0) continue;
    const geometry::Vec2 in_base = base_from_map * mover.in_map;
    if (geometry::Norm(in_base) > reach_m + mover.position_uncertainty_m)
      continue;
    points.push_back(
        {.in_base = in_base,
         .margin_m = options.lost_margin_m + mover.position_uncertainty_m,
         .approach_mps = options.approach_mps,
         .is_of_body = true});
  }
  return points;
}

}  // namespace treeline::control
