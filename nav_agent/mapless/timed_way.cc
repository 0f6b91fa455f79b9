#include "nav_agent/mapless/timed_way.h"

#include <algorithm>
#include <cmath>

#include "nav_agent/mapless/parameters.h"

namespace treeline::mapless {
namespace {

constexpr double kLayer_s = 0.25;
// So many cells are as far as the robot comes from one layer to the next: the
// window is as wide as it can see any use of, for slow robots as for fast ones.
constexpr int kReach = 2;
// Movers that cannot come near within all layers do not matter.
constexpr double kRange_m = 12;
// Of cells that the body cannot be on: as dear as a touch.
constexpr float kBlocked_m = 50;
// Beyond so many spreads it does not matter.
constexpr double kSpreads = 5;

double SpreadAt_m(double time_s) {
  return kMoverSpread_m + kMoverSpread_mps * time_s;
}

}  // namespace

double ThreatRate_mps(double gap_m, double time_s) {
  const double spread_m = SpreadAt_m(time_s);
  if (gap_m > kSpreads * spread_m) return 0;
  // Deeper is worse, so that there is a way out.
  if (gap_m <= 0) return kTouchCost_mps * (1 - gap_m);
  return kTouchCost_mps * std::exp(-gap_m / spread_m);
}

TimedWay::TimedWay(double body_m, double speed_mps)
    : body_m_(body_m),
      speed_mps_(speed_mps),
      cell_m_(std::max<double>(kCell_m, speed_mps * kLayer_s / kReach)) {}

geometry::Vec2 TimedWay::CenterOf(int x, int y) const {
  return origin_ + geometry::Vec2{(x + 0.5) * cell_m_, (y + 0.5) * cell_m_};
}

std::vector<float> TimedWay::ThreatsAt(int layer,
                                       std::span<const Mover> movers) const {
  std::vector<float> threats(static_cast<size_t>(kColumns * kColumns), 0);
  const double time_s = layer * kLayer_s;
  for (const Mover& mover : movers) {
    const geometry::Vec2 at = mover.After(time_s);
    const double reach_m =
        mover.radius_m + body_m_ + kSpreads * SpreadAt_m(time_s);
    const auto index = [this](double from, double to) {
      return static_cast<int>(std::floor((to - from) / cell_m_));
    };
    const int first_x = std::max(0, index(origin_.x, at.x - reach_m));
    const int last_x = std::min(kColumns - 1, index(origin_.x, at.x + reach_m));
    const int last_y = std::min(kColumns - 1, index(origin_.y, at.y + reach_m));
    for (int y = std::max(0, index(origin_.y, at.y - reach_m)); y <= last_y;
         ++y) {
      for (int x = first_x; x <= last_x; ++x) {
        const double gap_m =
            geometry::Norm(CenterOf(x, y) - at) - mover.radius_m - body_m_;
        threats[IndexOf(0, x, y)] +=
            static_cast<float>(kLayer_s * ThreatRate_mps(gap_m, time_s));
      }
    }
  }
  return threats;
}

void TimedWay::Update(const WayField& way, std::span<const Mover> movers,
                      geometry::Vec2 robot) {
  std::vector<Mover> near;
  for (const Mover& mover : movers) {
    if (geometry::Norm(mover.in_map - robot) < kRange_m) near.push_back(mover);
  }
  if (near.empty()) {
    Clear();
    return;
  }
  const double half_m = kColumns * cell_m_ / 2;
  origin_ = robot - geometry::Vec2{half_m, half_m};
  to_go_.assign(static_cast<size_t>(kLayers * kColumns * kColumns), 0);
  const auto step = static_cast<float>(speed_mps_ * kLayer_s);
  std::vector<bool> is_blocked(static_cast<size_t>(kColumns * kColumns));
  // Who is there has arrived, and waits for nothing.
  std::vector<bool> is_goal(static_cast<size_t>(kColumns * kColumns));
  for (int y = 0; y < kColumns; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      const double to_go_m = way.ToGo(CenterOf(x, y));
      const bool blocked = std::isinf(to_go_m);
      is_blocked[IndexOf(0, x, y)] = blocked;
      is_goal[IndexOf(0, x, y)] = to_go_m < static_cast<double>(step);
      to_go_[IndexOf(kLayers - 1, x, y)] =
          blocked ? kBlocked_m : static_cast<float>(to_go_m);
    }
  }
  // Cells of the map are the smallest: the slowest robots come one of them far.
  const int reach = cell_m_ > kCell_m ? kReach : 1;
  for (int layer = kLayers - 2; layer >= 0; --layer) {
    const std::vector<float> threats = ThreatsAt(layer, near);
    for (int y = 0; y < kColumns; ++y) {
      for (int x = 0; x < kColumns; ++x) {
        const size_t here = IndexOf(0, x, y);
        if (is_goal[here]) {
          to_go_[IndexOf(layer, x, y)] = to_go_[IndexOf(kLayers - 1, x, y)];
          continue;
        }
        float best = kBlocked_m * 4;
        for (int dy = -reach; dy <= reach; ++dy) {
          for (int dx = -reach; dx <= reach; ++dx) {
            if (dx * dx + dy * dy > reach * reach || x + dx < 0 ||
                x + dx >= kColumns || y + dy < 0 || y + dy >= kColumns) {
              continue;
            }
            best = std::min(best, to_go_[IndexOf(layer + 1, x + dx, y + dy)]);
          }
        }
        to_go_[IndexOf(layer, x, y)] =
            best + step + threats[here] + (is_blocked[here] ? kBlocked_m : 0);
      }
    }
  }
}

double TimedWay::ToGo(geometry::Vec2 point, double time_s) const {
  const double x = (point.x - origin_.x) / cell_m_ - 0.5;
  const double y = (point.y - origin_.y) / cell_m_ - 0.5;
  const int layer = std::clamp(static_cast<int>(std::lround(time_s / kLayer_s)),
                               0, kLayers - 1);
  const auto x0 = static_cast<int>(std::floor(x));
  const auto y0 = static_cast<int>(std::floor(y));
  if (x0 < 0 || y0 < 0 || x0 + 1 >= kColumns || y0 + 1 >= kColumns) {
    return WayField::kNoWay;
  }
  const double u = x - x0;
  const double v = y - y0;
  const auto at = [&](int dx, int dy) {
    return static_cast<double>(to_go_[IndexOf(layer, x0 + dx, y0 + dy)]);
  };
  return (1 - v) * ((1 - u) * at(0, 0) + u * at(1, 0)) +
         v * ((1 - u) * at(0, 1) + u * at(1, 1));
}

}  // namespace treeline::mapless
