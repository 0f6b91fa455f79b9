#include "nav_agent/planning/zone_planner.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "nav_agent/planning/guide.h"
#include "nav_agent/planning/path_smoother.h"
#include "nav_agent/planning/plan_clock.h"
#include "nav_agent/planning/planner_parameters.h"
#include "nav_agent/planning/zone_exit.h"

namespace treeline::planning {
namespace {

// A stream of random numbers that the planners do not use.
constexpr uint64_t kWayOut = 0x5a;

double YawAtEnd(const Polyline& way) {
  const geometry::Vec2 line = way.back().at - way[way.size() - 2].at;
  return std::atan2(line.y, line.x);
}

// From where the robot stands along the cells of a way out to its end; empty if
// the footprint cannot.
Polyline DriveOut(const ConfigurationSpace& space, const Stand& start,
                  const Polyline& cells, uint64_t seed,
                  const std::function<bool()>& is_over) {
  const double yaw_rad = YawAtEnd(cells);
  PulledWay pulled = FollowGuide(
      space, start.yaw_rad, yaw_rad, cells,
      std::max(kGuideSpacing_m.value, space.ground().resolution_m()),
      [](const Stand&, const Stand&) { return Polyline(); });
  if (pulled.is_whole) return std::move(pulled.way);
  // It may have to turn or to back up first: trees near the cells.
  VariableRrt trees(space, start, {.spot = cells.back(), .yaw_rad = yaw_rad});
  const auto sample = [&](uint64_t iteration) {
    base::Random random(seed + (kWayOut << 32), iteration);
    Spot near = cells[random.NextBelow(static_cast<uint32_t>(cells.size()))];
    near.at = near.at + geometry::Vec2{kGuideSpacing_m * random.NextGaussian(),
                                       kGuideSpacing_m * random.NextGaussian()};
    return near;
  };
  trees.Grow(kEasyIterations, sample, is_over);
  return trees.Way();
}

// The plan that goes on from where `out` ends.
PlanResult Joined(PlanResult out, PlanResult rest) {
  out.failure = rest.failure;
  out.why = std::move(rest.why);
  if (rest.failure == core::NavigationCause::kNone) {
    const auto begin = rest.path.begin() + (rest.path.empty() ? 0 : 1);
    out.path.insert(out.path.end(), begin, rest.path.end());
  } else {
    out.path.clear();
  }
  out.length_m += rest.length_m;
  out.moved_goal_m = rest.moved_goal_m;
  out.iterations = rest.iterations;
  out.tree_edges = std::move(rest.tree_edges);
  out.start_tree_points = rest.start_tree_points;
  return out;
}

}  // namespace

ZonePlanner::ZonePlanner(
    std::shared_ptr<const traversability::NavigationMap> map,
    const core::RobotModel& robot, const GlobalPlannerOptions& options,
    std::unique_ptr<const GlobalPlanner> without)
    : map_(std::move(map)),
      robot_(robot),
      options_(options),
      without_(std::move(without)) {}

absl::StatusOr<std::shared_ptr<const ZonePlanner::Zoned>> ZonePlanner::ZonedFor(
    const std::shared_ptr<const zones::ZoneMap>& zones) const {
  {
    const absl::MutexLock lock(&mutex_);
    if (last_ != nullptr && last_->zones == zones) return last_;
  }
  auto zoned = std::make_shared<Zoned>();
  zoned->zones = zones;
  TL_ASSIGN_OR_RETURN(traversability::NavigationMap map,
                      MapWithZones(*map_, *zones));
  zoned->ground = std::make_shared<const PlanGround>(
      std::make_shared<const traversability::NavigationMap>(std::move(map)),
      robot_, options_.margin_m, zones);
  TL_ASSIGN_OR_RETURN(zoned->planner,
                      MakePlannerOn(zoned->ground, robot_, options_));
  const absl::MutexLock lock(&mutex_);
  last_ = zoned;
  return last_;
}

absl::StatusOr<PlanResult> ZonePlanner::Plan(
    const PlanRequest& request, const PlanBudget& budget,
    const std::stop_token& stop) const {
  if (request.zones == nullptr || request.zones->empty()) {
    return without_->Plan(request, budget, stop);
  }
  TL_RETURN_IF_ERROR(CheckRequest(request));
  PlanResult result;
  const int goal_level = request.goal.place.level;
  const geometry::Vec2 goal = request.goal.map_from_base.translation;
  if (request.zones->IsKeptOut(goal_level, goal)) {
    result.failure = core::NavigationCause::kZone;
    result.why = absl::StrFormat(
        "the goal (%.2f, %.2f) on level %d lies in the keep-out zone '%s'",
        goal.x, goal.y, goal_level,
        request.zones->KeepOutName(goal_level, goal));
    return result;
  }
  TL_ASSIGN_OR_RETURN(const std::shared_ptr<const Zoned> zoned,
                      ZonedFor(request.zones));
  // What is not on the map the planner within says.
  const bool is_on_map =
      goal_level >= 0 && goal_level < map_->levels() &&
      map_->grid(goal_level).Contains(map_->grid(goal_level).CellOf(goal));
  const bool starts_inside =
      is_on_map &&
      request.zones->IsKeptOut(request.start.place.level,
                               request.start.map_from_base.translation);
  TL_ASSIGN_OR_RETURN(result, starts_inside
                                  ? PlanOut(*zoned, request, budget, stop)
                                  : PlanOn(*zoned, request, budget, stop));
  return result;
}

absl::StatusOr<PlanResult> ZonePlanner::PlanOn(
    const Zoned& zoned, const PlanRequest& request, const PlanBudget& budget,
    const std::stop_token& stop) const {
  TL_ASSIGN_OR_RETURN(PlanResult result,
                      zoned.planner->Plan(request, budget, stop));
  TL_RETURN_IF_ERROR(Blame(zoned, request, budget, stop, result));
  return result;
}

absl::Status ZonePlanner::Blame(const Zoned& zoned, const PlanRequest& request,
                                const PlanBudget& budget,
                                const std::stop_token& stop,
                                PlanResult& result) const {
  const auto blame = [&result](absl::string_view what) {
    result.failure = core::NavigationCause::kZone;
    result.why = absl::StrCat(what, ": ", result.why);
  };
  if (result.failure == core::NavigationCause::kPlanTimeout &&
      zoned.zones->has_one_way()) {
    const GroundIndex& ground = *zoned.ground->index;
    const Stand start = StandOf(ground, request.start);
    const Stand goal = StandOf(ground, request.goal);
    const ConfigurationSpace space(zoned.ground->index, zoned.ground->footprint,
                                   {});
    if (!LeadsWithOneWays(space, start.spot, goal.spot)) {
      blame("one-way zones leave no way");
    }
    return absl::OkStatus();
  }
  if (result.failure != core::NavigationCause::kNoPath &&
      result.failure != core::NavigationCause::kGoalBlocked) {
    return absl::OkStatus();
  }
  PlanBudget quick = budget;
  quick.improves = false;
  TL_ASSIGN_OR_RETURN(const PlanResult without,
                      without_->Plan(request, quick, stop));
  if (without.failure == core::NavigationCause::kNone) {
    blame("zones leave no way, and without them there is one");
  }
  return absl::OkStatus();
}

absl::StatusOr<PlanResult> ZonePlanner::PlanOut(
    const Zoned& zoned, const PlanRequest& request, const PlanBudget& budget,
    const std::stop_token& stop) const {
  const base::MonotonicTime begin = base::SteadyClock().Now();
  const Stand start = StandOf(*zoned.ground->index, request.start);
  const Stand goal = StandOf(*zoned.ground->index, request.goal);
  TL_ASSIGN_OR_RETURN(traversability::NavigationMap open,
                      MapWithoutZonesAt(*map_, *zoned.zones, start.spot));
  const auto index = std::make_shared<const GroundIndex>(
      std::make_shared<const traversability::NavigationMap>(std::move(open)));
  const geometry::Rigid2 grid_from_map = map_->grid(0).map_from_grid.Inverse();
  std::vector<Disc> discs;
  for (const Blockage& blockage : request.blockages) {
    discs.push_back({.center = grid_from_map * blockage.center,
                     .radius_m = blockage.radius_m,
                     .level = blockage.level});
  }
  const ConfigurationSpace outside(zoned.ground->index, zoned.ground->footprint,
                                   discs);
  const Regions& regions = *zoned.ground->regions;
  const int area = regions.AreaOf(*zoned.ground->index, goal.spot);
  PlanResult result;
  bool leads_out = false;
  // The second time without the room beside the footprint.
  for (const double margin_m : {options_.margin_m, 0.0}) {
    const ConfigurationSpace inside(index, Footprint::Of(robot_, margin_m),
                                    discs);
    const Polyline cells =
        CellsOut(inside, outside, start.spot, [&](const Spot& spot) {
          return area < 0 || regions.AreaOf(*zoned.ground->index, spot) == area;
        });
    if (cells.size() < 2) continue;
    leads_out = true;
    const auto is_over = [&] {
      return stop.stop_requested() || SecondsSince(begin) >= budget.max_time_s;
    };
    const Polyline way = DriveOut(inside, start, cells, request.seed, is_over);
    if (way.size() < 2) continue;
    const Stand exit = {.spot = way.back(), .yaw_rad = YawAtEnd(way)};
    WriteWay({.space = inside,
              .start = start,
              .goal = exit,
              .regions = zoned.ground->regions,
              .area = area},
             way, result);
    PlanRequest rest = request;
    rest.start = result.path.back();
    TL_ASSIGN_OR_RETURN(PlanResult on, PlanOn(zoned, rest, budget, stop));
    result = Joined(std::move(result), std::move(on));
    result.total_s = SecondsSince(begin);
    return result;
  }
  if (stop.stop_requested()) {
    return absl::CancelledError("planning was stopped");
  }
  const geometry::Vec2 at = request.start.map_from_base.translation;
  result.failure = leads_out ? core::NavigationCause::kStartBlocked
                             : core::NavigationCause::kNoPath;
  result.why = absl::StrFormat(
      "the robot, at (%.2f, %.2f), finds no way out of the keep-out zone '%s' "
      "that leads on to the goal",
      at.x, at.y, zoned.zones->KeepOutName(request.start.place.level, at));
  TL_RETURN_IF_ERROR(Blame(zoned, request, budget, stop, result));
  result.total_s = SecondsSince(begin);
  return result;
}

}  // namespace treeline::planning
