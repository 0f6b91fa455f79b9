// What a robot is kept out of, around it; and how it is let out of that.
#ifndef NAV_AGENT_CONTROL_ZONE_LAYER_H_
#define NAV_AGENT_CONTROL_ZONE_LAYER_H_

#include <cstddef>
#include <limits>
#include <memory>
#include <vector>

#include "nav_agent/control/costmap_window.h"
#include "nav_agent/control/footprint.h"
#include "nav_agent/control/ground_layer.h"
#include "nav_agent/core/level_pose.h"
#include "nav_agent/zones/zone_map.h"

namespace treeline::control {

// The cells of a window that are kept out of, on the ground's levels. A robot
// that stands in some may drive over all that lead out no later than those it
// stands on: so it gets out, and never further in. Out of it, it is not let in
// again.
//
// Deterministic; not thread-safe.
class ZoneLayer {
 public:
  ZoneLayer(size_t cells, const Footprint& footprint);

  // Of the map that the ground is of; null: none. Spread follows.
  void SetZones(std::shared_ptr<const zones::ZoneMap> zones);

  // Anew, for a window on this ground.
  void Spread(const CostmapWindow& window, const GroundLayer& ground);
  // The robot is there now.
  void LetOut(const CostmapWindow& window, const GroundLayer& ground,
              const core::LevelPose& pose);

  // Of a cell of the window, by its number.
  bool IsClosed(size_t i) const {
    return has_closed_ && way_out_m_[i] > let_out_m_;
  }
  // Infinite where there is no limit (m/s).
  double MaxSpeed_mps(int level, geometry::Vec2 point_in_map) const {
    return zones_ == nullptr ? std::numeric_limits<double>::infinity()
                             : zones_->MaxSpeed_mps(level, point_in_map);
  }
  // Centres of the map's cells within radius_m of a pose, which need not be the
  // window's, that are kept out of and border on one that is not; none for a
  // pose that is in such a cell itself.
  std::vector<geometry::Vec2> Edges(const core::LevelPose& pose,
                                    double radius_m) const;

 private:
  bool KeepsOut() const { return zones_ != nullptr && zones_->has_keep_out(); }
  core::CellIndex MapCellAt(geometry::Vec2 point_in_map) const;

  std::vector<geometry::Vec2> footprint_in_base_;
  double circumradius_m_;
  std::shared_ptr<const zones::ZoneMap> zones_;
  // The zones' grid from the map's frame.
  double cos_ = 1;
  double sin_ = 0;
  geometry::Vec2 origin_;

  // One a cell of the window: ZoneMap's way out (m).
  std::vector<float> way_out_m_;
  // Some cell has one.
  bool has_closed_ = false;
  // What has no longer one is open.
  float let_out_m_ = 0;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_ZONE_LAYER_H_
