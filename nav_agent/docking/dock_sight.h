// Docks as the laser shows them, to a robot that drives into them, stands in
// them, or wakes up there.
#ifndef NAV_AGENT_DOCKING_DOCK_SIGHT_H_
#define NAV_AGENT_DOCKING_DOCK_SIGHT_H_

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "common/base/clock.h"
#include "nav_agent/behavior/navigator_snapshot.h"
#include "nav_agent/core/level_pose.h"
#include "nav_agent/docking/dock.h"
#include "nav_agent/docking/dock_view.h"

namespace treeline::docking {

// It is commanded nothing, and its wheels do not roll.
bool IsStill(const behavior::NavigatorSnapshot& shot);

// Not thread-safe.
class DockSight {
 public:
  explicit DockSight(const core::RobotModel& robot)
      : robot_(robot), maker_(robot) {}

  // ---- driving in or out ----
  // The dock where the laser shows it, in the frame of the snapshot's pose; as
  // it is kept, if it has not shown it for kSeenFor_s. Each new scan is looked
  // at once.
  Dock Look(const Dock& dock, const behavior::NavigatorSnapshot& shot,
            base::MonotonicTime now);
  // Of the last Look; nullopt: it went by the map.
  const std::optional<SeenDock>& seen() const { return seen_; }

  // ---- standing in it ----
  // A step of a robot that stands in a dock without a view. The dock with its
  // view, once that is complete. Where it stands is the docked pose from then
  // on: where that is in the map, localization knows no better.
  std::optional<Dock> Learn(const Dock& dock,
                            const behavior::NavigatorSnapshot& shot);
  // It does not stand there any more.
  void ForgetLearned() { maker_.Reset(); }

  // ---- waking up ----
  // Where a robot is that charges and knows no more: in the one dock whose view
  // it sees. nullopt: in none, or in one of several.
  static std::optional<core::LevelPose> FindIn(
      std::span<const Dock> docks, const behavior::NavigatorSnapshot& shot);

 private:
  bool IsNewScan(const behavior::NavigatorSnapshot& shot);

  core::RobotModel robot_;
  std::string name_;
  std::optional<SeenDock> seen_;
  base::MonotonicTime seen_at_;
  DockViewMaker maker_;
  std::string learns_;
  // Scans that there have been.
  int64_t scans_ = 0;
};

}  // namespace treeline::docking

#endif  // NAV_AGENT_DOCKING_DOCK_SIGHT_H_
