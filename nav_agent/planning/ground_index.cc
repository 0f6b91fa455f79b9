#include "nav_agent/planning/ground_index.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace treeline::planning {
namespace {

// What touches only does not overlap.
constexpr double kTouch_cells = 1e-7;

struct Corner {
  double x = 0;
  double y = 0;
};

// The corners in cells, counter-clockwise from the lowest: then comes the
// rightmost, the highest and the leftmost one.
std::array<Corner, 4> CornersOf(const OrientedBox& box, double resolution_m) {
  const double per_cell = 1 / resolution_m;
  const auto corner = [&box, per_cell](double x, double y) {
    return Corner{
        per_cell * (box.origin.x + box.cos_yaw * x - box.sin_yaw * y),
        per_cell * (box.origin.y + box.sin_yaw * x + box.cos_yaw * y)};
  };
  std::array<Corner, 4> corners = {corner(box.back_m, -box.half_width_m),
                                   corner(box.front_m, -box.half_width_m),
                                   corner(box.front_m, box.half_width_m),
                                   corner(box.back_m, box.half_width_m)};
  size_t lowest = 0;
  for (size_t i = 1; i < 4; ++i) {
    // Of two that are equally low the left one comes first.
    if (corners[i].y < corners[lowest].y ||
        (corners[i].y == corners[lowest].y &&
         corners[i].x < corners[lowest].x)) {
      lowest = i;
    }
  }
  return {corners[lowest], corners[(lowest + 1) % 4], corners[(lowest + 2) % 4],
          corners[(lowest + 3) % 4]};
}

// x of the line from a up to b at y.
double XAt(const Corner& a, const Corner& b, double y) {
  const double rise = b.y - a.y;
  if (!(rise > 1e-12)) return b.x;
  return a.x + (b.x - a.x) * (y - a.y) / rise;
}

// x at y of the side that runs from the lowest corner over `turn` to the
// highest one.
double SideAt(const Corner& lowest, const Corner& turn, const Corner& highest,
              double y) {
  return y <= turn.y ? XAt(lowest, turn, y) : XAt(turn, highest, y);
}

}  // namespace

GroundIndex::GroundIndex(
    std::shared_ptr<const traversability::NavigationMap> map,
    std::shared_ptr<const zones::ZoneMap> zones)
    : map_(std::move(map)),
      zones_(std::move(zones)),
      has_one_way_(zones_ != nullptr && zones_->has_one_way()),
      width_(map_->grid(0).width),
      height_(map_->grid(0).height),
      resolution_m_(map_->resolution_m()) {
  for (int level = 0; level < levels(); ++level) {
    const std::vector<float>& slopes =
        map_->traversable().levels[static_cast<size_t>(level)].slope_rad;
    std::vector<float> clearance_m(cells());
    std::vector<float> slope_sine(cells());
    NextInRow next_blocked(cells());
    NextInRow next_beyond(cells());
    for (int y = 0; y < height_; ++y) {
      int32_t next = width_;
      int32_t beyond = width_;
      for (int x = width_ - 1; x >= 0; --x) {
        const size_t at = IndexOf({x, y});
        clearance_m[at] = map_->ClearanceAt_m(level, {x, y});
        slope_sine[at] = std::isnan(slopes[at]) ? 0 : std::sin(slopes[at]);
        if (!(clearance_m[at] > 0)) next = x;
        if (clearance_m[at] > 0 && !map_->IsFree(level, {x, y})) beyond = x;
        next_blocked[at] = next;
        next_beyond[at] = beyond;
      }
    }
    clearance_m_.push_back(std::move(clearance_m));
    slope_sine_.push_back(std::move(slope_sine));
    next_blocked_.push_back(std::move(next_blocked));
    next_beyond_.push_back(std::move(next_beyond));
  }
}

core::CellIndex GroundIndex::CellOf(geometry::Vec2 at) const {
  const double x = std::floor(at.x / resolution_m_);
  const double y = std::floor(at.y / resolution_m_);
  if (!(std::abs(x) < 1e9 && std::abs(y) < 1e9)) return {-1, -1};
  return {static_cast<int>(x), static_cast<int>(y)};
}

bool GroundIndex::IsClear(const NextInRow& next, const OrientedBox& box) const {
  const auto [lowest, right, highest, left] = CornersOf(box, resolution_m_);
  // Also false for what is not a number.
  if (!(lowest.y > -kTouch_cells && highest.y < height_ + kTouch_cells &&
        left.x > -kTouch_cells && right.x < width_ + kTouch_cells)) {
    return false;
  }
  const int last_row = std::min(
      height_ - 1, static_cast<int>(std::ceil(highest.y - kTouch_cells)) - 1);
  for (int row =
           std::max(0, static_cast<int>(std::floor(lowest.y + kTouch_cells)));
       row <= last_row; ++row) {
    // The box's sides bulge: within a row each is furthest out as near to its
    // corner as the row lets it.
    const double from_y = std::max<double>(row, lowest.y);
    const double to_y = std::min<double>(row + 1, highest.y);
    const double from_x =
        SideAt(lowest, left, highest, std::clamp(left.y, from_y, to_y));
    const double to_x =
        SideAt(lowest, right, highest, std::clamp(right.y, from_y, to_y));
    if (!IsClearInRow(next, row, from_x, to_x)) return false;
  }
  return true;
}

// Whether there is none between two abscissas of a row, in cells.
bool GroundIndex::IsClearInRow(const NextInRow& next, int row, double from_x,
                               double to_x) const {
  const int from =
      std::max(0, static_cast<int>(std::floor(from_x + kTouch_cells)));
  const int to = std::min(width_ - 1,
                          static_cast<int>(std::ceil(to_x - kTouch_cells)) - 1);
  return from > to || next[IndexOf({from, row})] > to;
}

bool GroundIndex::IsFreeDisc(int level, geometry::Vec2 center,
                             double radius_m) const {
  const double x = center.x / resolution_m_;
  const double y = center.y / resolution_m_;
  const double radius = radius_m / resolution_m_;
  if (!(x - radius > -kTouch_cells && x + radius < width_ + kTouch_cells &&
        y - radius > -kTouch_cells && y + radius < height_ + kTouch_cells)) {
    return false;
  }
  const int last_row = std::min(
      height_ - 1, static_cast<int>(std::ceil(y + radius - kTouch_cells)) - 1);
  for (int row =
           std::max(0, static_cast<int>(std::floor(y - radius + kTouch_cells)));
       row <= last_row; ++row) {
    // Widest as near to the middle as the row lets it.
    const double dy = std::clamp<double>(y, row, row + 1) - y;
    const double half = std::sqrt(std::max(0.0, radius * radius - dy * dy));
    if (!IsClearInRow(next_blocked_[static_cast<size_t>(level)], row, x - half,
                      x + half)) {
      return false;
    }
  }
  return true;
}

int GroundIndex::LevelAfter(int level, core::CellIndex cell,
                            core::CellIndex next) const {
  if (!Contains(cell) || !Contains(next)) return -1;
  if (map_->IsFree(level, next)) return level;
  if (levels() == 1) return -1;
  const std::vector<traversability::TraversableLevel>& all =
      map_->traversable().levels;
  const float height_m =
      all[static_cast<size_t>(level)].height_m[IndexOf(cell)];
  int best = -1;
  float best_rise_m = static_cast<float>(map_->options().max_rise_m);
  for (int other = 0; other < levels(); ++other) {
    if (other == level || !map_->IsFree(other, next)) continue;
    const float rise_m = std::abs(
        all[static_cast<size_t>(other)].height_m[IndexOf(next)] - height_m);
    if (rise_m <= best_rise_m) {
      best = other;
      best_rise_m = rise_m;
    }
  }
  return best;
}

}  // namespace treeline::planning
