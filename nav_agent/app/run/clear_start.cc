#include "nav_agent/app/run/clear_start.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace treeline::run_app {
namespace {

// What moves less does not walk (m).
constexpr float kWalks_m = 0.2F;
// Between the places of a way around the start (s).
constexpr double kStep_s = 0.1;
// The same along an arc, seen from the start.
constexpr double kArc_rad = 0.2;

geometry::Vec2 Planar(const worlds::Placement& place) {
  return {static_cast<double>(place.origin.x),
          static_cast<double>(place.origin.y)};
}

bool Walks(const worlds::Motion& motion) {
  const worlds::Float3& first = motion.keys.front().world_from_body.origin;
  return std::ranges::any_of(motion.keys, [&](const auto& key) {
    const worlds::Float3& at = key.world_from_body.origin;
    return std::hypot(at.x - first.x, at.y - first.y) > kWalks_m;
  });
}

worlds::Placement PushedOut(worlds::Placement place, geometry::Vec2 start,
                            double distance_m) {
  geometry::Vec2 away = Planar(place) - start;
  const double now_m = geometry::Norm(away);
  if (now_m >= distance_m) return place;
  away = now_m > 1e-6 ? (1 / now_m) * away : geometry::Vec2{1, 0};
  const geometry::Vec2 at = start + distance_m * away;
  place.origin.x = static_cast<float>(at.x);
  place.origin.y = static_cast<float>(at.y);
  return place;
}

// Adds a place, and before it what is needed to go around the start and not
// through it.
void Add(const worlds::Motion::Key& next, geometry::Vec2 start,
         double distance_m, std::vector<worlds::Motion::Key>& keys) {
  if (!keys.empty()) {
    const worlds::Motion::Key last = keys.back();
    const geometry::Vec2 from = Planar(last.world_from_body) - start;
    const geometry::Vec2 to = Planar(next.world_from_body) - start;
    const double turn_rad =
        std::atan2(geometry::Cross(from, to), geometry::Dot(from, to));
    const int pieces =
        geometry::Norm(from) < 1.01 * distance_m &&
                geometry::Norm(to) < 1.01 * distance_m
            ? static_cast<int>(std::ceil(std::abs(turn_rad) / kArc_rad))
            : 1;
    for (int i = 1; i < pieces; ++i) {
      const double part = static_cast<double>(i) / pieces;
      worlds::Motion::Key key = next;
      key.time_s = (1 - part) * last.time_s + part * next.time_s;
      const double angle_rad = std::atan2(from.y, from.x) + part * turn_rad;
      key.world_from_body.origin.x =
          static_cast<float>(start.x + distance_m * std::cos(angle_rad));
      key.world_from_body.origin.y =
          static_cast<float>(start.y + distance_m * std::sin(angle_rad));
      keys.push_back(key);
    }
  }
  keys.push_back(next);
}

// The same motion in small steps, none of them near the start.
worlds::Motion Around(const worlds::Motion& motion, geometry::Vec2 start,
                      double distance_m) {
  worlds::Motion around = {.keys = {}, .period_s = motion.period_s};
  const double end_s = std::max(motion.period_s, motion.keys.back().time_s);
  const auto steps = static_cast<int>(std::ceil(end_s / kStep_s));
  for (int i = 0; i <= steps; ++i) {
    const double time_s = std::min(end_s, i * kStep_s);
    // At the end of its period it begins again.
    const double at_s =
        motion.period_s > 0 && time_s >= motion.period_s ? 0 : time_s;
    Add({.time_s = time_s,
         .world_from_body = PushedOut(motion.At(at_s), start, distance_m)},
        start, distance_m, around.keys);
  }
  return around;
}

bool ComesNear(const worlds::Motion& motion, geometry::Vec2 start,
               double distance_m) {
  const double end_s = std::max(motion.period_s, motion.keys.back().time_s);
  for (double time_s = 0; time_s <= end_s; time_s += kStep_s) {
    if (geometry::Norm(Planar(motion.At(time_s)) - start) < distance_m) {
      return true;
    }
  }
  return false;
}

}  // namespace

void KeepOffStart(geometry::Vec2 start, double room_m, worlds::World& world) {
  for (worlds::Body& body : world.bodies) {
    if (!body.motion.has_value() || !Walks(*body.motion)) continue;
    const double distance_m = room_m + static_cast<double>(body.radius_m);
    if (!ComesNear(*body.motion, start, distance_m)) continue;
    body.motion = Around(*body.motion, start, distance_m);
  }
}

}  // namespace treeline::run_app
