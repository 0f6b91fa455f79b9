#include "nav_agent/planning/guide.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "nav_agent/planning/path_smoother.h"
#include "nav_agent/planning/planner_parameters.h"

namespace treeline::planning {
namespace {

// Further points of a guide are not tried where nearer ones cannot be driven
// to.
constexpr size_t kTryAhead = 16;
// The direction at a point is that between points so many before and after it.
constexpr size_t kAlong = 2;
// So many points before and after a narrow one lie in line with it.
constexpr size_t kApproach = 4;

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

// What moves a point to the middle between what is on both sides of a footprint
// that looks along the points; nullopt where nothing is near.
std::optional<geometry::Vec2> ToMiddle(const ConfigurationSpace& space,
                                       const Polyline& points, size_t i) {
  const double reach_m = space.footprint().circumradius_m;
  const Spot& before = points[i < kAlong ? 0 : i - kAlong];
  const Spot& after = points[std::min(points.size() - 1, i + kAlong)];
  const geometry::Vec2 line = after.at - before.at;
  const double length_m = geometry::Norm(line);
  if (!(length_m > 1e-6) || space.FitsTurning(points[i])) return std::nullopt;
  const double yaw_rad = std::atan2(line.y, line.x);
  const double left_m = space.RoomBeside_m(points[i], yaw_rad, 1, reach_m);
  const double right_m = space.RoomBeside_m(points[i], yaw_rad, -1, reach_m);
  if (std::min(left_m, right_m) >= reach_m) return std::nullopt;
  return ((left_m - right_m) / (2 * length_m)) *
         geometry::Vec2{-line.y, line.x};
}

// Moves narrow points to the middle: gaps hardly wider than the footprint are
// as often as not between the middles of cells. So are points before and after
// a gap, so that it is come to straight.
void Center(const ConfigurationSpace& space, Polyline& points) {
  std::vector<std::optional<geometry::Vec2>> moves(points.size());
  for (size_t i = 1; i + 1 < points.size(); ++i) {
    moves[i] = ToMiddle(space, points, i);
  }
  for (size_t i = 1; i + 1 < points.size(); ++i) {
    std::optional<geometry::Vec2> move = moves[i];
    for (size_t k = 1; k <= kApproach && !move.has_value(); ++k) {
      if (i >= k) move = moves[i - k];
      if (!move.has_value() && i + k < points.size()) move = moves[i + k];
    }
    if (move.has_value()) points[i].at = points[i].at + *move;
  }
}

// A line of a way over some of the points: from one to a later one.
struct Candidate {
  double yaw_rad = 0;
  double length_m = 0;
};

// Tells which lines between points of a thinned guide can be driven.
class PullLines {
 public:
  PullLines(const ConfigurationSpace& space, double goal_yaw_rad,
            const Polyline& points)
      : space_(&space), goal_yaw_rad_(goal_yaw_rad), points_(&points) {}

  static bool IsLast(const Polyline& points, size_t point) {
    return point + 1 == points.size();
  }
  Candidate LineOf(size_t from, size_t to) const {
    const geometry::Vec2 line = (*points_)[to].at - (*points_)[from].at;
    return {.yaw_rad = std::atan2(line.y, line.x),
            .length_m = geometry::Norm(line)};
  }
  // With the turn onto it from `yaw_rad`, and the last turn to the goal's.
  bool CanDrive(size_t from, size_t to, double yaw_rad,
                const Candidate& line) const {
    const Spot& begin = (*points_)[from];
    const Spot& end = (*points_)[to];
    if (!space_->CanTurn(begin, yaw_rad, line.yaw_rad)) return false;
    const std::optional<Spot> driven = space_->Drive(begin, end.at);
    return driven.has_value() && driven->level == end.level &&
           (!IsLast(*points_, to) ||
            space_->CanTurn(end, line.yaw_rad, goal_yaw_rad_));
  }

 private:
  const ConfigurationSpace* space_;
  double goal_yaw_rad_;
  const Polyline* points_;
};

}  // namespace

namespace {

// A guide that is followed, point by point.
class Follower {
 public:
  Follower(const ConfigurationSpace& space, double start_yaw_rad,
           double goal_yaw_rad, Polyline points, const GuideBridge& bridge)
      : space_(&space),
        bridge_(&bridge),
        goal_yaw_rad_(goal_yaw_rad),
        points_(std::move(points)),
        lines_(space, goal_yaw_rad, points_),
        yaw_rad_(start_yaw_rad),
        turns_(points_.size(), kUnknown) {}

  PulledWay Run() {
    PulledWay pulled{
        .way = {points_.front()}, .is_whole = false, .reached = {}};
    while (at_ + 1 < points_.size() &&
           (TakeLine(pulled.way) || TakeWindingLines(pulled.way) ||
            TakeBridge(pulled.way))) {
    }
    pulled.is_whole = at_ + 1 == points_.size();
    pulled.reached = points_[at_];
    return pulled;
  }
  // Up to which point it has come.
  size_t at() const { return at_; }

 private:
  static constexpr uint8_t kUnknown = 0;
  static constexpr uint8_t kCan = 1;
  static constexpr uint8_t kCannot = 2;

  bool MayEndAt(size_t point) {
    if (PullLines::IsLast(points_, point)) return true;
    if (turns_[point] == kUnknown) {
      turns_[point] = space_->FitsTurning(points_[point]) ? kCan : kCannot;
    }
    return turns_[point] == kCan;
  }

  bool CanDriveTo(size_t to) {
    const Candidate line = lines_.LineOf(at_, to);
    return line.length_m > 1e-6 && MayEndAt(to) &&
           lines_.CanDrive(at_, to, yaw_rad_, line);
  }

  void GoTo(size_t to, Polyline& way) {
    yaw_rad_ = lines_.LineOf(at_, to).yaw_rad;
    at_ = to;
    way.push_back(points_[to]);
  }

  // One line: ever further, until something is in the way; then halves of the
  // rest.
  bool TakeLine(Polyline& way) {
    size_t best = at_;
    size_t beyond = points_.size();
    for (size_t stride = 1; at_ + stride < beyond; stride *= 2) {
      if (CanDriveTo(at_ + stride)) {
        best = at_ + stride;
      } else if (best > at_ || stride >= kTryAhead) {
        beyond = at_ + stride;
      }
    }
    if (beyond == points_.size() && CanDriveTo(beyond - 1)) best = beyond - 1;
    while (best > at_ && best + 1 < beyond) {
      const size_t middle = (best + beyond) / 2;
      (CanDriveTo(middle) ? best : beyond) = middle;
    }
    if (best == at_) return false;
    GoTo(best, way);
    return true;
  }

  // Several lines, over points where it cannot turn right round, to the next
  // one where it can.
  bool TakeWindingLines(Polyline& way) {
    struct Reached {
      double cost_m = std::numeric_limits<double>::infinity();
      double yaw_rad = 0;
      size_t parent = 0;
    };
    const size_t end =
        std::min(points_.size(), at_ + size_t{kPullAhead.value} + 1);
    std::vector<Reached> reached(end - at_);
    reached[0] = {.cost_m = 0, .yaw_rad = yaw_rad_, .parent = at_};
    for (size_t i = at_; i < end; ++i) {
      const Reached from = reached[i - at_];
      if (!std::isfinite(from.cost_m)) continue;
      if (i > at_ && MayEndAt(i)) {
        std::vector<size_t> passed;
        for (size_t k = i; k > at_; k = reached[k - at_].parent) {
          passed.push_back(k);
        }
        for (auto k = passed.rbegin(); k != passed.rend(); ++k) GoTo(*k, way);
        return true;
      }
      for (size_t k = i + 1; k < std::min(end, i + kTryAhead + 1); ++k) {
        const Candidate line = lines_.LineOf(i, k);
        Reached& to = reached[k - at_];
        const double cost_m = from.cost_m + line.length_m +
                              TurnCost_m(from.yaw_rad, line.yaw_rad);
        if (!(line.length_m > 1e-6) || cost_m >= to.cost_m ||
            !lines_.CanDrive(i, k, from.yaw_rad, line)) {
          continue;
        }
        to = {.cost_m = cost_m, .yaw_rad = line.yaw_rad, .parent = i};
      }
    }
    return false;
  }

  // Another way to a point beyond the narrow place.
  bool TakeBridge(Polyline& way) {
    const size_t end =
        std::min(points_.size(), at_ + size_t{kPullAhead.value} + 1);
    bool is_narrow = false;
    for (size_t to = at_ + 1; to < end; ++to) {
      is_narrow = is_narrow || !MayEndAt(to);
      const bool is_far = to >= at_ + kTryAhead;
      if (!MayEndAt(to) ||
          !(is_far || is_narrow || PullLines::IsLast(points_, to))) {
        continue;
      }
      // Where it can turn right round, any heading will do.
      const double yaw_rad = PullLines::IsLast(points_, to)
                                 ? goal_yaw_rad_
                                 : lines_.LineOf(to - 1, to).yaw_rad;
      const Polyline other =
          (*bridge_)({.spot = points_[at_], .yaw_rad = yaw_rad_},
                     {.spot = points_[to], .yaw_rad = yaw_rad});
      if (other.size() > 1) {
        way.insert(way.end(), other.begin() + 1, other.end());
        yaw_rad_ = yaw_rad;
        at_ = to;
        return true;
      }
      if (is_far) return false;
      // Further on there may be more room.
      to += kTryAhead / 2;
    }
    return false;
  }

  const ConfigurationSpace* space_;
  const GuideBridge* bridge_;
  double goal_yaw_rad_;
  Polyline points_;
  PullLines lines_;
  double yaw_rad_;
  size_t at_ = 0;
  std::vector<uint8_t> turns_;
};

}  // namespace

PulledWay FollowGuide(const ConfigurationSpace& space, double start_yaw_rad,
                      double goal_yaw_rad, const Polyline& points,
                      double spacing_m, const GuideBridge& bridge) {
  const Polyline thin = Thinned(space, points, spacing_m);
  Polyline centered = thin;
  Center(space, centered);
  Follower in_middle(space, start_yaw_rad, goal_yaw_rad, std::move(centered),
                     bridge);
  PulledWay pulled = in_middle.Run();
  if (pulled.is_whole) return pulled;
  // Where walls are not parallel the middle may be worse.
  Follower as_given(space, start_yaw_rad, goal_yaw_rad, thin, bridge);
  PulledWay other = as_given.Run();
  return other.is_whole || as_given.at() > in_middle.at() ? other : pulled;
}

PulledWay PullTight(const ConfigurationSpace& space, double start_yaw_rad,
                    double goal_yaw_rad, const Polyline& points,
                    double spacing_m) {
  const Polyline thin = Thinned(space, points, spacing_m);
  const PullLines lines(space, goal_yaw_rad, thin);
  struct Best {
    double cost_m = std::numeric_limits<double>::infinity();
    double yaw_rad = 0;
    size_t parent = 0;
  };
  std::vector<Best> best(thin.size());
  best[0] = {.cost_m = 0, .yaw_rad = start_yaw_rad};
  size_t reached = 0;
  for (size_t i = 0; i + 1 < thin.size(); ++i) {
    if (!std::isfinite(best[i].cost_m)) continue;
    reached = i;
    for (size_t k = std::min(thin.size() - 1, i + size_t{kPullAhead.value});
         k > i; --k) {
      const Candidate line = lines.LineOf(i, k);
      // A line costs no less than its length.
      if (!(line.length_m > 1e-6) ||
          best[i].cost_m + line.length_m >= best[k].cost_m) {
        continue;
      }
      double cost_m = best[i].cost_m +
                      TurnCost_m(best[i].yaw_rad, line.yaw_rad) +
                      space.LineCost_m(thin[i], thin[k]);
      if (PullLines::IsLast(thin, k)) {
        cost_m += TurnCost_m(line.yaw_rad, goal_yaw_rad);
      }
      if (cost_m >= best[k].cost_m ||
          !lines.CanDrive(i, k, best[i].yaw_rad, line)) {
        continue;
      }
      best[k] = {.cost_m = cost_m, .yaw_rad = line.yaw_rad, .parent = i};
    }
  }
  PulledWay pulled{.way = {},
                   .is_whole = std::isfinite(best.back().cost_m),
                   .reached = thin[reached]};
  for (size_t i = pulled.is_whole ? thin.size() - 1 : reached; i > 0;
       i = best[i].parent) {
    pulled.way.push_back(thin[i]);
  }
  pulled.way.push_back(thin.front());
  std::ranges::reverse(pulled.way);
  return pulled;
}

Polyline ShortcutPolyline(const ConfigurationSpace& space, double start_yaw_rad,
                          double goal_yaw_rad, const Polyline& points,
                          double spacing_m) {
  PulledWay pulled =
      PullTight(space, start_yaw_rad, goal_yaw_rad, points, spacing_m);
  return pulled.is_whole ? std::move(pulled.way) : Polyline();
}

}  // namespace treeline::planning
