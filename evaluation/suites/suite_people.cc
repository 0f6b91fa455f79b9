#include "evaluation/suites/suite_people.h"

#include <cmath>

namespace treeline::suites {
namespace {

// A person is about this high and wide.
constexpr float kPersonFrom_m = 1.4f;
constexpr float kPersonTo_m = 2.1f;
constexpr float kPersonRadius_m = 0.5f;

worlds::Placement PlacedAt(const simulator::RobotPlacement& at,
                           double yaw_rad) {
  return {.origin = {static_cast<float>(at.position.x),
                     static_cast<float>(at.position.y),
                     static_cast<float>(at.height_m)},
          .yaw_rad = static_cast<float>(yaw_rad)};
}

}  // namespace

int PersonOf(const worlds::World& world) {
  for (size_t i = 0; i < world.bodies.size(); ++i) {
    const worlds::Body& body = world.bodies[i];
    if (body.motion.has_value() && body.motion->keys.size() > 1 &&
        body.height_m > kPersonFrom_m && body.height_m < kPersonTo_m &&
        body.radius_m < kPersonRadius_m) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

worlds::Motion ToAndFro(const simulator::RobotPlacement& from,
                        const simulator::RobotPlacement& to, double walk_mps,
                        double pause_s) {
  const geometry::Vec2 way = to.position - from.position;
  const double yaw_rad = std::atan2(way.y, way.x);
  const double walk_s = Norm(way) / walk_mps;
  const double turn_s = 0.5;
  worlds::Motion motion;
  double time_s = 0;
  const auto add = [&](const simulator::RobotPlacement& at, double yaw) {
    motion.keys.push_back(
        {.time_s = time_s, .world_from_body = PlacedAt(at, yaw)});
  };
  add(from, yaw_rad);
  time_s += walk_s;
  add(to, yaw_rad);
  time_s += pause_s;
  add(to, yaw_rad);
  time_s += turn_s;
  add(to, yaw_rad + 3.14159);
  time_s += walk_s;
  add(from, yaw_rad + 3.14159);
  time_s += pause_s;
  add(from, yaw_rad + 3.14159);
  motion.period_s = time_s + turn_s;
  return motion;
}

}  // namespace treeline::suites
