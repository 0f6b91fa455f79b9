// What the lost suite knows of a synthetic world: what a laser would have
// mapped of it, and where a robot can stand.
#ifndef NAV_AGENT_APP_LOST_SUITE_WORLD_H_
#define NAV_AGENT_APP_LOST_SUITE_WORLD_H_

#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "common/base/random.h"
#include "common/synthetic/ground_truth.h"
#include "common/synthetic/world.h"
#include "nav_agent/localization/lost_scan_check.h"
#include "nav_agent/sim/simulator.h"

namespace treeline {

// Immutable. The map's frame is the world's.
class SuiteWorld {
 public:
  // Maps each level of `world` with rays from all over it, laser_height_m above
  // the ground: a cell is occupied if at least a quarter of the rays that get
  // there end there, and opaque if at least three quarters do. Doors are as
  // they are at time 0; people and carts are not in it; panes of glass are not
  // seen. Errors of GroundTruth and RayCaster.
  static absl::StatusOr<SuiteWorld> Create(const World& world,
                                           double laser_height_m);

  const std::vector<LaserMap>& laser_maps() const { return laser_maps_; }
  // The level that a robot is on.
  std::optional<int> LevelAt(Vec3 position) const;
  // A place with room for the robot, anywhere, looking anywhere. Somebody may
  // stand there all the same.
  RobotPlacement AnyPlace(Random& random) const;

 private:
  explicit SuiteWorld(GroundTruth truth) : truth_(std::move(truth)) {}
  void FindPlaces(const World& world);

  GroundTruth truth_;
  std::vector<LaserMap> laser_maps_;
  // Where the robot has room.
  std::vector<GroundCellIndex> places_;
};

// Puts up to `count` crates where the map has nothing, near the tour and not on
// it. How many found room.
int AddObstacles(const SuiteWorld& map, int count, uint64_t seed,
                 Simulator& simulator);

// Carries the robot somewhere with room: anywhere, or near to where it is. The
// simulator's error if there is none.
absl::Status CarryAway(const SuiteWorld& map, bool near, Random& random,
                       Simulator& simulator);

}  // namespace treeline

#endif  // NAV_AGENT_APP_LOST_SUITE_WORLD_H_
