#include "nav_agent/behavior/parting_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <queue>
#include <utility>

#include "nav_agent/behavior/parameters.h"

namespace treeline::behavior {
namespace {

constexpr double kSquare_m = localization::kSearchGrid_m;
constexpr int kReach = static_cast<int>(kPartingReach_m / kSquare_m);
constexpr int kWidth = 2 * kReach + 1;
constexpr int kMiddle = kReach * kWidth + kReach;
// Views are a metre apart.
constexpr double kViewsApart_m = 1;
constexpr int kViewSquares = static_cast<int>(kViewsApart_m / kSquare_m);
constexpr size_t kViewsAtOnce = 8;
// What two scans differ by, at places that the map explains equally well.
constexpr double kAlikeRange_m = 2 * localization::kRangeTolerance_m;
constexpr double kAlikeRangeShare = 2 * localization::kRangeToleranceShare;

constexpr std::array<std::pair<int, int>, 8> kNeighbours = {
    {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {1, -1}, {-1, 1}, {-1, -1}}};

double DifferingShare(const std::vector<float>& a,
                      const std::vector<float>& b) {
  const size_t beams = std::min(a.size(), b.size());
  size_t compared = 0;
  size_t differing = 0;
  for (size_t i = 0; i < beams; ++i) {
    if (std::isnan(a[i]) || std::isnan(b[i])) continue;
    ++compared;
    const double nearer_m = std::min(a[i], b[i]);
    if (std::abs(a[i] - b[i]) > kAlikeRange_m + kAlikeRangeShare * nearer_m) {
      ++differing;
    }
  }
  // Of the rest nothing is known.
  return beams == 0 || 4 * compared < beams
             ? 0
             : static_cast<double>(differing) / static_cast<double>(beams);
}

}  // namespace

PartingView::PartingView(const traversability::NavigationMap& map,
                         std::vector<localization::PossiblePlace> places,
                         const geometry::Rigid2& odom_from_base,
                         const std::vector<geometry::Vec2>& obstacles_in_odom,
                         std::vector<geometry::Vec2> seen_from_in_odom,
                         double radius_m)
    : places_(std::move(places)),
      odom_from_base_(odom_from_base),
      seen_from_in_odom_(std::move(seen_from_in_odom)),
      squares_(kWidth * kWidth),
      is_blocked_(kWidth * kWidth) {
  std::ranges::stable_sort(places_, std::greater(),
                           &localization::PossiblePlace::share);
  if (places_.size() > kPartingPlaces) places_.resize(kPartingPlaces);
  MarkObstacles(obstacles_in_odom, radius_m);
  Spread(map, radius_m);
  for (int y = 0; y < kWidth; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const int square = y * kWidth + x;
      if (square == kMiddle || (x - kReach) % kViewSquares != 0 ||
          (y - kReach) % kViewSquares != 0) {
        continue;
      }
      if (squares_[static_cast<size_t>(square)].is_reached) {
        views_.push_back(square);
      }
    }
  }
}

geometry::Vec2 PartingView::InOdom(int square) const {
  return odom_from_base_.translation +
         geometry::Vec2{kSquare_m * (square % kWidth - kReach),
                        kSquare_m * (square / kWidth - kReach)};
}

core::LevelPose PartingView::PoseAt(size_t place, int square) const {
  const geometry::Rigid2 map_from_odom =
      places_[place].pose.map_from_base * odom_from_base_.Inverse();
  core::LevelPose pose = places_[place].pose;
  pose.map_from_base.translation = map_from_odom * InOdom(square);
  const Square& there = squares_[static_cast<size_t>(square)];
  if (place < there.ground.size()) pose.place = there.ground[place];
  return pose;
}

void PartingView::MarkObstacles(
    const std::vector<geometry::Vec2>& obstacles_in_odom, double radius_m) {
  const int reach = static_cast<int>(radius_m / kSquare_m) + 1;
  for (const geometry::Vec2& obstacle : obstacles_in_odom) {
    const geometry::Vec2 off = obstacle - odom_from_base_.translation;
    const int at_x = static_cast<int>(std::lround(off.x / kSquare_m)) + kReach;
    const int at_y = static_cast<int>(std::lround(off.y / kSquare_m)) + kReach;
    for (int y = at_y - reach; y <= at_y + reach; ++y) {
      for (int x = at_x - reach; x <= at_x + reach; ++x) {
        if (x < 0 || y < 0 || x >= kWidth || y >= kWidth) continue;
        const int square = y * kWidth + x;
        if (geometry::Norm(InOdom(square) - obstacle) < radius_m) {
          is_blocked_[static_cast<size_t>(square)] = 1;
        }
      }
    }
  }
}

// All places have ground there that goes on from where they had it before, with
// room for the robot; near where it stands it has got that room.
bool PartingView::StepOnto(const traversability::NavigationMap& map,
                           double radius_m, int from, int to) {
  const bool is_near = geometry::Norm(InOdom(to) - InOdom(kMiddle)) < radius_m;
  std::vector<core::LevelPlace> ground;
  for (size_t i = 0; i < places_.size(); ++i) {
    const geometry::Vec2 at = PoseAt(i, to).map_from_base.translation;
    const core::LevelPlace& before =
        squares_[static_cast<size_t>(from)].ground[i];
    const std::optional<core::LevelPlace> place =
        map.GroundNear(at, before.height_m);
    if (!place.has_value() ||
        (!is_near && map.Clearance_m(place->level, at) < radius_m)) {
      return false;
    }
    ground.push_back(*place);
  }
  squares_[static_cast<size_t>(to)].ground = std::move(ground);
  return true;
}

void PartingView::Spread(const traversability::NavigationMap& map,
                         double radius_m) {
  using Open = std::pair<double, int>;
  std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
  Square& middle = squares_[kMiddle];
  for (const localization::PossiblePlace& place : places_) {
    middle.ground.push_back(place.pose.place);
  }
  middle.is_reached = true;
  open.emplace(0, kMiddle);
  while (!open.empty()) {
    const auto [way_m, from] = open.top();
    open.pop();
    if (way_m > squares_[static_cast<size_t>(from)].way_m) continue;
    for (const auto& [dx, dy] : kNeighbours) {
      const int x = from % kWidth + dx;
      const int y = from / kWidth + dy;
      if (x < 0 || y < 0 || x >= kWidth || y >= kWidth) continue;
      const int to = y * kWidth + x;
      Square& square = squares_[static_cast<size_t>(to)];
      const double there_m = way_m + kSquare_m * std::hypot(dx, dy);
      if (is_blocked_[static_cast<size_t>(to)] != 0 ||
          (square.is_reached && square.way_m <= there_m)) {
        continue;
      }
      if (!square.is_reached && !StepOnto(map, radius_m, from, to)) continue;
      square.is_reached = true;
      square.way_m = there_m;
      square.from = from;
      open.emplace(there_m, to);
    }
  }
}

std::vector<double> PartingView::Differences(
    const localization::RobotTracker& tracker, int square) const {
  std::vector<std::vector<float>> scans;
  scans.reserve(places_.size());
  for (size_t i = 0; i < places_.size(); ++i) {
    scans.push_back(tracker.ExpectedRanges_m(PoseAt(i, square), kPartingBeams));
  }
  std::vector<double> differences;
  for (size_t i = 0; i < scans.size(); ++i) {
    for (size_t k = i + 1; k < scans.size(); ++k) {
      differences.push_back(DifferingShare(scans[i], scans[k]));
    }
  }
  return differences;
}

double PartingView::Gain(const std::vector<double>& differences) const {
  double gain = 0;
  double doubt = 0;
  size_t pair = 0;
  for (size_t i = 0; i < places_.size(); ++i) {
    for (size_t k = i + 1; k < places_.size(); ++k, ++pair) {
      const double weight = places_[i].share * places_[k].share;
      doubt += weight;
      // What shows here was not enough.
      const double more = std::max(0.0, differences[pair] - here_[pair]);
      gain += weight * (1 - std::exp(-more / kPartingShare));
    }
  }
  return doubt > 0 ? gain / doubt : 0;
}

bool PartingView::WasSeenFrom(int square) const {
  const geometry::Vec2 at = InOdom(square);
  return std::ranges::any_of(seen_from_in_odom_, [&at](geometry::Vec2 before) {
    return geometry::Norm(at - before) < kViewsApart_m;
  });
}

bool PartingView::Step(const localization::RobotTracker& tracker) {
  if (here_.empty()) here_ = Differences(tracker, kMiddle);
  const size_t end = std::min(views_.size(), next_ + kViewsAtOnce);
  for (; next_ < end; ++next_) {
    const int view = views_[next_];
    const double gain = Gain(Differences(tracker, view)) *
                        (WasSeenFrom(view) ? kKnownWorth.value : 1.0);
    const double worth =
        gain - kPartingCost_per_m * squares_[static_cast<size_t>(view)].way_m;
    if (gain < kMinPartingGain || (best_ >= 0 && worth <= best_worth_)) {
      continue;
    }
    best_ = view;
    best_worth_ = worth;
    best_gain_ = gain;
  }
  return next_ >= views_.size();
}

bool PartingView::IsStraightFree(int from, int to) const {
  const int x = from % kWidth;
  const int y = from / kWidth;
  const int over_x = to % kWidth - x;
  const int over_y = to / kWidth - y;
  const int steps = 2 * std::max(std::abs(over_x), std::abs(over_y));
  for (int i = 1; i < steps; ++i) {
    const double part = static_cast<double>(i) / steps;
    const int at_x = x + static_cast<int>(std::lround(part * over_x));
    const int at_y = y + static_cast<int>(std::lround(part * over_y));
    if (!squares_[static_cast<size_t>(at_y * kWidth + at_x)].is_reached) {
      return false;
    }
  }
  return true;
}

std::optional<PartingLeg> PartingView::leg() const {
  if (best_ < 0) return std::nullopt;
  // The furthest square of the way that is straight ahead.
  int to = best_;
  while (squares_[static_cast<size_t>(to)].from != kMiddle &&
         !IsStraightFree(kMiddle, to)) {
    to = squares_[static_cast<size_t>(to)].from;
  }
  const geometry::Vec2 way = InOdom(to) - odom_from_base_.translation;
  return PartingLeg{.yaw_rad = std::atan2(way.y, way.x),
                    .way_m = geometry::Norm(way),
                    .gain = best_gain_};
}

}  // namespace treeline::behavior
