#include "tests/traversable_worlds/best_known.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <queue>
#include <utility>

#include "common/base/processor_time.h"
#include "common/base/random.h"
#include "nav_agent/planning/guide.h"
#include "nav_agent/planning/lattice.h"
#include "nav_agent/planning/path_smoother.h"

namespace treeline {
namespace {

using planning::Polyline;
using planning::Spot;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
// A way is as short as can be after so many attempts without a gain, for each
// of its points and at least.
constexpr int kIdleAPoint = 60;
constexpr int kIdleAtLeast = 3000;
// Of points that are pulled tight (m).
constexpr double kSpacing_m = 0.1;
// Places in a cell are so many cells aside of its middle.
constexpr double kAside = 0.45;
constexpr int kHeadings = 32;
// Ways longer than the bound by this are looked for in the lattice, too: all of
// it, since what is left to go is guessed up to 8 % too long.
constexpr double kNearBound = 1.01;
constexpr double kAdmissible = 0.92;
constexpr double kLattice_ms = 20e3;
// Ends that a plan moves by more are other ends (m).
constexpr double kSameEnd_m = 1e-6;

planning::ConfigurationSpace SpaceOf(const planning::PlanGround& ground,
                                     const planning::WayPrices& prices) {
  return planning::ConfigurationSpace(ground.index, ground.footprint, {})
      .WithPrices(prices);
}

// Whether the footprint fits somewhere in a cell, with some heading, as far as
// 9 places and 32 headings tell.
bool HoldsFootprint(const planning::ConfigurationSpace& space,
                    core::CellIndex cell) {
  const geometry::Vec2 center = space.ground().CenterOf(cell);
  if (!space.MayHoldDisc({center, 0})) return false;
  for (int place = 0; place < 9; ++place) {
    // The middle first.
    const int at = (place + 4) % 9;
    const geometry::Vec2 aside = {(at % 3 - 1) * kAside, (at / 3 - 1) * kAside};
    const Spot spot = {center + space.ground().resolution_m() * aside, 0};
    for (int heading = 0; heading < kHeadings; ++heading) {
      if (space.Fits(spot, 2 * std::numbers::pi * heading / kHeadings)) {
        return true;
      }
    }
  }
  return false;
}

struct OpenCorner {
  double estimate_m = 0;
  size_t number = 0;
  bool operator<(const OpenCorner& other) const {
    return estimate_m > other.estimate_m;
  }
};

// Where a closed line crosses the middles of a row's cells (x in cells), and
// which way.
struct Crossing {
  double x = 0;
  int sign = 0;
};

std::vector<Crossing> CrossingsOf(const Polyline& loop, double resolution_m,
                                  int row) {
  const double y = (row + 0.5) * resolution_m;
  std::vector<Crossing> crossings;
  for (size_t i = 0; i < loop.size(); ++i) {
    const geometry::Vec2 from = loop[i].at;
    const geometry::Vec2 to = loop[(i + 1) % loop.size()].at;
    if ((from.y <= y) == (to.y <= y)) continue;
    const double t = (y - from.y) / (to.y - from.y);
    crossings.push_back({(from.x + t * (to.x - from.x)) / resolution_m,
                         to.y > from.y ? 1 : -1});
  }
  std::ranges::sort(crossings, {}, &Crossing::x);
  return crossings;
}

// Whether a closed line of one level runs round anything that is blocked.
bool Encloses(const planning::GroundIndex& index, const Polyline& loop) {
  for (int row = 0; row < index.height(); ++row) {
    int winds = 0;
    const std::vector<Crossing> crossings =
        CrossingsOf(loop, index.resolution_m(), row);
    for (size_t i = 0; i + 1 < crossings.size(); ++i) {
      winds += crossings[i].sign;
      if (winds == 0) continue;
      for (int x = static_cast<int>(std::ceil(crossings[i].x - 0.5));
           x + 0.5 < crossings[i + 1].x; ++x) {
        if (!(index.Clearance_m(loop.front().level, {x, row}) > 0)) return true;
      }
    }
  }
  return false;
}

}  // namespace

PointWay::PointWay(const planning::PlanGround& ground)
    : resolution_m_(ground.index->resolution_m()) {
  const planning::ConfigurationSpace space = SpaceOf(ground, {});
  traversability::TraversableMap levels;
  levels.levels.push_back(ground.index->map().traversable().levels[0]);
  core::OccupancyGrid& grid = levels.levels[0].grid;
  std::vector<bool> holds(grid.cells.size());
  const auto may_hold = [&](int x, int y) {
    return holds[ground.index->IndexOf({x, y})];
  };
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const size_t cell = ground.index->IndexOf({x, y});
      holds[cell] = HoldsFootprint(space, {x, y});
      grid.cells[cell] =
          holds[cell] ? core::Occupancy::kFree : core::Occupancy::kOccupied;
    }
  }
  // Ways bend only at corners that stick out: one of the four cells about them
  // is blocked, or two that face each other.
  for (int y = 1; y < grid.height; ++y) {
    for (int x = 1; x < grid.width; ++x) {
      const bool a = may_hold(x - 1, y - 1);
      const bool b = may_hold(x, y - 1);
      const bool c = may_hold(x - 1, y);
      const bool d = may_hold(x, y);
      const int open = int{a} + int{b} + int{c} + int{d};
      if (open == 3 || (open == 2 && a == d)) {
        corners_.push_back({x * resolution_m_, y * resolution_m_});
      }
    }
  }
  auto map = traversability::NavigationMap::Make(std::move(levels));
  if (!map.ok()) std::abort();
  index_ = std::make_unique<planning::GroundIndex>(
      std::make_shared<const traversability::NavigationMap>(*std::move(map)));
}

bool PointWay::Sees(geometry::Vec2 from, geometry::Vec2 to) const {
  const geometry::Vec2 line = to - from;
  const double length_m = geometry::Norm(line);
  return length_m < 1e-9 || index_->IsFree(0, {.origin = from,
                                               .cos_yaw = line.x / length_m,
                                               .sin_yaw = line.y / length_m,
                                               .back_m = 0,
                                               .front_m = length_m,
                                               .half_width_m = 0});
}

Polyline PointWay::Find(geometry::Vec2 start, geometry::Vec2 goal,
                        double max_m) const {
  std::vector<geometry::Vec2> at = {start, goal};
  for (const geometry::Vec2& corner : corners_) {
    if (geometry::Norm(corner - start) + geometry::Norm(goal - corner) <=
        max_m) {
      at.push_back(corner);
    }
  }
  std::vector<double> cost_m(at.size(), kInfinite);
  std::vector<size_t> parent(at.size(), 0);
  std::vector<bool> is_done(at.size(), false);
  std::priority_queue<OpenCorner> open;
  cost_m[0] = 0;
  open.push({geometry::Norm(goal - start), 0});
  while (!open.empty() && !is_done[1]) {
    const size_t from = open.top().number;
    open.pop();
    if (is_done[from]) continue;
    is_done[from] = true;
    for (size_t to = 1; to < at.size(); ++to) {
      const double sum_m = cost_m[from] + geometry::Norm(at[to] - at[from]);
      if (is_done[to] || sum_m >= cost_m[to] ||
          sum_m + geometry::Norm(goal - at[to]) > max_m ||
          !Sees(at[from], at[to])) {
        continue;
      }
      cost_m[to] = sum_m;
      parent[to] = from;
      open.push({sum_m + geometry::Norm(goal - at[to]), to});
    }
  }
  Polyline way;
  if (!is_done[1]) return way;
  for (size_t i = 1; i != 0; i = parent[i]) way.push_back({at[i], 0});
  way.push_back({start, 0});
  std::ranges::reverse(way);
  return way;
}

BestKnown::BestKnown(const planning::PlanGround& ground, const PointWay& point,
                     const planning::GlobalPlanner& planner,
                     const planning::PlanRequest& request, int rounds,
                     double plan_s)
    : ground_(&ground),
      request_(request),
      comfortable_(SpaceOf(ground, {})),
      plain_(SpaceOf(ground, {.near = 0, .slope = 0})),
      length_m_(kInfinite) {
  const base::ThreadProcessorClock clock;
  planning::PlanRequest other = request;
  for (int round = 0; round < rounds; ++round) {
    other.seed += 7919;
    const auto result = planner.Plan(other,
                                     {.max_iterations = 1'000'000'000,
                                      .max_time_s = plan_s,
                                      .improves = true,
                                      .clock = &clock},
                                     {});
    if (result.ok()) Offer(WayOf(*result));
  }
  if (ground.index->levels() > 1) return;
  const planning::Stand start = planning::StandOf(*ground.index, request.start);
  const planning::Stand goal = planning::StandOf(*ground.index, request.goal);
  const Polyline shortest =
      point.Find(start.spot.at, goal.spot.at, length_m_ + kSameEnd_m);
  if (shortest.empty()) return;
  bound_m_ = planning::PathLength_m(shortest);
  planning::PulledWay pulled = planning::PullTight(
      plain_, start.yaw_rad, goal.yaw_rad, shortest, kSpacing_m);
  if (!pulled.is_whole) {
    pulled = planning::FollowGuide(
        plain_, start.yaw_rad, goal.yaw_rad, shortest, kSpacing_m,
        [](const planning::Stand&, const planning::Stand&) {
          return Polyline();
        });
  }
  if (pulled.is_whole) Offer(std::move(pulled.way));
  if (length_m_ <= kNearBound * bound_m_) return;
  const double before_ms = base::ThreadProcessorTime_ms();
  Offer(planning::SearchLattice(
      plain_, *ground.regions, start, goal,
      [before_ms] {
        return base::ThreadProcessorTime_ms() - before_ms > kLattice_ms;
      },
      kAdmissible));
}

Polyline BestKnown::WayOf(const planning::PlanResult& result) const {
  Polyline way;
  if (result.failure != core::NavigationCause::kNone ||
      result.moved_start_m > kSameEnd_m || result.moved_goal_m > kSameEnd_m) {
    return way;
  }
  for (const core::LevelPose& pose : result.path) {
    way.push_back(planning::StandOf(*ground_->index, pose).spot);
  }
  return way;
}

Polyline BestKnown::Polished(const planning::ConfigurationSpace& space,
                             const Polyline& way) const {
  const planning::Stand start =
      planning::StandOf(*ground_->index, request_.start);
  const planning::Stand goal =
      planning::StandOf(*ground_->index, request_.goal);
  Polyline pulled = planning::ShortcutPolyline(space, start.yaw_rad,
                                               goal.yaw_rad, way, kSpacing_m);
  planning::PathSmoother smoother(space, start.yaw_rad, goal.yaw_rad,
                                  pulled.size() > 1 ? pulled : way);
  uint64_t draw = 0;
  for (int idle = 0;
       idle < std::max(kIdleAtLeast,
                       kIdleAPoint * static_cast<int>(smoother.way().size()));
       ++draw) {
    base::Random random(request_.seed, draw);
    idle = smoother.Try(random) ? 0 : idle + 1;
  }
  return smoother.way();
}

void BestKnown::Offer(Polyline way) {
  if (way.size() < 2) return;
  way = Polished(plain_, way);
  const double length_m = planning::PathLength_m(way);
  if (length_m >= length_m_) return;
  length_m_ = length_m;
  best_ = std::move(way);
}

ExcessOf BestKnown::Excess(const planning::PlanResult& result) const {
  const Polyline way = WayOf(result);
  if (way.size() < 2 || best_.size() < 2) return {};
  const auto percent = [this](double more_m) {
    return 100 * more_m / length_m_;
  };
  const double own_m = result.length_m;
  const double plain_m = planning::PathLength_m(Polished(plain_, way));
  const double cheap_m = planning::PathLength_m(Polished(comfortable_, way));
  Polyline loop = way;
  loop.insert(loop.end(), best_.rbegin(), best_.rend());
  return {.total = percent(own_m - length_m_),
          .other_side = percent(plain_m - length_m_),
          .comfort = percent(cheap_m - plain_m),
          .slack = percent(own_m - cheap_m),
          .is_other_side =
              ground_->index->levels() == 1 && Encloses(*ground_->index, loop)};
}

}  // namespace treeline
