#include "nav_agent/planning/plan_frame.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "nav_agent/planning/endpoint_search.h"
#include "nav_agent/planning/path_smoother.h"
#include "nav_agent/planning/planner_parameters.h"

namespace treeline::planning {
namespace {

bool IsFinite(geometry::Vec2 at) {
  return std::isfinite(at.x) && std::isfinite(at.y);
}

absl::Status CheckPose(const core::LevelPose& pose, const char* name) {
  if (IsFinite(pose.map_from_base.translation) &&
      std::isfinite(pose.map_from_base.yaw_rad)) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "the ", name, " is not finite: x ", pose.map_from_base.translation.x,
      ", y ", pose.map_from_base.translation.y, ", yaw ",
      pose.map_from_base.yaw_rad));
}

std::string Text(const core::LevelPose& pose) {
  return absl::StrFormat("(%.2f, %.2f, %.2f rad) on level %d",
                         pose.map_from_base.translation.x,
                         pose.map_from_base.translation.y,
                         pose.map_from_base.yaw_rad, pose.place.level);
}

bool IsOnMap(const GroundIndex& ground, const Stand& stand) {
  return stand.spot.level >= 0 && stand.spot.level < ground.levels() &&
         ground.Contains(ground.CellOf(stand.spot.at));
}

// Where a robot that cannot turn at `stand` gets to straight ahead
// (`direction` 1) or back (-1) until it can, or for half a metre; nullopt if
// something is in the way.
std::optional<Spot> LeaveStraight(const ConfigurationSpace& space,
                                  const Stand& stand, int direction) {
  if (space.FitsTurning(stand.spot)) return stand.spot;
  const geometry::Vec2 ahead = {std::cos(stand.yaw_rad),
                                std::sin(stand.yaw_rad)};
  std::optional<Spot> spot;
  for (int i = 1; i <= kLeavingWay; ++i) {
    spot = space.Drive(stand.spot,
                       stand.spot.at + (direction * i * kWayStep_m) * ahead,
                       direction < 0);
    if (!spot.has_value()) return std::nullopt;
    if (space.FitsTurning(*spot)) return spot;
  }
  return spot;
}

// Ends that the robot cannot leave (or come to) driving ahead are moved to
// where it can turn: the start straight back, if that is free; else to the
// nearest such place, if there is one.
void MoveToTurn(const ConfigurationSpace& space, double max_move_m,
                bool is_goal,
                const std::function<bool(const Spot&)>& is_allowed,
                MovedStand& end) {
  if (LeaveStraight(space, end.stand, is_goal ? -1 : 1).has_value()) return;
  if (!is_goal) {
    const std::optional<Spot> behind = LeaveStraight(space, end.stand, -1);
    if (behind.has_value()) {
      end.moved_m += geometry::Norm(behind->at - end.stand.spot.at);
      end.stand.spot = *behind;
      return;
    }
  }
  const std::optional<MovedStand> moved =
      NearestStand(space, end.stand, max_move_m, [&](const Spot& spot) {
        return is_allowed(spot) && space.FitsTurning(spot);
      });
  if (!moved.has_value()) return;
  end.stand = moved->stand;
  end.moved_m += moved->moved_m;
}

std::nullopt_t Fail(PlanResult& result, core::NavigationCause cause,
                    std::string why) {
  result.failure = cause;
  result.why = std::move(why);
  return std::nullopt;
}

}  // namespace

Stand StandOf(const GroundIndex& ground, const core::LevelPose& pose) {
  const geometry::Rigid2 grid_from_map =
      ground.map().grid(0).map_from_grid.Inverse();
  const geometry::Rigid2 grid_from_base = grid_from_map * pose.map_from_base;
  return {.spot = {grid_from_base.translation, pose.place.level},
          .yaw_rad = grid_from_base.yaw_rad};
}

PlanGround::PlanGround(std::shared_ptr<const traversability::NavigationMap> map,
                       const core::RobotModel& robot, double margin_m,
                       std::shared_ptr<const zones::ZoneMap> zones)
    : PlanGround(
          std::make_shared<const GroundIndex>(std::move(map), std::move(zones)),
          robot, margin_m) {}

PlanGround::PlanGround(std::shared_ptr<const GroundIndex> index_of,
                       const core::RobotModel& robot, double margin_m)
    : index(std::move(index_of)),
      footprint(Footprint::Of(robot, margin_m)),
      regions(std::make_shared<const Regions>(
          ConfigurationSpace(index, footprint, {}))) {}

absl::Status CheckRequest(const PlanRequest& request) {
  if (absl::Status status = CheckPose(request.start, "start"); !status.ok()) {
    return status;
  }
  if (absl::Status status = CheckPose(request.goal, "goal"); !status.ok()) {
    return status;
  }
  for (const Blockage& blockage : request.blockages) {
    if (!IsFinite(blockage.center) || !std::isfinite(blockage.radius_m) ||
        blockage.radius_m < 0) {
      return absl::InvalidArgumentError(absl::StrCat(
          "a blockage is not a disc: centre (", blockage.center.x, ", ",
          blockage.center.y, "), radius ", blockage.radius_m));
    }
  }
  return absl::OkStatus();
}

std::optional<PlanTask> MakeTask(const PlanGround& ground,
                                 const PlanRequest& request, double max_move_m,
                                 PlanResult& result) {
  const Stand start = StandOf(*ground.index, request.start);
  const Stand goal = StandOf(*ground.index, request.goal);
  if (!IsOnMap(*ground.index, goal)) {
    return Fail(
        result, core::NavigationCause::kGoalOutside,
        absl::StrCat("the goal ", Text(request.goal), " is not on the map"));
  }
  if (!IsOnMap(*ground.index, start)) {
    return Fail(result, core::NavigationCause::kStartBlocked,
                absl::StrCat("the robot, at ", Text(request.start),
                             ", is not on the map"));
  }
  const geometry::Rigid2 grid_from_map =
      ground.index->map().grid(0).map_from_grid.Inverse();
  std::vector<Disc> discs;
  for (const Blockage& blockage : request.blockages) {
    discs.push_back({.center = grid_from_map * blockage.center,
                     .radius_m = blockage.radius_m,
                     .level = blockage.level});
  }
  ConfigurationSpace space(ground.index, ground.footprint, std::move(discs));
  std::shared_ptr<const Regions> regions = ground.regions;
  if (!space.discs().empty()) {
    regions = std::make_shared<const Regions>(*ground.regions, space);
  }
  const auto area_of = [&](const std::optional<MovedStand>& end) {
    return regions->AreaOf(*ground.index, end->stand.spot);
  };
  const auto nearest = [&](const Stand& wanted, int area) {
    return NearestStand(space, wanted, max_move_m, [&](const Spot& spot) {
      return area < 0 || regions->AreaOf(*ground.index, spot) == area;
    });
  };
  std::optional<MovedStand> from = nearest(start, -1);
  std::optional<MovedStand> to = nearest(goal, -1);
  if (!from.has_value()) {
    return Fail(
        result, core::NavigationCause::kStartBlocked,
        absl::StrFormat("the robot has no room at %s, nor within %.2f m of it",
                        Text(request.start), max_move_m));
  }
  if (!to.has_value()) {
    return Fail(
        result, core::NavigationCause::kGoalBlocked,
        absl::StrFormat("the robot has no room at the goal %s, nor within "
                        "%.2f m of it",
                        Text(request.goal), max_move_m));
  }
  // What is moved anyway is moved to where there may be a way.
  if (area_of(from) != area_of(to) && to->moved_m > 0) {
    to = nearest(goal, area_of(from));
    if (!to.has_value()) to = nearest(goal, -1);
  }
  if (area_of(from) != area_of(to) && from->moved_m > 0) {
    from = nearest(start, area_of(to));
    if (!from.has_value()) from = nearest(start, -1);
  }
  if (area_of(from) != area_of(to)) {
    return Fail(result, core::NavigationCause::kNoPath,
                absl::StrCat("no free ground as wide as the robot leads from ",
                             Text(request.start), " to ", Text(request.goal)));
  }
  const auto is_in_area = [&, area = area_of(from)](const Spot& spot) {
    return regions->AreaOf(*ground.index, spot) == area;
  };
  MoveToTurn(space, max_move_m, false, is_in_area, *from);
  MoveToTurn(space, max_move_m, true, is_in_area, *to);
  result.moved_start_m = from->moved_m;
  result.moved_goal_m = to->moved_m;
  const int area = area_of(from);
  return PlanTask{.space = std::move(space),
                  .start = from->stand,
                  .goal = to->stand,
                  .regions = std::move(regions),
                  .area = area};
}

void WriteWay(const PlanTask& task, const Polyline& way, PlanResult& result) {
  const GroundIndex& ground = task.space.ground();
  const traversability::NavigationMap& map = ground.map();
  const geometry::Rigid2& map_from_grid = map.grid(0).map_from_grid;
  result.path.clear();
  result.length_m = PathLength_m(way);
  const auto add = [&](const Spot& spot, double yaw_rad) {
    core::LevelPose pose = {
        .map_from_base = map_from_grid * geometry::Rigid2{spot.at, yaw_rad},
        .place = {.level = spot.level, .height_m = 0}};
    const std::optional<core::LevelPlace> place =
        map.GroundOf(pose.map_from_base.translation, spot.level);
    if (place.has_value()) {
      pose.place = *place;
    } else if (!result.path.empty()) {
      pose.place.height_m = result.path.back().place.height_m;
    }
    result.path.push_back(pose);
  };
  for (size_t i = 0; i + 1 < way.size(); ++i) {
    const geometry::Vec2 line = way[i + 1].at - way[i].at;
    const double yaw_rad = std::atan2(line.y, line.x);
    const int steps = std::max(
        1, static_cast<int>(std::ceil(geometry::Norm(line) / kWayStep_m)));
    Spot spot = way[i];
    for (int k = 0; k < steps; ++k) {
      const geometry::Vec2 at =
          way[i].at + (static_cast<double>(k) / steps) * line;
      // Steps of half a cell, as Drive's.
      spot = task.space.Drive(spot, at).value_or(Spot{at, spot.level});
      add(spot, yaw_rad);
    }
  }
  if (way.size() < 2) add(task.start.spot, task.start.yaw_rad);
  if (!result.path.empty()) add(way.back(), task.goal.yaw_rad);
}

}  // namespace treeline::planning
