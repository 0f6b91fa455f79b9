// A synthetic building with its navigation map, and ways through it.
#ifndef TESTS_CONTROL_CONTROL_WORLD_H_
#define TESTS_CONTROL_CONTROL_WORLD_H_

#include <memory>
#include <string>
#include <vector>

#include "common/base/random.h"
#include "nav_agent/traversability/navigation_map.h"
#include "simulation/simulator/simulator.h"
#include "simulation/worlds/world.h"

namespace treeline {

// A disc to keep out of.
struct KeepOut {
  geometry::Vec2 center;
  double radius_m = 0;
};

// Maps lie kMapLift_m above the world.
class ControlWorld {
 public:
  explicit ControlWorld(const std::string& name, bool with_people = false);
  explicit ControlWorld(worlds::World world);

  const worlds::World& world() const { return world_; }
  const std::shared_ptr<const traversability::NavigationMap>& map() const {
    return map_;
  }

  core::LevelPose PlaceAt(geometry::Vec2 at, double yaw_rad,
                          double world_height_m) const;
  // Somewhere with room for a robot.
  core::LevelPose AnyPlace(base::Random& random, double clearance_m) const;
  // The shortest way over cells with clearance_m about their centres, as a line
  // with few corners; empty if there is none. Stands in for a planner.
  std::vector<core::LevelPose> FindPath(
      const core::LevelPose& start, const core::LevelPose& goal,
      double clearance_m, const std::vector<KeepOut>& keep_out = {}) const;

 private:
  bool IsOpen(int level, core::CellIndex cell, double clearance_m,
              const std::vector<KeepOut>& keep_out) const;
  bool SeesStraight(const core::LevelPose& a, const core::LevelPose& b,
                    double clearance_m,
                    const std::vector<KeepOut>& keep_out) const;

  worlds::World world_;
  std::shared_ptr<const traversability::NavigationMap> map_;
};

}  // namespace treeline

#endif  // TESTS_CONTROL_CONTROL_WORLD_H_
