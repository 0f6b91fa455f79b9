#include "nav_agent/docking/dock.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/check_name.h"
#include "common/base/status_macros.h"
#include "nav_agent/docking/parameters.h"

namespace treeline::docking {
namespace {

// No building is larger (m); and no heading needs more turns (rad).
constexpr double kFarthest_m = 1e5;
constexpr double kMostYaw_rad = 1e3;
// No laser sees further (m).
constexpr double kFarthestView_m = 1e3;

absl::Status CheckOnGround(const traversability::TraversableLevel& level,
                           geometry::Vec2 at, const char* which) {
  const core::CellIndex cell = level.grid.CellOf(at);
  const char* problem = nullptr;
  if (!level.grid.Contains(cell)) {
    problem = "outside of the map";
  } else if (level.grid.At(cell) == core::Occupancy::kOccupied) {
    problem = "in something that the map has there";
  } else if (level.grid.At(cell) != core::Occupancy::kFree) {
    problem = "where the map knows no ground";
  }
  if (problem == nullptr) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat(
      "its %s pose (%.2f, %.2f) lies %s", which, at.x, at.y, problem));
}

absl::Status CheckParts(const Dock& dock,
                        const traversability::TraversableMap& map) {
  const geometry::Rigid2& docked = dock.map_from_docked;
  // Also for what is not a number.
  if (!(std::abs(docked.translation.x) <= kFarthest_m &&
        std::abs(docked.translation.y) <= kFarthest_m)) {
    return absl::InvalidArgumentError(
        absl::StrCat("is at (", docked.translation.x, ", ",
                     docked.translation.y, ") m: that is on no map"));
  }
  if (!(std::abs(docked.yaw_rad) <= kMostYaw_rad)) {
    return absl::InvalidArgumentError(
        absl::StrCat("looks to ", docked.yaw_rad, " rad: that is no heading"));
  }
  if (!(dock.staging_m >= kMinStaging_m && dock.staging_m <= kMaxStaging_m)) {
    return absl::InvalidArgumentError(
        absl::StrCat("is driven to from ", dock.staging_m,
                     " m before it; it "
                     "must be ",
                     kMinStaging_m, "..", kMaxStaging_m));
  }
  if (dock.view.size() > kMaxViewPoints ||
      !std::ranges::all_of(dock.view, [](const geometry::Vec2& point) {
        return geometry::Norm(point) <= kFarthestView_m;
      })) {
    return absl::InvalidArgumentError("has a view that is none");
  }
  if (dock.level < 0 || static_cast<size_t>(dock.level) >= map.levels.size()) {
    return absl::InvalidArgumentError(absl::StrCat("is on level ", dock.level,
                                                   "; the map has 0..",
                                                   map.levels.size() - 1));
  }
  const auto& level = map.levels[static_cast<size_t>(dock.level)];
  TL_RETURN_IF_ERROR(CheckOnGround(level, docked.translation, "docked"));
  return CheckOnGround(level, StagingPose(dock).translation, "staging");
}

}  // namespace

bool IsSamePlace(const Dock& a, const Dock& b) {
  return a.name == b.name && a.map_from_docked == b.map_from_docked &&
         a.level == b.level && a.is_backward == b.is_backward &&
         a.staging_m == b.staging_m;
}

double DefaultStaging_m(const core::RobotModel& robot) {
  return robot.Circumradius_m() + kStagingRoom_m;
}

geometry::Rigid2 StagingPose(const Dock& dock) {
  const double back_m = dock.is_backward ? dock.staging_m : -dock.staging_m;
  return dock.map_from_docked * geometry::Rigid2{{back_m, 0}, 0};
}

DockOffset OffsetFrom(const Dock& dock, const geometry::Rigid2& map_from_base) {
  const geometry::Rigid2 docked_from_base =
      dock.map_from_docked.Inverse() * map_from_base;
  const double sign = dock.is_backward ? -1 : 1;
  return {.along_m = sign * docked_from_base.translation.x,
          .aside_m = sign * docked_from_base.translation.y,
          .turned_rad = docked_from_base.yaw_rad};
}

bool IsAt(const Dock& dock, const core::LevelPose& robot) {
  if (dock.level != robot.place.level) return false;
  const DockOffset off = OffsetFrom(dock, robot.map_from_base);
  return std::hypot(off.along_m, off.aside_m) <= kAtDock_m &&
         std::abs(off.turned_rad) <= kAtDock_rad;
}

bool IsInside(const Dock& dock, const core::LevelPose& robot,
              const core::RobotModel& model) {
  if (IsAt(dock, robot)) return true;
  if (dock.level != robot.place.level) return false;
  const DockOffset off = OffsetFrom(dock, robot.map_from_base);
  const double edge_m = dock.is_backward ? model.rear_m : model.front_m;
  const double turn_m = model.Circumradius_m() - edge_m + kAtDock_m;
  return off.along_m <= kAtDock_m && off.along_m > -turn_m &&
         std::abs(off.aside_m) <= kAtDock_m &&
         std::abs(off.turned_rad) <= std::numbers::pi / 4;
}

double Away_m(const Dock& dock, const core::LevelPose& robot) {
  return geometry::Norm(dock.map_from_docked.translation -
                        robot.map_from_base.translation) +
         (dock.level == robot.place.level ? 0 : kFarthest_m);
}

absl::StatusOr<Dock> NearestOf(std::span<const Dock> docks,
                               const std::optional<core::LevelPose>& robot) {
  if (docks.empty()) {
    return absl::FailedPreconditionError("there is no dock; make one first");
  }
  if (!robot.has_value()) return docks.front();
  return *std::ranges::min_element(
      docks, {}, [&](const Dock& dock) { return Away_m(dock, *robot); });
}

absl::Status CheckDock(const Dock& dock,
                       const traversability::TraversableMap& map) {
  TL_RETURN_IF_ERROR(base::CheckName(dock.name, "a dock's", kMaxDockNameBytes));
  const absl::Status checked = CheckParts(dock, map);
  if (checked.ok()) return checked;
  return absl::InvalidArgumentError(
      absl::StrCat("dock '", dock.name, "': ", checked.message()));
}

absl::Status CheckDocks(std::span<const Dock> docks,
                        const traversability::TraversableMap& map) {
  if (docks.size() > kMaxDocks) {
    return absl::InvalidArgumentError(absl::StrCat("there are ", docks.size(),
                                                   " docks; at most ",
                                                   kMaxDocks, " are kept"));
  }
  std::set<std::string> names;
  for (const Dock& dock : docks) {
    TL_RETURN_IF_ERROR(CheckDock(dock, map));
    if (!names.insert(dock.name).second) {
      return absl::InvalidArgumentError(
          absl::StrCat("two docks are called '", dock.name, "'"));
    }
  }
  return absl::OkStatus();
}

}  // namespace treeline::docking
