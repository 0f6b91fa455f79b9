#include "nav_agent/planning/plan_frame.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "nav_agent/planning/path_improver.h"
#include "nav_agent/planning/plan_ends.h"

namespace treeline {
namespace {

constexpr double kPathStep_m = 0.1;

bool IsFinite(Vec2 at) { return std::isfinite(at.x) && std::isfinite(at.y); }

absl::Status CheckPose(const LevelPose& pose, const char* name) {
  if (IsFinite(pose.map_from_base.translation) &&
      std::isfinite(pose.map_from_base.yaw_rad)) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "the ", name, " is not finite: x ", pose.map_from_base.translation.x,
      ", y ", pose.map_from_base.translation.y, ", yaw ",
      pose.map_from_base.yaw_rad));
}

Stand StandOf(const GroundIndex& ground, const LevelPose& pose) {
  const Rigid2 grid_from_map = ground.map().grid(0).map_from_grid.Inverse();
  const Rigid2 grid_from_base = grid_from_map * pose.map_from_base;
  return {.spot = {grid_from_base.translation, pose.place.level},
          .yaw_rad = grid_from_base.yaw_rad};
}

std::string Text(const LevelPose& pose) {
  return absl::StrFormat("(%.2f, %.2f, %.2f rad) on level %d",
                         pose.map_from_base.translation.x,
                         pose.map_from_base.translation.y,
                         pose.map_from_base.yaw_rad, pose.place.level);
}

int AreaAt(const PlanGround& ground, const Spot& spot) {
  const CellIndex cell = ground.index->CellOf(spot.at);
  if (!ground.index->Contains(cell)) return -1;
  return ground
      .areas[static_cast<size_t>(spot.level)][ground.index->IndexOf(cell)];
}

bool IsOnMap(const GroundIndex& ground, const Stand& stand) {
  return stand.spot.level >= 0 && stand.spot.level < ground.levels() &&
         ground.Contains(ground.CellOf(stand.spot.at));
}

std::nullopt_t Fail(PlanResult& result, NavigationCause cause,
                    std::string why) {
  result.failure = cause;
  result.why = std::move(why);
  return std::nullopt;
}

}  // namespace

PlanGround::PlanGround(std::shared_ptr<const NavigationMap> map,
                       const RobotModel& robot, double margin_m)
    : index(std::make_shared<const GroundIndex>(std::move(map))),
      footprint(Footprint::Of(robot, margin_m)),
      areas(index->Areas(footprint.inscribed_m)) {
  for (size_t level = 0; level < areas.size(); ++level) {
    for (size_t i = 0; i < areas[level].size(); ++i) {
      const int32_t area = areas[level][i];
      if (area < 0) continue;
      const size_t number = static_cast<size_t>(area);
      if (number >= cells_of_area.size()) cells_of_area.resize(number + 1);
      cells_of_area[number].push_back(
          static_cast<uint32_t>(level * index->cells() + i));
    }
  }
}

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
        result, NavigationCause::kGoalOutside,
        absl::StrCat("the goal ", Text(request.goal), " is not on the map"));
  }
  if (!IsOnMap(*ground.index, start)) {
    return Fail(result, NavigationCause::kStartBlocked,
                absl::StrCat("the robot, at ", Text(request.start),
                             ", is not on the map"));
  }
  const Rigid2 grid_from_map =
      ground.index->map().grid(0).map_from_grid.Inverse();
  std::vector<Disc> discs;
  for (const Blockage& blockage : request.blockages) {
    discs.push_back({.center = grid_from_map * blockage.center,
                     .radius_m = blockage.radius_m,
                     .level = blockage.level});
  }
  DriveSpace space(ground.index, ground.footprint, std::move(discs));
  const auto anywhere = [](const Spot& /*spot*/) { return true; };
  const std::optional<MovedStand> moved_goal =
      NearestStand(space, goal, max_move_m, anywhere);
  if (!moved_goal.has_value()) {
    return Fail(
        result, NavigationCause::kGoalBlocked,
        absl::StrFormat("the robot has no room at the goal %s, nor within "
                        "%.2f m of it",
                        Text(request.goal), max_move_m));
  }
  const int area = AreaAt(ground, moved_goal->stand.spot);
  const auto is_in_area = [&ground, area](const Spot& spot) {
    return AreaAt(ground, spot) == area;
  };
  const std::optional<MovedStand> moved_start =
      NearestStand(space, start, max_move_m, is_in_area);
  if (!moved_start.has_value()) {
    if (NearestStand(space, start, max_move_m, anywhere).has_value()) {
      return Fail(
          result, NavigationCause::kNoPath,
          absl::StrCat("no free ground as wide as the robot leads from ",
                       Text(request.start), " to ", Text(request.goal)));
    }
    return Fail(
        result, NavigationCause::kStartBlocked,
        absl::StrFormat("the robot has no room at %s, nor within %.2f m of it",
                        Text(request.start), max_move_m));
  }
  result.moved_start_m = moved_start->moved_m;
  result.moved_goal_m = moved_goal->moved_m;
  return PlanTask{.space = std::move(space),
                  .start = moved_start->stand,
                  .goal = moved_goal->stand,
                  .area = area};
}

void WriteWay(const PlanTask& task, const Polyline& way, PlanResult& result) {
  const GroundIndex& ground = task.space.ground();
  const NavigationMap& map = ground.map();
  const Rigid2& map_from_grid = map.grid(0).map_from_grid;
  result.path.clear();
  result.length_m = WayLength_m(way);
  const auto add = [&](const Spot& spot, double yaw_rad) {
    LevelPose pose = {.map_from_base = map_from_grid * Rigid2{spot.at, yaw_rad},
                      .place = {.level = spot.level, .height_m = 0}};
    const std::optional<LevelPlace> place =
        map.GroundOf(pose.map_from_base.translation, spot.level);
    if (place.has_value()) {
      pose.place = *place;
    } else if (!result.path.empty()) {
      pose.place.height_m = result.path.back().place.height_m;
    }
    result.path.push_back(pose);
  };
  for (size_t i = 0; i + 1 < way.size(); ++i) {
    const Vec2 line = way[i + 1].at - way[i].at;
    const double yaw_rad = std::atan2(line.y, line.x);
    const int steps =
        std::max(1, static_cast<int>(std::ceil(Norm(line) / kPathStep_m)));
    Spot spot = way[i];
    for (int k = 0; k < steps; ++k) {
      const Vec2 at = way[i].at + (static_cast<double>(k) / steps) * line;
      // Steps of half a cell, as Drive's.
      spot = task.space.Drive(spot, at).value_or(Spot{at, spot.level});
      add(spot, yaw_rad);
    }
  }
  if (way.size() < 2) add(task.start.spot, task.start.yaw_rad);
  if (!result.path.empty()) add(way.back(), task.goal.yaw_rad);
}

}  // namespace treeline
