#include "nav_agent/mapless/way_field.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

#include "nav_agent/mapless/parameters.h"

namespace treeline::mapless {
namespace {

// Around robot, goal and all that was seen.
constexpr double kMargin_m = 1.5;
// Of the plan beyond what the way needs: rollouts look there.
constexpr float kBeyond_m = 3;
// How far off a goal without room may be moved.
constexpr double kMaxMovedGoal_m = 1.5;
// A cell that the body does not fit on leads out of there, dearly.
constexpr float kEscapeCost = 8;
// Nearer to a thing than this share of the body's inner radius it is never.
constexpr double kNeverShare = 0.55;
constexpr float kNever = -1;
constexpr float kUnreached = std::numeric_limits<float>::infinity();

constexpr std::pair<int, int> kNeighbours[] = {
    {1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {1, -1}, {-1, 1}, {-1, -1}};

}  // namespace

void WayField::Restart() {
  path_.clear();
  changes_ = 0;
}

void WayField::MakeCosts(const ClearanceWindow& clearance) {
  columns_ = clearance.columns();
  rows_ = clearance.rows();
  cell_m_ = clearance.cell_m();
  origin_ = clearance.origin();
  const double soft_m = body_.outer_m() + kSoftRoom_m;
  const double scale = 1 / (soft_m - body_.inner_m());
  const std::vector<float>& distances_m = clearance.cells();
  cost_.resize(distances_m.size());
  for (size_t i = 0; i < cost_.size(); ++i) {
    const auto distance_m = static_cast<double>(distances_m[i]);
    if (distance_m < body_.inner_m()) {
      cost_[i] = distance_m < kNeverShare * body_.inner_m() ? kNever : 0;
      continue;
    }
    const double nearness = std::max(0.0, (soft_m - distance_m) * scale);
    cost_[i] = static_cast<float>(1 + kNearCost * nearness * nearness);
  }
  // The present way is cheaper.
  const auto reach = static_cast<int>(kWayWidth_m / cell_m_);
  std::vector<bool> is_way(cost_.size(), false);
  for (size_t p = 0; p < path_.size(); p += 3) {
    const auto at_x =
        static_cast<int>(std::floor((path_[p].x - origin_.x) / cell_m_));
    const auto at_y =
        static_cast<int>(std::floor((path_[p].y - origin_.y) / cell_m_));
    for (int y = std::max(0, at_y - reach);
         y <= std::min(rows_ - 1, at_y + reach); ++y) {
      for (int x = std::max(0, at_x - reach);
           x <= std::min(columns_ - 1, at_x + reach); ++x) {
        is_way[IndexOf(x, y)] = true;
      }
    }
  }
  for (size_t i = 0; i < cost_.size(); ++i) {
    if (is_way[i] && cost_[i] > 0) cost_[i] *= static_cast<float>(kPresentWay);
  }
}

core::CellIndex WayField::NearestFree(core::CellIndex cell) const {
  const auto reach = static_cast<int>(kMaxMovedGoal_m / cell_m_);
  core::CellIndex best = cell;
  int best_squared = INT32_MAX;
  for (int y = std::max(0, cell.y - reach);
       y <= std::min(rows_ - 1, cell.y + reach); ++y) {
    for (int x = std::max(0, cell.x - reach);
         x <= std::min(columns_ - 1, cell.x + reach); ++x) {
      const int squared =
          (x - cell.x) * (x - cell.x) + (y - cell.y) * (y - cell.y);
      if (squared < best_squared && cost_[IndexOf(x, y)] > 0) {
        best_squared = squared;
        best = {x, y};
      }
    }
  }
  return best;
}

bool WayField::Spread(core::CellIndex goal, core::CellIndex robot) {
  to_go_.assign(cost_.size(), kUnreached);
  if (cost_[IndexOf(goal.x, goal.y)] <= 0) return false;
  using Entry = std::pair<float, uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  const size_t start = IndexOf(goal.x, goal.y);
  const size_t end = IndexOf(robot.x, robot.y);
  to_go_[start] = 0;
  open.emplace(0.0F, static_cast<uint32_t>(start));
  float until = kUnreached;
  const auto straight_m = static_cast<float>(cell_m_);
  const float diagonal_m = straight_m * std::sqrt(2.0F);
  while (!open.empty()) {
    const auto [far, index] = open.top();
    open.pop();
    if (far > to_go_[index]) continue;
    if (far > until) break;
    if (index == end) until = far + kBeyond_m;
    const auto x = static_cast<int>(index % static_cast<size_t>(columns_));
    const auto y = static_cast<int>(index / static_cast<size_t>(columns_));
    const bool is_escape = cost_[index] <= 0;
    for (const auto& [dx, dy] : kNeighbours) {
      if (x + dx < 0 || x + dx >= columns_ || y + dy < 0 || y + dy >= rows_)
        continue;
      const size_t next = IndexOf(x + dx, y + dy);
      const bool to_escape = cost_[next] <= 0;
      // Out of where the body does not fit, never through.
      if (cost_[next] == kNever || (is_escape && !to_escape)) continue;
      const float way_m = dx != 0 && dy != 0 ? diagonal_m : straight_m;
      const float cost =
          to_escape ? kEscapeCost : 0.5F * (cost_[next] + cost_[index]);
      const float reached = far + way_m * cost;
      if (reached < to_go_[next]) {
        to_go_[next] = reached;
        open.emplace(reached, static_cast<uint32_t>(next));
      }
    }
  }
  return to_go_[end] < kUnreached;
}

std::vector<geometry::Vec2> WayField::Descend(core::CellIndex robot) const {
  std::vector<geometry::Vec2> path;
  core::CellIndex at = robot;
  while (true) {
    path.push_back({origin_.x + (at.x + 0.5) * cell_m_,
                    origin_.y + (at.y + 0.5) * cell_m_});
    core::CellIndex best = at;
    float best_slope = 0;
    const float here = to_go_[IndexOf(at.x, at.y)];
    for (const auto& [dx, dy] : kNeighbours) {
      const int x = at.x + dx;
      const int y = at.y + dy;
      if (x < 0 || x >= columns_ || y < 0 || y >= rows_) continue;
      const float way = dx != 0 && dy != 0 ? std::sqrt(2.0F) : 1.0F;
      const float slope = (here - to_go_[IndexOf(x, y)]) / way;
      if (slope > best_slope) {
        best_slope = slope;
        best = {x, y};
      }
    }
    if (best == at) return path;
    at = best;
  }
}

void WayField::NoteChange(const std::vector<geometry::Vec2>& before) {
  if (before.empty() || path_.empty()) return;
  // Far from every point of the way before.
  for (size_t i = 0; i < path_.size(); i += 8) {
    double nearest_m = std::numeric_limits<double>::infinity();
    for (size_t j = 0; j < before.size(); j += 4) {
      nearest_m = std::min(nearest_m, geometry::Norm(path_[i] - before[j]));
    }
    if (nearest_m > 2 * kWayWidth_m) {
      ++changes_;
      return;
    }
  }
}

bool WayField::Update(const EvidenceGrid& map, geometry::Vec2 robot,
                      geometry::Vec2 goal) {
  const geometry::Vec2 seen_low = map.seen_low();
  const geometry::Vec2 seen_high = map.seen_high();
  const geometry::Vec2 low = {std::min({robot.x, goal.x, seen_low.x}),
                              std::min({robot.y, goal.y, seen_low.y})};
  const geometry::Vec2 high = {std::max({robot.x, goal.x, seen_high.x}),
                               std::max({robot.y, goal.y, seen_high.y})};
  const geometry::Vec2 margin = {kMargin_m, kMargin_m};
  MakeCosts(ClearanceWindow(map, low - margin, high + margin));
  const auto cell_of = [this](geometry::Vec2 point) {
    return core::CellIndex{
        static_cast<int>(std::floor((point.x - origin_.x) / cell_m_)),
        static_cast<int>(std::floor((point.y - origin_.y) / cell_m_))};
  };
  const core::CellIndex wanted = cell_of(goal);
  const core::CellIndex end = NearestFree(wanted);
  moved_goal_m_ = cell_m_ * std::hypot(end.x - wanted.x, end.y - wanted.y);
  const std::vector<geometry::Vec2> before = std::move(path_);
  path_.clear();
  const core::CellIndex start = cell_of(robot);
  if (!Spread(end, start)) return false;
  path_ = Descend(start);
  NoteChange(before);
  return true;
}

double WayField::ToGo(geometry::Vec2 point) const {
  const double x = (point.x - origin_.x) / cell_m_ - 0.5;
  const double y = (point.y - origin_.y) / cell_m_ - 0.5;
  const auto x0 = static_cast<int>(std::floor(x));
  const auto y0 = static_cast<int>(std::floor(y));
  if (x0 < 0 || y0 < 0 || x0 + 1 >= columns_ || y0 + 1 >= rows_) return kNoWay;
  const double u = x - x0;
  const double v = y - y0;
  const double corners[] = {
      static_cast<double>(to_go_[IndexOf(x0, y0)]),
      static_cast<double>(to_go_[IndexOf(x0 + 1, y0)]),
      static_cast<double>(to_go_[IndexOf(x0, y0 + 1)]),
      static_cast<double>(to_go_[IndexOf(x0 + 1, y0 + 1)])};
  const double weights[] = {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
  double sum = 0;
  double weight = 0;
  for (int i = 0; i < 4; ++i) {
    if (std::isinf(corners[i])) continue;
    sum += weights[i] * corners[i];
    weight += weights[i];
  }
  return weight > 0.25 ? sum / weight : kNoWay;
}

double WayField::length_m() const {
  double length_m = 0;
  for (size_t i = 1; i < path_.size(); ++i) {
    length_m += geometry::Norm(path_[i] - path_[i - 1]);
  }
  return length_m;
}

}  // namespace treeline::mapless
