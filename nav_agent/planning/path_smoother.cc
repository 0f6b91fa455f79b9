#include "nav_agent/planning/path_smoother.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "nav_agent/planning/planner_parameters.h"

namespace treeline::planning {
namespace {

double YawOf(const Spot& from, const Spot& to) {
  const geometry::Vec2 way = to.at - from.at;
  return std::atan2(way.y, way.x);
}

}  // namespace

double TurnCost_m(double from_yaw_rad, double to_yaw_rad) {
  return kTurnCost *
         std::abs(geometry::NormalizedAngle_rad(to_yaw_rad - from_yaw_rad));
}

double PathLength_m(const Polyline& way) {
  double length_m = 0;
  for (size_t i = 1; i < way.size(); ++i) {
    length_m += geometry::Norm(way[i].at - way[i - 1].at);
  }
  return length_m;
}

double PathCost_m(const ConfigurationSpace& space, double start_yaw_rad,
                  double goal_yaw_rad, const Polyline& way) {
  double cost_m = 0;
  double yaw_rad = start_yaw_rad;
  for (size_t i = 1; i < way.size(); ++i) {
    const double next_rad = YawOf(way[i - 1], way[i]);
    cost_m +=
        space.LineCost_m(way[i - 1], way[i]) + TurnCost_m(yaw_rad, next_rad);
    yaw_rad = next_rad;
  }
  return cost_m + TurnCost_m(yaw_rad, goal_yaw_rad);
}

bool CanBeDriven(const ConfigurationSpace& space, double start_yaw_rad,
                 double goal_yaw_rad, const Polyline& way) {
  if (way.empty()) return false;
  double yaw_rad = start_yaw_rad;
  for (size_t i = 1; i < way.size(); ++i) {
    const double next_rad = YawOf(way[i - 1], way[i]);
    const std::optional<Spot> end = space.Drive(way[i - 1], way[i].at);
    if (!end.has_value() || end->level != way[i].level ||
        !space.CanTurn(way[i - 1], yaw_rad, next_rad)) {
      return false;
    }
    yaw_rad = next_rad;
  }
  return space.CanTurn(way.back(), yaw_rad, goal_yaw_rad);
}

PathSmoother::PathSmoother(const ConfigurationSpace& space,
                           double start_yaw_rad, double goal_yaw_rad,
                           Polyline way, double max_length_m)
    : space_(&space),
      start_yaw_rad_(start_yaw_rad),
      goal_yaw_rad_(goal_yaw_rad),
      way_(std::move(way)),
      max_length_m_(max_length_m) {
  for (size_t i = 1; i < way_.size(); ++i) {
    line_cost_m_.push_back(space.LineCost_m(way_[i - 1], way_[i]));
  }
  SumUp();
}

void PathSmoother::SumUp() {
  along_m_.assign(1, 0.0);
  cost_m_ = 0;
  for (size_t i = 0; i + 1 < way_.size(); ++i) {
    along_m_.push_back(along_m_.back() +
                       geometry::Norm(way_[i + 1].at - way_[i].at));
    cost_m_ += line_cost_m_[i] + TurnCost_m(YawInto(i), YawOutOf(i));
  }
  cost_m_ += TurnCost_m(YawInto(way_.size() - 1), goal_yaw_rad_);
}

double PathSmoother::YawInto(size_t point) const {
  return point == 0 ? start_yaw_rad_ : YawOf(way_[point - 1], way_[point]);
}

double PathSmoother::YawOutOf(size_t point) const {
  return point + 1 == way_.size() ? goal_yaw_rad_
                                  : YawOf(way_[point], way_[point + 1]);
}

bool PathSmoother::Try(base::Random& random) {
  if (way_.size() < 2) return false;
  if (random.NextBelow(uint32_t{kMoveEvery.value}) == 0) return TryMove(random);
  return random.NextBelow(2) == 0 ? TryCut(random) : TryShortcut(random);
}

// Instead of a point, one a little before it and one a little after it.
bool PathSmoother::TryCut(base::Random& random) {
  if (way_.size() < 3) return false;
  const size_t point =
      1 + random.NextBelow(static_cast<uint32_t>(way_.size() - 2));
  const double before_m = along_m_[point] - along_m_[point - 1];
  const double after_m = along_m_[point + 1] - along_m_[point];
  const double cut_m =
      std::min({before_m, after_m, kMaxCut_m.value}) * random.NextUnit();
  const geometry::Vec2 back = way_[point - 1].at - way_[point].at;
  const geometry::Vec2 ahead = way_[point + 1].at - way_[point].at;
  Polyline between;
  for (const auto& [line, length_m] :
       {std::pair{back, before_m}, std::pair{ahead, after_m}}) {
    if (length_m - cut_m < kMinLine_m) continue;
    const std::optional<Spot> spot =
        space_->Follow(way_[point], way_[point].at + (cut_m / length_m) * line);
    if (!spot.has_value()) return false;
    between.push_back(*spot);
  }
  return Replace(point - 1, point + 1, between);
}

bool PathSmoother::TryShortcut(base::Random& random) {
  double from_m = random.NextUniform(0, along_m_.back());
  // Places that are far from one another seldom see each other.
  double to_m =
      random.NextBelow(4) == 0
          ? random.NextUniform(0, along_m_.back())
          : std::clamp(from_m + kShortcut_m * random.NextUniform(-1, 1), 0.0,
                       along_m_.back());
  if (from_m > to_m) std::swap(from_m, to_m);
  const auto line_at = [this](double along_m) {
    const auto after = std::ranges::upper_bound(along_m_, along_m);
    return std::clamp<size_t>(static_cast<size_t>(after - along_m_.begin()), 1,
                              way_.size() - 1) -
           1;
  };
  const size_t from_line = line_at(from_m);
  const size_t to_line = line_at(to_m);
  if (from_line == to_line) return false;
  const auto point_at = [this](size_t line, double along_m) {
    const double length_m = along_m_[line + 1] - along_m_[line];
    const double t = (along_m - along_m_[line]) / length_m;
    return way_[line].at + t * (way_[line + 1].at - way_[line].at);
  };
  Polyline between;
  if (from_m - along_m_[from_line] > kMinLine_m) {
    const std::optional<Spot> spot =
        space_->Drive(way_[from_line], point_at(from_line, from_m));
    if (!spot.has_value()) return false;
    between.push_back(*spot);
  }
  if (along_m_[to_line + 1] - to_m > kMinLine_m) {
    const std::optional<Spot> spot =
        space_->Drive(way_[to_line], point_at(to_line, to_m));
    if (!spot.has_value()) return false;
    between.push_back(*spot);
  }
  return Replace(from_line, to_line + 1, between);
}

bool PathSmoother::TryMove(base::Random& random) {
  if (way_.size() < 3) return false;
  const size_t point =
      1 + random.NextBelow(static_cast<uint32_t>(way_.size() - 2));
  if (random.NextBelow(4) == 0) return Replace(point - 1, point + 1, {});
  if (random.NextBelow(2) == 0) return TryShift(point, random);
  // From a whole stride down to a hair.
  const double reach_m = 0.5 * std::pow(0.02, random.NextUnit());
  const geometry::Vec2 moved =
      way_[point].at + geometry::Vec2{reach_m * random.NextGaussian(),
                                      reach_m * random.NextGaussian()};
  const std::optional<Spot> spot = space_->Drive(way_[point - 1], moved);
  if (!spot.has_value()) return false;
  return Replace(point - 1, point + 1, {*spot});
}

// Several points by the same: round a corner none of them moves alone.
bool PathSmoother::TryShift(size_t point, base::Random& random) {
  const size_t last =
      std::min(way_.size() - 2,
               point + random.NextBelow(uint32_t{kShiftedPoints.value}));
  const double reach_m = 0.2 * std::pow(0.05, random.NextUnit());
  const geometry::Vec2 shift = {reach_m * random.NextGaussian(),
                                reach_m * random.NextGaussian()};
  Polyline between;
  for (size_t i = point; i <= last; ++i) {
    const std::optional<Spot> spot =
        space_->Follow(way_[i], way_[i].at + shift);
    if (!spot.has_value()) return false;
    between.push_back(*spot);
  }
  return Replace(point - 1, last + 1, between);
}

bool PathSmoother::Replace(size_t first, size_t last, const Polyline& between) {
  // The cheap question first: does it cost less?
  Polyline chain = {way_[first]};
  chain.insert(chain.end(), between.begin(), between.end());
  chain.push_back(way_[last]);
  const double yaw_into_rad = YawInto(first);
  const double yaw_out_rad = YawOutOf(last);
  double old_cost_m = TurnCost_m(YawInto(last), yaw_out_rad);
  for (size_t i = first; i < last; ++i) {
    old_cost_m += line_cost_m_[i] + TurnCost_m(YawInto(i), YawOutOf(i));
  }
  std::vector<double> costs_m;
  double new_cost_m = 0;
  double longer_m = along_m_[first] - along_m_[last];
  double yaw_rad = yaw_into_rad;
  for (size_t i = 1; i < chain.size(); ++i) {
    const double line_m = geometry::Norm(chain[i].at - chain[i - 1].at);
    if (!(line_m > kMinLine_m / 2)) return false;
    longer_m += line_m;
    const double next_rad = YawOf(chain[i - 1], chain[i]);
    costs_m.push_back(space_->LineCost_m(chain[i - 1], chain[i]));
    new_cost_m += costs_m.back() + TurnCost_m(yaw_rad, next_rad);
    yaw_rad = next_rad;
  }
  new_cost_m += TurnCost_m(yaw_rad, yaw_out_rad);
  if (new_cost_m > old_cost_m - kMinGain_m ||
      (longer_m > 0 && length_m() + longer_m > max_length_m_) ||
      !CanBeDriven(*space_, yaw_into_rad, yaw_out_rad, chain)) {
    return false;
  }
  const auto at = [](auto& list, size_t index) {
    return list.begin() + static_cast<std::ptrdiff_t>(index);
  };
  way_.erase(at(way_, first + 1), at(way_, last));
  way_.insert(at(way_, first + 1), between.begin(), between.end());
  line_cost_m_.erase(at(line_cost_m_, first), at(line_cost_m_, last));
  line_cost_m_.insert(at(line_cost_m_, first), costs_m.begin(), costs_m.end());
  SumUp();
  return true;
}

}  // namespace treeline::planning
