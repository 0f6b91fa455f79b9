#include "nav_agent/planning/variable_rrt_planner.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "common/base/clock.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "nav_agent/planning/alternatives.h"
#include "nav_agent/planning/guide.h"
#include "nav_agent/planning/lattice.h"
#include "nav_agent/planning/path_smoother.h"
#include "nav_agent/planning/plan_clock.h"
#include "nav_agent/planning/planner_parameters.h"
#include "nav_agent/planning/routes.h"

namespace treeline::planning {
namespace {

// Streams of random numbers; restarts follow.
constexpr uint64_t kImprovements = 1;
constexpr uint64_t kBridges = 2;
constexpr uint64_t kFirstTree = 3;
// Of a way's cost, that a gain leaves.
constexpr double kKept = 1 - kRestartGain;
constexpr uint64_t kTries{kRestartTries.value};

// The work on one request.
class Planning {
 public:
  Planning(const PlanTask& task, uint64_t seed, const PlanBudget& budget,
           const std::stop_token& stop, base::MonotonicTime begin)
      : task_(&task),
        seed_(seed),
        budget_(budget),
        stop_(&stop),
        begin_(begin),
        plain_(task.space.WithPrices({.near = 0, .slope = 0})) {}

  // Leaves a way, or why there is none, in the result.
  void FindFirst(PlanResult& result);
  // The same, and nothing is left out: what it does not find is not there.
  void FindThoroughly(PlanResult& result);
  void Improve(PlanResult& result);
  const Polyline& way() const { return way_; }

 private:
  double Elapsed_s() const {
    return base::SecondsBetween(begin_, ClockOf(budget_).Now());
  }
  // Whether the time that what is under way may take is over.
  bool IsOver() const {
    return stop_->stop_requested() ||
           Elapsed_s() >= share_ * budget_.max_time_s;
  }
  // Anywhere in the area of start and goal; near the guide if there is one.
  Spot SampleOf(uint64_t stream, uint64_t iteration) const;
  // Tries routes over regions with the footprint, each round the places where
  // those before it got stuck; so far as they came is planted in the trees.
  bool FollowRoutes(VariableRrt& trees, bool is_thorough);
  // A way from one stand to another one near by: two trees between them, and
  // where those do not meet soon the lattice, if it is to be thorough.
  Polyline Bridge(const Stand& from, const Stand& to, bool is_thorough);
  // Whether no way was found from near the one to near the other.
  bool IsKnownNarrow(const Spot& from, const Spot& to) const;
  // Makes the regions around a place cost more.
  void Discourage(const Spot& stuck, std::vector<float>& weights) const;
  double Spacing_m() const {
    return std::max(kGuideSpacing_m.value,
                    task_->space.ground().resolution_m());
  }
  // The same, of iterations too.
  bool IsUsed(const PlanResult& result) const;
  // Cuts and moves until so many in a row gain nothing.
  void Polish(PathSmoother& improver, int max_idle, PlanResult& result);
  void PolishWell(PathSmoother& improver, PlanResult& result);
  // Puts another way, polished, in the place of the best if it is shorter.
  void TryOther(Polyline other, PathSmoother& best, PlanResult& result);
  // That over a guide; whether the footprint can follow it.
  bool TryGuide(const Polyline& guide, bool is_thorough, PathSmoother& best,
                PlanResult& result);
  // Those round other sides of things; narrow ones last.
  void TryAlternatives(PathSmoother& best, PlanResult& result);
  // A way of another tree, of those that might be shorter.
  Polyline Restart(uint64_t stream, double bound_m, PlanResult& result) const;
  // Ways as short as they get: lengths alone count.
  void Shorten(PathSmoother& best, PlanResult& result);
  // Of the short ways, the cheapest; made cheaper, and hardly longer.
  void Comfort(double shortest_m, PlanResult& result);

  const PlanTask* task_;
  uint64_t seed_;
  PlanBudget budget_;
  const std::stop_token* stop_;
  base::MonotonicTime begin_;
  // A metre costs a metre.
  ConfigurationSpace plain_;
  // What of the budget may be used before what is under way ends.
  double share_ = 1;
  std::optional<Polyline> guide_;
  Polyline way_;
  // Where the lattice found no way through.
  struct NarrowPlace {
    Spot from;
    Spot to;
  };
  std::vector<NarrowPlace> too_narrow_;
  // Others that are hardly longer than the best one was.
  std::vector<Polyline> others_;
};

Spot Planning::SampleOf(uint64_t stream, uint64_t iteration) const {
  base::Random random(seed_ + (stream << 32), iteration);
  if (random.NextBelow(uint32_t{kGoalEvery.value}) == 0) {
    return iteration % 2 == 0 ? task_->goal.spot : task_->start.spot;
  }
  if (guide_.has_value() &&
      random.NextBelow(uint32_t{kAnywhereEvery.value}) != 0) {
    Spot near =
        (*guide_)[random.NextBelow(static_cast<uint32_t>(guide_->size()))];
    if (random.NextBelow(2) == 0) {
      near.at =
          near.at + geometry::Vec2{kGuideSpacing_m * random.NextGaussian(),
                                   kGuideSpacing_m * random.NextGaussian()};
    }
    return near;
  }
  const GroundIndex& ground = task_->space.ground();
  const size_t number = task_->regions->DrawCell(ground, task_->area, random);
  const size_t cell = number % ground.cells();
  const auto width = static_cast<size_t>(ground.width());
  const double x = static_cast<double>(cell % width) + random.NextUnit();
  const double y = static_cast<double>(cell / width) + random.NextUnit();
  return {.at = ground.resolution_m() * geometry::Vec2{x, y},
          .level = static_cast<int>(number / ground.cells())};
}

bool Planning::FollowRoutes(VariableRrt& trees, bool is_thorough) {
  const Regions& regions = *task_->regions;
  const GroundIndex& ground = task_->space.ground();
  std::vector<float> weights(regions.count(), 1.0F);
  for (int i = 0; i < kRouteAttempts + kBridgedAttempts && !IsOver(); ++i) {
    const Stand from = trees.Hub(false);
    const Stand to = trees.Hub(true);
    const int start = regions.RegionOf(ground, from.spot);
    const int goal = regions.RegionOf(ground, to.spot);
    if (start < 0 || goal < 0) return false;
    const Route route = FindRoute(regions, static_cast<uint32_t>(start),
                                  static_cast<uint32_t>(goal), weights);
    if (!route.is_found) return false;
    Polyline guide =
        CellsAlong(task_->space, regions, from.spot, to.spot, route);
    const PulledWay pulled = FollowGuide(
        task_->space, from.yaw_rad, to.yaw_rad, guide, Spacing_m(),
        [this, i, is_thorough](const Stand& begin, const Stand& end) {
          return i < kRouteAttempts ? Polyline()
                                    : Bridge(begin, end, is_thorough);
        });
    if (!guide_.has_value()) guide_ = std::move(guide);
    if (trees.Plant(pulled.way)) return true;
    Discourage(pulled.reached, weights);
  }
  return false;
}

Polyline Planning::Bridge(const Stand& from, const Stand& to,
                          bool is_thorough) {
  if (IsOver()) return {};
  if (is_thorough && IsKnownNarrow(from.spot, to.spot)) return {};
  const geometry::Vec2 line = to.spot.at - from.spot.at;
  const double length_m = geometry::Norm(line);
  VariableRrt trees(task_->space, from, to);
  const auto sample = [&](uint64_t iteration) {
    base::Random random(seed_ + (kBridges << 32), iteration);
    const geometry::Vec2 at =
        from.spot.at + random.NextUniform(-0.2, 1.2) * line;
    const double reach_m = kBridgeSpread * length_m;
    return Spot{at + geometry::Vec2{reach_m * random.NextGaussian(),
                                    reach_m * random.NextGaussian()},
                random.NextBelow(2) == 0 ? from.spot.level : to.spot.level};
  };
  if (trees.Grow(kBridgeIterations, sample, [this] { return IsOver(); })) {
    return trees.Way();
  }
  if (!is_thorough ||
      task_->regions->RegionOf(task_->space.ground(), from.spot) < 0 ||
      task_->regions->RegionOf(task_->space.ground(), to.spot) < 0) {
    return {};
  }
  Polyline way = SearchLatticeNear(task_->space, *task_->regions, from, to,
                                   2 * length_m + kLastLine_m, kBridgeNodes,
                                   [this] { return IsOver(); });
  if (way.empty() && !IsOver()) too_narrow_.push_back({from.spot, to.spot});
  return way;
}

bool Planning::IsKnownNarrow(const Spot& from, const Spot& to) const {
  const auto is_near = [](const Spot& a, const Spot& b) {
    return a.level == b.level && geometry::Norm(a.at - b.at) < kSamePlace_m;
  };
  return std::ranges::any_of(too_narrow_, [&](const NarrowPlace& place) {
    return is_near(place.from, from) && is_near(place.to, to);
  });
}

void Planning::Discourage(const Spot& stuck,
                          std::vector<float>& weights) const {
  const Regions& regions = *task_->regions;
  for (uint32_t region = 0; region < regions.count(); ++region) {
    if (regions.region(region).level == stuck.level &&
        geometry::Norm(regions.region(region).center - stuck.at) <
            kStuckReach_m) {
      weights[region] *= static_cast<float>(kStuckCost.value);
    }
  }
}

void Planning::FindFirst(PlanResult& result) {
  VariableRrt trees(task_->space, task_->start, task_->goal);
  const auto sample = [this](uint64_t iteration) {
    return SampleOf(kFirstTree, iteration);
  };
  const auto is_over = [this] { return IsOver(); };
  bool is_found =
      trees.Grow(std::min(kUnguidedIterations.value, budget_.max_iterations),
                 sample, is_over);
  if (!is_found && !IsOver()) is_found = FollowRoutes(trees, false);
  if (!is_found && !IsOver()) {
    is_found =
        trees.Grow(std::min(budget_.max_iterations, kEasyIterations.value) -
                       trees.iterations(),
                   sample, is_over);
  }
  result.iterations = trees.iterations();
  result.tree_edges = trees.Edges();
  result.start_tree_points = result.tree_edges.size();
  const std::vector<geometry::Vec2> goal_edges = trees.GoalEdges();
  result.tree_edges.insert(result.tree_edges.end(), goal_edges.begin(),
                           goal_edges.end());
  if (way_.empty()) way_ = trees.Way();
  result.first_path_s = Elapsed_s();
  if (is_found) return;
  result.failure = core::NavigationCause::kPlanTimeout;
  result.why = absl::StrFormat(
      "no way was found in %d iterations and %.3f s: places on it may be too "
      "narrow to turn in",
      trees.iterations(), Elapsed_s());
}

void Planning::FindThoroughly(PlanResult& result) {
  const auto is_over = [this] { return IsOver(); };
  const auto sample = [this](uint64_t iteration) {
    return SampleOf(kFirstTree, iteration);
  };
  VariableRrt trees(task_->space, task_->start, task_->goal);
  if (trees.Grow(std::min(kUnguidedIterations.value, budget_.max_iterations),
                 sample, is_over) ||
      FollowRoutes(trees, true)) {
    way_ = trees.Way();
  } else if (!IsOver()) {
    way_ = SearchLattice(task_->space, *task_->regions, task_->start,
                         task_->goal, is_over);
  }
  result.iterations += trees.iterations();
  result.first_path_s = Elapsed_s();
  if (!way_.empty()) return;
  result.failure = IsOver() ? core::NavigationCause::kPlanTimeout
                            : core::NavigationCause::kNoPath;
  result.why = absl::StrFormat(
      "no way was found in %.3f s: places on it are too narrow to turn in",
      Elapsed_s());
}

bool Planning::IsUsed(const PlanResult& result) const {
  return IsOver() || result.iterations >= share_ * budget_.max_iterations;
}

void Planning::Polish(PathSmoother& improver, int max_idle,
                      PlanResult& result) {
  for (int idle = 0; idle < max_idle; ++result.iterations) {
    if (result.iterations % kStopEvery == 0 && IsUsed(result)) return;
    base::Random random(seed_ + (kImprovements << 32),
                        static_cast<uint64_t>(result.iterations));
    idle = improver.Try(random) ? 0 : idle + 1;
  }
}

void Planning::PolishWell(PathSmoother& improver, PlanResult& result) {
  Polish(improver,
         std::max(kIdleAttempts.value,
                  kIdleShare * static_cast<int>(improver.way().size())),
         result);
}

Polyline Planning::Restart(uint64_t stream, double bound_m,
                           PlanResult& result) const {
  VariableRrt trees(task_->space, task_->start, task_->goal);
  const geometry::Vec2 start = task_->start.spot.at;
  const geometry::Vec2 goal = task_->goal.spot.at;
  // Informed: a way over a place outside of the ellipse would be longer.
  const auto sample = [&](uint64_t iteration) {
    Spot spot;
    for (uint64_t i = 0; i < kTries; ++i) {
      spot = SampleOf(stream, kTries * iteration + i);
      if (geometry::Norm(spot.at - start) + geometry::Norm(spot.at - goal) <
          bound_m)
        break;
    }
    return spot;
  };
  trees.Grow(std::min(kRestartIterations.value,
                      budget_.max_iterations - result.iterations),
             sample, [this] { return IsOver(); });
  result.iterations += trees.iterations();
  return trees.Way();
}

void Planning::TryOther(Polyline other, PathSmoother& best,
                        PlanResult& result) {
  if (other.size() < 2) return;
  PathSmoother improver(plain_, task_->start.yaw_rad, task_->goal.yaw_rad,
                        std::move(other));
  Polish(improver, kQuickAttempts, result);
  if (improver.cost_m() > kQuickExcess * best.cost_m()) return;
  Polish(improver, kFairAttempts, result);
  if (improver.cost_m() > kFairExcess * best.cost_m()) return;
  PolishWell(improver, result);
  const bool is_shorter = improver.cost_m() < best.cost_m();
  if (is_shorter) std::swap(best, improver);
  if (improver.length_m() < (1 + kComfortLength) * best.length_m()) {
    others_.push_back(improver.way());
  }
}

bool Planning::TryGuide(const Polyline& guide, bool is_thorough,
                        PathSmoother& best, PlanResult& result) {
  ++result.iterations;
  PulledWay pulled = FollowGuide(
      task_->space, task_->start.yaw_rad, task_->goal.yaw_rad, guide,
      Spacing_m(), [this, is_thorough](const Stand& begin, const Stand& end) {
        return Bridge(begin, end, is_thorough);
      });
  if (pulled.is_whole) TryOther(std::move(pulled.way), best, result);
  return pulled.is_whole;
}

void Planning::TryAlternatives(PathSmoother& best, PlanResult& result) {
  Alternatives alternatives(task_->space, *task_->regions, task_->start.spot,
                            task_->goal.spot, best.length_m());
  const auto goes_on = [&] { return !IsUsed(result); };
  std::vector<Polyline> narrow;
  for (Polyline guide = alternatives.Next(); !guide.empty() && goes_on();
       guide = alternatives.Next()) {
    if (!TryGuide(guide, false, best, result)) {
      narrow.push_back(std::move(guide));
    } else {
      guide_ = std::move(guide);
    }
  }
  for (const Polyline& guide : narrow) {
    if (goes_on()) TryGuide(guide, true, best, result);
  }
}

void Planning::Shorten(PathSmoother& best, PlanResult& result) {
  Polish(best, kIdleAttempts, result);
  if (!IsUsed(result)) TryAlternatives(best, result);
  PolishWell(best, result);
  int idle = 0;
  for (uint64_t restart = 1; idle < kIdleRestarts && !IsUsed(result);
       ++restart) {
    ++idle;
    ++result.iterations;
    const double before_m = best.cost_m();
    if (restart % 2 == 1) {
      base::Random random(seed_ + (kImprovements << 32), restart << 32);
      TryOther(
          ShortcutPolyline(
              plain_, task_->start.yaw_rad, task_->goal.yaw_rad, best.way(),
              random.NextUniform(kPullSpacingMin_m, kPullSpacingMax_m)),
          best, result);
    } else {
      TryOther(Restart(kFirstTree + restart, best.cost_m(), result), best,
               result);
    }
    if (best.cost_m() < kKept * before_m) idle = 0;
  }
}

void Planning::Comfort(double shortest_m, PlanResult& result) {
  const double max_m = (1 + kComfortLength) * shortest_m;
  const auto cost_m = [this](const Polyline& way) {
    return PathCost_m(task_->space, task_->start.yaw_rad, task_->goal.yaw_rad,
                      way);
  };
  double best_m = cost_m(way_);
  for (Polyline& other : others_) {
    if (PathLength_m(other) > max_m) continue;
    const double other_m = cost_m(other);
    if (other_m >= best_m) continue;
    best_m = other_m;
    std::swap(way_, other);
  }
  PathSmoother improver(task_->space, task_->start.yaw_rad, task_->goal.yaw_rad,
                        std::move(way_), max_m);
  PolishWell(improver, result);
  way_ = improver.way();
}

void Planning::Improve(PlanResult& result) {
  PathSmoother best(plain_, task_->start.yaw_rad, task_->goal.yaw_rad,
                    std::move(way_));
  share_ = kShortShare;
  Shorten(best, result);
  way_ = best.way();
  share_ = 1;
  Comfort(best.length_m(), result);
}

}  // namespace

VariableRrtPlanner::VariableRrtPlanner(std::shared_ptr<const PlanGround> ground,
                                       std::shared_ptr<const PlanGround> tight,
                                       double max_move_m)
    : ground_(std::move(ground)),
      tight_(std::move(tight)),
      max_move_m_(max_move_m) {}

absl::StatusOr<PlanResult> VariableRrtPlanner::Plan(
    const PlanRequest& request, const PlanBudget& budget,
    const std::stop_token& stop) const {
  const base::MonotonicTime begin = ClockOf(budget).Now();
  TL_RETURN_IF_ERROR(CheckRequest(request));
  PlanResult result;
  const geometry::Rigid2& map_from_grid =
      ground_->index->map().grid(0).map_from_grid;
  for (const bool is_tight : {false, true}) {
    result.failure = core::NavigationCause::kNone;
    result.why.clear();
    const std::optional<PlanTask> task =
        MakeTask(is_tight ? *tight_ : *ground_, request, max_move_m_, result);
    if (!task.has_value()) continue;
    Planning planning(*task, request.seed, budget, stop, begin);
    if (is_tight) {
      planning.FindThoroughly(result);
    } else {
      planning.FindFirst(result);
      for (geometry::Vec2& end : result.tree_edges) end = map_from_grid * end;
    }
    if (result.failure == core::NavigationCause::kNone) {
      if (budget.improves) planning.Improve(result);
      WriteWay(*task, planning.way(), result);
    }
    if (stop.stop_requested()) {
      return absl::CancelledError("planning was stopped");
    }
    if (result.failure == core::NavigationCause::kNone) break;
  }
  result.total_s = base::SecondsBetween(begin, ClockOf(budget).Now());
  return result;
}

}  // namespace treeline::planning
