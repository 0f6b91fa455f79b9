#include "simulation/worlds/placement.h"

#include <algorithm>
#include <cmath>

namespace treeline::worlds {
namespace {

constexpr float kTurn_rad = 6.28318531f;

Placement Between(const Motion::Key& a, const Motion::Key& b, double time_s) {
  const double span_s = b.time_s - a.time_s;
  const float t =
      span_s > 0 ? static_cast<float>((time_s - a.time_s) / span_s) : 1.0f;
  const Placement& from = a.world_from_body;
  const Placement& to = b.world_from_body;
  const float turn_rad = std::remainder(to.yaw_rad - from.yaw_rad, kTurn_rad);
  return {Mix(from.origin, to.origin, t), from.yaw_rad + t * turn_rad};
}

}  // namespace

Float3 Placement::Direction(Float3 local) const {
  const float c = std::cos(yaw_rad);
  const float s = std::sin(yaw_rad);
  return {c * local.x - s * local.y, s * local.x + c * local.y, local.z};
}

Placement Motion::At(double time_s) const {
  double time = time_s;
  if (period_s > 0) time -= period_s * std::floor(time_s / period_s);
  const auto next = std::upper_bound(
      keys.begin(), keys.end(), time,
      [](double value, const Key& key) { return value < key.time_s; });
  if (next == keys.begin()) return keys.front().world_from_body;
  if (next != keys.end()) return Between(*(next - 1), *next, time);
  if (!(period_s > keys.back().time_s)) return keys.back().world_from_body;
  // On the way back to where it began.
  const Key first_again = {.time_s = period_s,
                           .world_from_body = keys.front().world_from_body};
  return Between(keys.back(), first_again, time);
}

}  // namespace treeline::worlds
