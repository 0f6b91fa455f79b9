// What the lost suite knows of a synthetic world: what a laser would have
// mapped of it, and where a robot can stand.
#ifndef SIMULATION_RUNS_LOST_SUITE_WORLD_H_
#define SIMULATION_RUNS_LOST_SUITE_WORLD_H_

#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "common/base/random.h"
#include "nav_agent/localization/lost_scan_check.h"
#include "simulation/simulator/simulator.h"
#include "simulation/worlds/ground_truth.h"
#include "simulation/worlds/world.h"

namespace treeline::runs {

// Immutable. The map's frame is the world's.
class SuiteWorld {
 public:
  // Maps each level of `world` with rays from all over it, laser_height_m above
  // the ground: a cell is occupied if at least a quarter of the rays that get
  // there end there, and opaque if at least three quarters do. Doors are as
  // they are at time 0; people and carts are not in it; panes of glass are not
  // seen. Errors of GroundTruth and RayCaster.
  static absl::StatusOr<SuiteWorld> Create(const worlds::World& world,
                                           double laser_height_m);

  const std::vector<localization::LaserMap>& laser_maps() const {
    return laser_maps_;
  }
  // The level that a robot is on.
  std::optional<int> LevelAt(geometry::Vec3 position) const;
  // A place with room for the robot, anywhere, looking anywhere. Somebody may
  // stand there all the same.
  simulator::RobotPlacement AnyPlace(base::Random& random) const;

 private:
  explicit SuiteWorld(worlds::GroundTruth truth) : truth_(std::move(truth)) {}
  void FindPlaces(const worlds::World& world);

  worlds::GroundTruth truth_;
  std::vector<localization::LaserMap> laser_maps_;
  // Where the robot has room.
  std::vector<worlds::GroundCellIndex> places_;
};

// Puts up to `count` crates where the map has nothing, near the tour and not on
// it. How many found room.
int AddObstacles(const SuiteWorld& map, int count, uint64_t seed,
                 simulator::Simulator& simulator);

// Carries the robot somewhere with room: anywhere, or near to where it is. The
// simulator's error if there is none.
absl::Status CarryAway(const SuiteWorld& map, bool near, base::Random& random,
                       simulator::Simulator& simulator);

}  // namespace treeline::runs

#endif  // SIMULATION_RUNS_LOST_SUITE_WORLD_H_
