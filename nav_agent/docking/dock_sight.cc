#include "nav_agent/docking/dock_sight.h"

#include <cmath>

#include "nav_agent/docking/parameters.h"

namespace treeline::docking {
namespace {

// Localization is so far off; who stands further from the docked pose has come
// there by chance (m, rad).
constexpr double kNearest_m = kTolerance_m + kPress_m;
constexpr double kNearest_rad = 2 * kTolerance_rad;
// A slower robot stands (m/s, rad/s).
constexpr double kStill_mps = 0.005;
constexpr double kStill_radps = 0.01;

}  // namespace

bool IsStill(const behavior::NavigatorSnapshot& shot) {
  return shot.command == core::VelocityCommand{} && shot.pose.has_value() &&
         std::abs(shot.pose->forward_mps) <= kStill_mps &&
         std::abs(shot.pose->yaw_rate_radps) <= kStill_radps;
}

bool DockSight::IsNewScan(const behavior::NavigatorSnapshot& shot) {
  if (shot.laser.used == scans_) return false;
  scans_ = shot.laser.used;
  return true;
}

Dock DockSight::Look(const Dock& dock, const behavior::NavigatorSnapshot& shot,
                     base::MonotonicTime now) {
  if (dock.name != name_) {
    name_ = dock.name;
    seen_.reset();
  }
  if (IsNewScan(shot)) {
    const std::optional<SeenDock> seen =
        FindDock(dock, shot.scan_in_map, robot_);
    if (seen.has_value()) {
      seen_ = seen;
      seen_at_ = now;
    }
  }
  if (seen_.has_value() && base::SecondsBetween(seen_at_, now) > kSeenFor_s) {
    seen_.reset();
  }
  Dock where = dock;
  if (seen_.has_value()) where.map_from_docked = seen_->map_from_docked;
  return where;
}

std::optional<Dock> DockSight::Learn(const Dock& dock,
                                     const behavior::NavigatorSnapshot& shot) {
  if (!IsStill(shot) || dock.name != learns_) {
    learns_ = dock.name;
    maker_.Reset();
    return std::nullopt;
  }
  const geometry::Rigid2 docked_from_base =
      dock.map_from_docked.Inverse() * shot.pose->pose.map_from_base;
  if (geometry::Norm(docked_from_base.translation) > kNearest_m ||
      std::abs(docked_from_base.yaw_rad) > kNearest_rad) {
    maker_.Reset();
    return std::nullopt;
  }
  if (IsNewScan(shot)) maker_.Add(shot.scan_in_base);
  if (!maker_.IsDone()) return std::nullopt;
  Dock learned = dock;
  learned.view = maker_.View();
  maker_.Reset();
  if (learned.view.empty()) return std::nullopt;
  return learned;
}

std::optional<core::LevelPose> DockSight::FindIn(
    std::span<const Dock> docks, const behavior::NavigatorSnapshot& shot) {
  std::optional<core::LevelPose> found;
  for (const Dock& dock : docks) {
    const std::optional<geometry::Rigid2> place =
        PlaceInDock(dock, shot.scan_in_base);
    if (!place.has_value()) continue;
    // Docks of two rooms that are alike.
    if (found.has_value()) return std::nullopt;
    found = {.map_from_base = *place,
             .place = {.level = dock.level, .height_m = 0}};
  }
  return found;
}

}  // namespace treeline::docking
