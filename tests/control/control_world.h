// A synthetic building with its navigation map, and ways through it.
#ifndef TESTS_CONTROL_CONTROL_WORLD_H_
#define TESTS_CONTROL_CONTROL_WORLD_H_

#include <memory>
#include <string>
#include <vector>

#include "common/base/random.h"
#include "common/synthetic/world.h"
#include "nav_agent/sim/simulator.h"
#include "nav_agent/traversability/navigation_map.h"

namespace treeline {

// A disc to keep out of.
struct KeepOut {
  Vec2 center;
  double radius_m = 0;
};

// Maps lie kMapLift_m above the world.
class ControlWorld {
 public:
  explicit ControlWorld(const std::string& name, bool with_people = false);
  explicit ControlWorld(World world);

  const World& world() const { return world_; }
  const std::shared_ptr<const NavigationMap>& map() const { return map_; }

  LevelPose PlaceAt(Vec2 at, double yaw_rad, double world_height_m) const;
  // Somewhere with room for a robot.
  LevelPose AnyPlace(Random& random, double clearance_m) const;
  // The shortest way over cells with clearance_m about their centres, as a line
  // with few corners; empty if there is none. Stands in for a planner.
  std::vector<LevelPose> FindPath(
      const LevelPose& start, const LevelPose& goal, double clearance_m,
      const std::vector<KeepOut>& keep_out = {}) const;

 private:
  bool IsOpen(int level, CellIndex cell, double clearance_m,
              const std::vector<KeepOut>& keep_out) const;
  bool SeesStraight(const LevelPose& a, const LevelPose& b, double clearance_m,
                    const std::vector<KeepOut>& keep_out) const;

  World world_;
  std::shared_ptr<const NavigationMap> map_;
};

}  // namespace treeline

#endif  // TESTS_CONTROL_CONTROL_WORLD_H_
