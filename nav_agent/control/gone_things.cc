#include "nav_agent/control/gone_things.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "nav_agent/control/obstacle_parameters.h"

namespace treeline::control {

GoneThings::GoneThings(std::shared_ptr<const traversability::NavigationMap> map,
                       const core::RobotModel& robot)
    : map_(std::move(map)), robot_(robot) {
  for (traversability::LooseThing& thing :
       traversability::FindLooseThings(*map_, kLooseSize_m)) {
    const size_t cells = thing.cells.size();
    things_.push_back(
        {.what = std::move(thing), .cells = std::vector<CellState>(cells)});
  }
}

void GoneThings::MoveTo(const ControlPose& pose) {
  const core::LevelPose& at = pose.pose;
  const bool jumps =
      last_.has_value() &&
      geometry::Norm(at.map_from_base.translation -
                     last_->map_from_base.translation) > kPoseJump_m;
  if (pose.map_is_unknown || jumps) Clear();
  last_ = at;
}

bool GoneThings::IsUnderRobot(const ControlPose& pose,
                              geometry::Vec2 in_map) const {
  const geometry::Vec2 in_base = pose.pose.map_from_base.Inverse() * in_map;
  return in_base.x < robot_.front_m && in_base.x > -robot_.rear_m &&
         std::abs(in_base.y) < robot_.half_width_m;
}

void GoneThings::Look(
    const ControlPose& pose,
    const std::function<LaserSight(const ThingColumn&)>& by_laser,
    const std::function<ColumnSight(const ThingColumn&, double)>& by_depth,
    int64_t now_ms) {
  if (pose.map_is_unknown) return;
  const geometry::Vec2 at = pose.pose.map_from_base.translation;
  bool has_changed = false;
  for (Thing& thing : things_) {
    if (thing.what.level != pose.pose.place.level ||
        geometry::Norm(thing.what.middle_in_map - at) >
            kDepthRange_m + thing.what.radius_m) {
      continue;
    }
    for (size_t i = 0; i < thing.cells.size(); ++i) {
      CellState& cell = thing.cells[i];
      const ThingColumn column = {
          .center_in_map =
              map_->grid(thing.what.level).CenterInMap(thing.what.cells[i]),
          .ground_m = thing.what.ground_m,
          .half_width_m = 0.5 * map_->resolution_m()};
      const LaserSight laser = by_laser(column);
      if (cell.is_freed && (laser.sight == ColumnSight::kThrough ||
                            IsUnderRobot(pose, column.center_in_map))) {
        cell.seen_ms = now_ms;
      }
      ColumnSight sight = laser.sight;
      if (sight == ColumnSight::kThrough) {
        sight = by_depth(column, laser.range_m);
      }
      if (sight == ColumnSight::kMet) {
        cell.looks = 0;
        cell.was_met = true;
      } else if (sight == ColumnSight::kThrough) {
        cell.seen_ms = now_ms;
        cell.looks = std::min(kHitsToMark.value, cell.looks + 1);
        if (cell.looks == kHitsToMark) cell.was_met = false;
      }
    }
    has_changed = FreeOf(thing) || has_changed;
  }
  if (has_changed) Write();
}

bool GoneThings::FreeOf(Thing& thing) {
  size_t seen_through = 0;
  for (const CellState& cell : thing.cells) {
    if (cell.was_met) return false;
    seen_through += cell.is_freed || cell.looks == kHitsToMark ? 1 : 0;
  }
  if (2 * seen_through < thing.cells.size()) return false;
  bool has_changed = false;
  for (CellState& cell : thing.cells) {
    if (cell.is_freed || cell.looks < kHitsToMark) continue;
    cell.is_freed = true;
    has_changed = true;
  }
  return has_changed;
}

void GoneThings::Forget(int64_t now_ms) {
  bool has_changed = false;
  for (Thing& thing : things_) {
    for (CellState& cell : thing.cells) {
      if (cell.looks == 0 && !cell.is_freed) continue;
      if (now_ms - cell.seen_ms <= Milliseconds(kStandingMemory_s)) continue;
      has_changed = has_changed || cell.is_freed;
      cell.looks = 0;
      cell.is_freed = false;
    }
  }
  if (has_changed) Write();
}

void GoneThings::Clear() {
  for (Thing& thing : things_) {
    std::ranges::fill(thing.cells, CellState());
  }
  freed_.reset();
}

void GoneThings::Write() {
  std::vector<traversability::FreedCells::Cell> cells;
  for (const Thing& thing : things_) {
    for (size_t i = 0; i < thing.cells.size(); ++i) {
      if (!thing.cells[i].is_freed) continue;
      cells.push_back({.level = thing.what.level,
                       .cell = thing.what.cells[i],
                       .ground_m = static_cast<float>(thing.what.ground_m)});
    }
  }
  freed_ = cells.empty() ? nullptr
                         : std::make_shared<const traversability::FreedCells>(
                               std::move(cells));
}

}  // namespace treeline::control
