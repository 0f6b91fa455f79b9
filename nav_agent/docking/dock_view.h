// What the laser sees from a dock, and where a dock is by that: the place is
// known better so than in the map.
#ifndef NAV_AGENT_DOCKING_DOCK_VIEW_H_
#define NAV_AGENT_DOCKING_DOCK_VIEW_H_

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/geometry/rigid2.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/docking/dock.h"
#include "nav_agent/localization/known_things.h"

namespace treeline::docking {

// Many scans of a robot that stands become one view: in each direction from the
// laser (kViewStep_rad wide) the median of the ranges, where they agree. So it
// is some millimetres exact, and who walked past is not in it.
class DockViewMaker {
 public:
  explicit DockViewMaker(const core::RobotModel& robot)
      : laser_{robot.base_from_laser.translation.x,
               robot.base_from_laser.translation.y} {}

  void Reset();
  // Where beams end, in the base (m).
  void Add(std::span<const geometry::Vec2> scan_in_base);
  bool IsDone() const;
  // In the base, counter-clockwise from straight behind the laser (m). Empty:
  // nothing was seen.
  std::vector<geometry::Vec2> View() const;

 private:
  geometry::Vec2 laser_;
  int scans_ = 0;
  std::vector<std::vector<float>> ranges_m_;
};

struct SeenDock {
  // Where the dock is, in the frame of the pose that the scan was placed by.
  geometry::Rigid2 map_from_docked;
  // Of the scan's points, those that the view has (0 to 1, ScanMatch's).
  double response = 0;
  // How far the dock's body stands from where it was in the view (m); below
  // kBodyMoved_m it is 0.
  double moved_m = 0;
};

// The dock by its view in a scan (in the map, m) of a robot that believes to be
// where the scan is placed by, up to kViewReach_m and kViewTurn_rad wrong. All
// that stands around decides; the body of the dock, if it was moved by up to
// kBodyReach_m since, decides last. nullopt: no view, or the scan does not show
// it well enough.
std::optional<SeenDock> FindDock(const Dock& dock,
                                 std::span<const geometry::Vec2> scan_in_map,
                                 const core::RobotModel& robot);

// Whether a robot may stand in a dock: where, in the map. The scan is in its
// base (m). nullopt: it sees something else.
std::optional<geometry::Rigid2> PlaceInDock(
    const Dock& dock, std::span<const geometry::Vec2> scan_in_base);

// Whether a robot that stood in a dock sees (in its base, m) that it stands
// elsewhere: beams go through what the view has, or next to nothing is as
// there. Who stands around it hides the view, and does not say so. False: there
// is no view.
bool IsElsewhere(const Dock& dock, std::span<const geometry::Vec2> scan_in_base,
                 const core::RobotModel& robot);

// What docks' views show.
std::shared_ptr<const localization::KnownThings> ThingsAt(
    std::span<const Dock> docks);

}  // namespace treeline::docking

#endif  // NAV_AGENT_DOCKING_DOCK_VIEW_H_
