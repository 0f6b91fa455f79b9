// What the map has and the robot's sensors see through.
#ifndef NAV_AGENT_CONTROL_GONE_THINGS_H_
#define NAV_AGENT_CONTROL_GONE_THINGS_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "nav_agent/control/control_pose.h"
#include "nav_agent/control/thing_column.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/traversability/loose_things.h"

namespace treeline::control {

// Keeps for each cell of the map's loose things (LooseThing) whether it was
// seen through lately, by a laser and by the depth camera, from the ground to
// the robot's height. A cell is freed if
//
//   it was seen through in kHitsToMark looks, and was met in none since,
//   so was no less than half of its thing, and
//   no cell of the thing was met and not seen through since.
//
// So what has one leg left stays, and so does what one sensor alone cannot see:
// glass, tops of tables, low steps. What stands there later is an obstacle that
// is seen, as on other ground. Freed cells are forgotten when they were not
// seen through for kStandingMemory_s, and all when the robot was elsewhere than
// it thought.
//
// Times are in ms, of the caller's epoch. Deterministic; not thread-safe.
class GoneThings {
 public:
  GoneThings(std::shared_ptr<const traversability::NavigationMap> map,
             const core::RobotModel& robot);

  // The robot is there now. A pose that jumps says that the last was wrong.
  void MoveTo(const ControlPose& pose);
  // One look at the things nearby. by_depth is asked of what lasers see
  // through alone, with what the laser's range there is.
  void Look(
      const ControlPose& pose,
      const std::function<LaserSight(const ThingColumn&)>& by_laser,
      const std::function<ColumnSight(const ThingColumn&, double)>& by_depth,
      int64_t now_ms);
  void Forget(int64_t now_ms);
  void Clear();

  // Another one whenever they change; null: there are none.
  const std::shared_ptr<const traversability::FreedCells>& freed() const {
    return freed_;
  }

 private:
  struct CellState {
    int looks = 0;
    bool was_met = false;
    bool is_freed = false;
    // Last seen through.
    int64_t seen_ms = 0;
  };
  struct Thing {
    traversability::LooseThing what;
    std::vector<CellState> cells;
  };

  bool IsUnderRobot(const ControlPose& pose, geometry::Vec2 in_map) const;
  // Whether a cell was freed.
  static bool FreeOf(Thing& thing);
  void Write();

  std::shared_ptr<const traversability::NavigationMap> map_;
  core::RobotModel robot_;
  std::vector<Thing> things_;
  std::optional<core::LevelPose> last_;
  std::shared_ptr<const traversability::FreedCells> freed_;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_GONE_THINGS_H_
