#include "nav_agent/control/obstacle_layer.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "nav_agent/control/obstacle_parameters.h"

namespace treeline::control {
namespace {

constexpr int64_t kStandingAfter_ms = Milliseconds(kStandingAfter_s);

uint8_t OneMore(uint8_t hits) {
  return static_cast<uint8_t>(std::min(kMaxHits, hits + 1));
}

uint8_t Fewer(uint8_t hits) {
  return static_cast<uint8_t>(std::max(0, hits - kMissWeight));
}

}  // namespace

ObstacleLayer::ObstacleLayer(size_t cells, bool has_two_lasers)
    : seen_(cells),
      hit_in_(cells, 0),
      passed_in_(cells, 0),
      held_looks_(has_two_lasers ? 1 : 0) {}

void ObstacleLayer::Clear() { std::ranges::fill(seen_, Seen()); }

void ObstacleLayer::Roll(const CostmapWindow& from, const CostmapWindow& to) {
  const int64_t by_x = to.cell_x() - from.cell_x();
  const int64_t by_y = to.cell_y() - from.cell_y();
  if (std::abs(by_x) >= from.width() || std::abs(by_y) >= from.height()) {
    Clear();
    return;
  }
  const int shift_x = static_cast<int>(by_x);
  const int shift_y = static_cast<int>(by_y);
  std::vector<Seen> shifted(seen_.size());
  for (int y = 0; y < to.height(); ++y) {
    for (int x = 0; x < to.width(); ++x) {
      if (from.IsInside(x + shift_x, y + shift_y)) {
        shifted[to.IndexOf(x, y)] =
            seen_[from.IndexOf(x + shift_x, y + shift_y)];
      }
    }
  }
  seen_ = std::move(shifted);
}

void ObstacleLayer::Forget(int64_t now_ms) {
  for (Seen& seen : seen_) {
    if (seen.laser_hits == 0 && seen.depth_hits == 0) continue;
    const bool stood =
        seen.last_ms - seen.since_ms > kStandingAfter_ms && !seen.is_of_mover;
    const double memory_s = stood ? kStandingMemory_s : kRecently_s;
    if (static_cast<double>(now_ms - seen.last_ms) > 1000 * memory_s) {
      seen = Seen();
    }
  }
}

void ObstacleLayer::BeginLook() {
  ++look_;
  hits_.clear();
}

void ObstacleLayer::Hit(size_t i) {
  if (hit_in_[i] == look_) return;
  hit_in_[i] = look_;
  hits_.push_back(i);
}

void ObstacleLayer::ClearAlong(const CostmapWindow& window,
                               const GroundLayer& ground, geometry::Vec3 from,
                               geometry::Vec3 to, int64_t now_ms) {
  const double r = window.resolution_m();
  const geometry::Vec2 origin = window.origin_in_map();
  const geometry::Vec2 way = {to.x - from.x, to.y - from.y};
  const double length_m = geometry::Norm(way);
  const int steps = static_cast<int>(length_m / (kCellStep * r));
  if (steps < 1) return;
  const double inverse = 1 / r;
  double x = (from.x - origin.x) * inverse;
  double y = (from.y - origin.y) * inverse;
  const double step_x = way.x / steps * inverse;
  const double step_y = way.y / steps * inverse;
  const double step_z = (to.z - from.z) / steps;
  double z = from.z;
  size_t last = seen_.size();
  for (int step = 0; step < steps; ++step) {
    if (x >= 0 && y >= 0 && x < window.width() && y < window.height()) {
      const size_t i = window.IndexOf(static_cast<int>(x), static_cast<int>(y));
      if (i != last) {
        last = i;
        // Higher up it does not see what stands there.
        if (passed_in_[i] != look_ && hit_in_[i] + held_looks_ < look_ &&
            ground.IsGround(i) && z < ground.Height_m(i) + kLookHeight_m) {
          passed_in_[i] = look_;
          Seen& seen = seen_[i];
          seen.laser_hits = Fewer(seen.laser_hits);
          if (seen.laser_hits == 0) seen.last_free_ms = now_ms;
          // It says nothing of what is lower than its plane.
          if (seen.depth_hits == 0) seen.last_ms = now_ms;
        }
      }
    } else if (step > 0 && last != seen_.size()) {
      return;  // it has left the window
    }
    x += step_x;
    y += step_y;
    z += step_z;
  }
}

void ObstacleLayer::ClearByDepth(size_t i, int64_t now_ms) {
  if (hit_in_[i] == look_ || passed_in_[i] == look_) return;
  passed_in_[i] = look_;
  Seen& seen = seen_[i];
  seen.depth_hits = Fewer(seen.depth_hits);
  seen.last_ms = now_ms;
}

// The first hit after the cell was clear.
void ObstacleLayer::Begin(Seen& seen, int64_t now_ms) const {
  seen.since_ms = now_ms;
  seen.was_free = seen.last_free_ms > 0 &&
                  now_ms - seen.last_free_ms < Milliseconds(kRecently_s);
}

void ObstacleLayer::MarkLaserHits(int64_t now_ms) {
  for (const size_t i : hits_) {
    Seen& seen = seen_[i];
    // Where the camera saw something, perhaps long ago, the laser may see
    // another thing come.
    if (seen.laser_hits == 0) Begin(seen, now_ms);
    seen.is_of_mover = false;
    seen.laser_hits = OneMore(seen.laser_hits);
    seen.last_ms = now_ms;
  }
}

void ObstacleLayer::MarkDepthHits(int64_t now_ms) {
  for (const size_t i : hits_) {
    Seen& seen = seen_[i];
    if (seen.laser_hits == 0 && seen.depth_hits == 0) Begin(seen, now_ms);
    seen.is_of_mover = false;
    seen.depth_hits = OneMore(seen.depth_hits);
    seen.last_ms = now_ms;
  }
}

bool ObstacleLayer::Counts(size_t i) const {
  return seen_[i].laser_hits >= kHitsToMark ||
         seen_[i].depth_hits >= kHitsToMark;
}

bool ObstacleLayer::IsNew(size_t i, const GroundLayer& ground) const {
  return !ground.map_is_unknown() &&
         ground.MapDistance_m(i) >
             (seen_[i].was_free ? kCameFrom_m : kNewFrom_m);
}

bool ObstacleLayer::IsMoving(const CostmapWindow& window,
                             const GroundLayer& ground, core::CellIndex cell,
                             int64_t now_ms) const {
  if (!window.IsInside(cell)) return false;
  const size_t at = window.IndexOf(cell.x, cell.y);
  if (ground.MapDistance_m(at) <= kCameFrom_m) return false;
  if (!seen_[at].was_free || Age_ms(at, now_ms) > kStandingAfter_ms) {
    return false;
  }
  // The edges of what stands flicker; what is only remembered does not: who
  // comes back to where somebody stood moves.
  for (int y = cell.y - 1; y <= cell.y + 1; ++y) {
    for (int x = cell.x - 1; x <= cell.x + 1; ++x) {
      if (!window.IsInside(x, y)) continue;
      const size_t i = window.IndexOf(x, y);
      if (Counts(i) && Age_ms(i, now_ms) > kStandingAfter_ms &&
          now_ms - seen_[i].last_ms < Milliseconds(kLately_s)) {
        return false;
      }
    }
  }
  return true;
}

bool ObstacleLayer::IsSeenNow(size_t i, int64_t now_ms) const {
  return now_ms - seen_[i].last_ms <= Milliseconds(kSeenNow_s);
}

void ObstacleLayer::Widen(const CostmapWindow& window,
                          const GroundLayer& ground,
                          std::span<uint8_t> is_obstacle) const {
  const double reach_cells = kBodyWidening_m / window.resolution_m();
  const int reach = static_cast<int>(reach_cells);
  if (reach < 1) return;
  for (int y = 0; y < window.height(); ++y) {
    for (int x = 0; x < window.width(); ++x) {
      const size_t i = window.IndexOf(x, y);
      if (!ground.IsGround(i) || !Counts(i) || !IsNew(i, ground)) continue;
      for (int dy = -reach; dy <= reach; ++dy) {
        for (int dx = -reach; dx <= reach; ++dx) {
          if (!window.IsInside(x + dx, y + dy) ||
              dx * dx + dy * dy > reach_cells * reach_cells + 0.5) {
            continue;
          }
          is_obstacle[window.IndexOf(x + dx, y + dy)] = 1;
        }
      }
    }
  }
}

}  // namespace treeline::control
