#include "nav_agent/behavior/lasers_plane.h"

#include <optional>

#include "nav_agent/behavior/parameters.h"

namespace treeline::behavior {

bool IsInLasersPlane(const traversability::NavigationMap& map,
                     const control::ControlPose& pose,
                     const geometry::Rigid3& base_from_laser,
                     const planning::Blockage& blockage) {
  const std::optional<core::LevelPlace> ground =
      map.GroundOf(blockage.center, blockage.level);
  if (!ground.has_value()) return false;
  const geometry::Rigid3 map_from_laser =
      control::MapFromBase3(pose) * base_from_laser;
  const geometry::Vec3 normal =
      map_from_laser.rotation * geometry::Vec3{0, 0, 1};
  const geometry::Vec3 from = map_from_laser.translation;
  const double z_m = from.z - (normal.x * (blockage.center.x - from.x) +
                               normal.y * (blockage.center.y - from.y)) /
                                  normal.z;
  const double above_m = z_m - ground->height_m;
  return above_m > kMinSeeThroughHeight_m && above_m < kMaxSeeThroughHeight_m;
}

}  // namespace treeline::behavior
