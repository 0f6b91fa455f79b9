// How far it is from places, and from the footprint, to obstacles.
#ifndef NAV_AGENT_CONTROL_DISTANCE_LAYER_H_
#define NAV_AGENT_CONTROL_DISTANCE_LAYER_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/geometry/rigid2.h"
#include "nav_agent/control/costmap_window.h"
#include "nav_agent/control/footprint.h"

namespace treeline::control {

// Exact distances from the centres of a window's cells to the nearest obstacle,
// and what follows from them. Deterministic; not thread-safe.
class DistanceLayer {
 public:
  DistanceLayer(const CostmapWindow& window, const Footprint& footprint);

  // Anew: obstacles are the cells where is_obstacle is not 0. far_m: what the
  // distance is where there is none.
  void Measure(const CostmapWindow& window,
               std::span<const uint8_t> is_obstacle, double far_m);

  // From centre to centre, one a cell (m).
  const std::vector<float>& distances_m() const { return distance_m_; }
  // From a point to the nearest obstacle, that fills its cell: the distance of
  // its centre, between centres by bilinear interpolation, less half a cell. 0
  // at most in obstacles; outside of the window less than 0: it is not known.
  double Distance_m(geometry::Vec2 point_in_map) const;
  // Unit vector away from the nearest obstacle; 0 where there is none.
  geometry::Vec2 Away(geometry::Vec2 point_in_map) const;
  // The free distance of the footprint at a pose; negative if it touches
  // something. Exact up to the grid: the least Distance_m along its edge.
  // Never more than max_distance_m.
  double FootprintDistance_m(const geometry::Rigid2& map_from_base,
                             double max_distance_m) const;

 private:
  bool IsObstacle(geometry::Vec2 point_in_map) const;

  CostmapWindow window_;
  Footprint footprint_;
  std::vector<geometry::Vec2> edge_in_base_;
  std::vector<geometry::Vec2> area_in_base_;
  std::vector<float> distance_m_;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_DISTANCE_LAYER_H_
