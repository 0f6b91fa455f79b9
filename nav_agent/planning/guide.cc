#include "nav_agent/planning/guide.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "nav_agent/planning/open_nodes.h"
#include "nav_agent/planning/path_smoother.h"
#include "nav_agent/planning/planner_parameters.h"

namespace treeline::planning {
namespace {

constexpr float kFar = std::numeric_limits<float>::infinity();
constexpr std::array<core::CellIndex, 16> kSteps = {{{1, 0},
                                                     {0, 1},
                                                     {-1, 0},
                                                     {0, -1},
                                                     {1, 1},
                                                     {-1, 1},
                                                     {-1, -1},
                                                     {1, -1},
                                                     {2, 1},
                                                     {1, 2},
                                                     {-1, 2},
                                                     {-2, 1},
                                                     {-2, -1},
                                                     {-1, -2},
                                                     {1, -2},
                                                     {2, -1}}};

// A* over level * cells + cell.
class GuideSearch {
 public:
  GuideSearch(const ConfigurationSpace& space, const Spot& start,
              const Spot& goal)
      : space_(&space),
        ground_(&space.ground()),
        start_(start),
        goal_(goal),
        cost_m_(ground_->cells() * static_cast<size_t>(ground_->levels()),
                kFar),
        prices_(cost_m_.size(), -1),
        parent_(cost_m_.size()) {
    for (size_t i = 0; i < kSteps.size(); ++i) {
      step_m_[i] = static_cast<float>(ground_->resolution_m() *
                                      std::hypot(kSteps[i].x, kSteps[i].y));
    }
  }

  Polyline Run(const std::function<bool()>& is_over) {
    const uint32_t goal = NumberOf(goal_.level, ground_->CellOf(goal_.at));
    const uint32_t start = NumberOf(start_.level, ground_->CellOf(start_.at));
    cost_m_[start] = 0;
    parent_[start] = start;
    open_.push({Estimate_m(start), start});
    for (int count = 0; !open_.empty(); ++count) {
      if (count % kStopEvery == 0 && is_over()) return {};
      const OpenNode next = open_.top();
      open_.pop();
      if (next.number == goal) return WayTo(goal);
      if (next.estimate_m > cost_m_[next.number] + Estimate_m(next.number)) {
        continue;  // it was reached at less cost since
      }
      Expand(next.number);
    }
    return {};
  }

 private:
  uint32_t NumberOf(int level, core::CellIndex cell) const {
    return static_cast<uint32_t>(static_cast<size_t>(level) * ground_->cells() +
                                 ground_->IndexOf(cell));
  }
  core::CellIndex CellOf(uint32_t number) const {
    const auto cell = static_cast<int>(number % ground_->cells());
    return {cell % ground_->width(), cell / ground_->width()};
  }
  Spot SpotOf(uint32_t number) const {
    return {.at = ground_->CenterOf(CellOf(number)),
            .level = static_cast<int>(number / ground_->cells())};
  }
  float Estimate_m(uint32_t number) const {
    const geometry::Vec2 way = ground_->CenterOf(CellOf(number)) - goal_.at;
    return static_cast<float>(std::sqrt(geometry::Dot(way, way)));
  }

  void Expand(uint32_t from) {
    const int from_level = static_cast<int>(from / ground_->cells());
    const core::CellIndex cell = CellOf(from);
    // The start's own cell may have less room.
    const float from_price = std::max(1.0F, PriceAt(from));
    const float from_cost_m = cost_m_[from];
    for (size_t i = 0; i < kSteps.size(); ++i) {
      const core::CellIndex next = {cell.x + kSteps[i].x, cell.y + kSteps[i].y};
      const int level = ground_->LevelAfter(from_level, cell, next);
      if (level < 0) continue;
      const uint32_t number = NumberOf(level, next);
      // A metre costs 1 at least.
      if (from_cost_m + step_m_[i] >= cost_m_[number]) continue;
      const float price = PriceAt(number);
      if (!(price > 0)) continue;
      const float cost_m = from_cost_m + step_m_[i] * (from_price + price) / 2;
      if (cost_m >= cost_m_[number]) continue;
      cost_m_[number] = cost_m;
      parent_[number] = from;
      open_.push({cost_m + Estimate_m(number), number});
    }
  }

  // What a metre costs; 0 where the disc has no room. Asked once.
  float PriceAt(uint32_t number) {
    float& price = prices_[number];
    if (price < 0) {
      const Spot spot = SpotOf(number);
      price = space_->MayHoldDisc(spot)
                  ? static_cast<float>(space_->CostPerMetre(spot))
                  : 0;
    }
    return price;
  }

  Polyline WayTo(uint32_t goal) const {
    Polyline way = {goal_};
    uint32_t at = parent_[goal];
    for (; at != parent_[at]; at = parent_[at]) way.push_back(SpotOf(at));
    way.push_back(start_);
    std::ranges::reverse(way);
    return way;
  }

  const ConfigurationSpace* space_;
  const GroundIndex* ground_;
  Spot start_;
  Spot goal_;
  std::array<float, kSteps.size()> step_m_ = {};
  std::vector<float> cost_m_;
  std::vector<float> prices_;
  std::vector<uint32_t> parent_;
  OpenNodes open_;
};

// The first, the last, and between them one every spacing_m.
Polyline Thinned(const ConfigurationSpace& space, const Polyline& points,
                 double spacing_m) {
  Polyline thin = {points.front()};
  double left_m = spacing_m;
  for (size_t i = 1; i < points.size(); ++i) {
    const geometry::Vec2 line = points[i].at - points[i - 1].at;
    const double length_m = geometry::Norm(line);
    double along_m = left_m;
    Spot at = points[i - 1];
    for (; along_m < length_m; along_m += spacing_m) {
      const geometry::Vec2 to = points[i - 1].at + (along_m / length_m) * line;
      at = space.Follow(at, to).value_or(Spot{to, points[i].level});
      thin.push_back(at);
    }
    left_m = along_m - length_m;
  }
  if (geometry::Norm(thin.back().at - points.back().at) < spacing_m / 2 &&
      thin.size() > 1) {
    thin.pop_back();
  }
  thin.push_back(points.back());
  return thin;
}

}  // namespace

Polyline FindGridPath(const ConfigurationSpace& space, const Spot& start,
                      const Spot& goal, const std::function<bool()>& is_over) {
  if (start.level == goal.level &&
      space.ground().CellOf(start.at) == space.ground().CellOf(goal.at)) {
    return {start, goal};
  }
  return GuideSearch(space, start, goal).Run(is_over);
}

Polyline ShortcutPolyline(const ConfigurationSpace& space, double start_yaw_rad,
                          double goal_yaw_rad, const Polyline& points,
                          double spacing_m) {
  const Polyline thin = Thinned(space, points, spacing_m);
  struct Best {
    double cost_m = std::numeric_limits<double>::infinity();
    double yaw_rad = 0;
    size_t parent = 0;
  };
  std::vector<Best> best(thin.size());
  best[0] = {.cost_m = 0, .yaw_rad = start_yaw_rad};
  for (size_t i = 0; i + 1 < thin.size(); ++i) {
    if (!std::isfinite(best[i].cost_m)) continue;
    for (size_t k = std::min(thin.size() - 1, i + size_t{kPullAhead.value});
         k > i; --k) {
      const geometry::Vec2 line = thin[k].at - thin[i].at;
      const double length_m = geometry::Norm(line);
      if (!(length_m > 1e-6)) continue;
      // A line costs no less than its length.
      if (best[i].cost_m + length_m >= best[k].cost_m) continue;
      const double yaw_rad = std::atan2(line.y, line.x);
      double cost_m = best[i].cost_m + TurnCost_m(best[i].yaw_rad, yaw_rad) +
                      space.LineCost_m(thin[i], thin[k]);
      if (k + 1 == thin.size()) cost_m += TurnCost_m(yaw_rad, goal_yaw_rad);
      if (cost_m >= best[k].cost_m ||
          !space.CanTurn(thin[i], best[i].yaw_rad, yaw_rad)) {
        continue;
      }
      const std::optional<Spot> end = space.Drive(thin[i], thin[k].at);
      if (!end.has_value() || end->level != thin[k].level) continue;
      if (k + 1 == thin.size() &&
          !space.CanTurn(thin[k], yaw_rad, goal_yaw_rad)) {
        continue;
      }
      best[k] = {.cost_m = cost_m, .yaw_rad = yaw_rad, .parent = i};
    }
  }
  if (!std::isfinite(best.back().cost_m)) return {};
  Polyline way;
  for (size_t i = thin.size() - 1; i > 0; i = best[i].parent) {
    way.push_back(thin[i]);
  }
  way.push_back(thin.front());
  std::ranges::reverse(way);
  return way;
}

}  // namespace treeline::planning
