// The map's part of a local costmap: the ground that continues the robot's own.
#ifndef NAV_AGENT_CONTROL_GROUND_LAYER_H_
#define NAV_AGENT_CONTROL_GROUND_LAYER_H_

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "nav_agent/control/costmap_window.h"
#include "nav_agent/core/level_pose.h"
#include "nav_agent/traversability/loose_things.h"
#include "nav_agent/traversability/navigation_map.h"

namespace treeline::control {

// For each cell of a window the ground that the robot would stand on there:
// from its own cell on, from neighbour to neighbour, where heights differ by at
// most kStepVoxels voxels of the map. So on ramps and over joins each cell has
// the level that the robot would be on there, and what is below or above a
// platform is not in the way. All else is an obstacle of the map: walls, drops,
// unknown, what is off the map.
//
// Deterministic; not thread-safe.
class GroundLayer {
 public:
  // Of so many cells, none of which is ground yet.
  GroundLayer(std::shared_ptr<const traversability::NavigationMap> map,
              size_t cells);

  // Cells that are ground although the map has something there; null: none.
  // Spread follows. Whether they are others than before.
  bool SetFreed(std::shared_ptr<const traversability::FreedCells> freed);
  // Anew, for a window around a robot at `pose`.
  void Spread(const CostmapWindow& window, const core::LevelPose& pose);
  // For a robot that is lost the map is not asked: ground everywhere, level at
  // the height of `pose`, but uphill of a robot that stands on a slope. rise:
  // of that slope, along the map's axes (m/m).
  void SpreadLevel(const CostmapWindow& window, const core::LevelPose& pose,
                   geometry::Vec2 rise = {});

  // Of a cell of the window, by its number.
  bool IsGround(size_t i) const { return ground_[i].level >= 0; }
  double Height_m(size_t i) const { return ground_[i].height_m; }
  std::optional<core::LevelPlace> PlaceAt(size_t i) const;
  // From its centre to that of the nearest cell without ground (m).
  double MapDistance_m(size_t i) const { return map_distance_m_[i]; }
  // The map was not asked.
  bool map_is_unknown() const { return map_is_unknown_; }

  // The ground's height in a cell of the window, or beside it; else that of the
  // robot's.
  double HeightNear_m(const CostmapWindow& window, core::CellIndex cell) const;
  // Whether what a beam of range_m ends on at height z_m, in a cell of the
  // window, stands there: higher than the ground by more than
  // kGroundTolerance_m and kGroundPerRange of the range, and lower than a robot
  // of this height.
  bool IsHeightOfObstacle(const CostmapWindow& window, core::CellIndex cell,
                          double z_m, double range_m,
                          double robot_height_m) const;
  // What is seen there is the map's.
  bool IsNearMap(size_t i) const;
  // No ground itself, it borders on ground.
  bool IsEdgeOfGround(const CostmapWindow& window, int x, int y) const;

  // Centres of the map's cells within radius_m of a pose, which need not be the
  // window's, that are not at the height of the pose's ground, within a step,
  // and border on cells that are. On slopes of 1 in 12 that holds for 0.9 m.
  std::vector<geometry::Vec2> MapObstacles(const core::LevelPose& pose,
                                           double radius_m) const;

 private:
  struct Ground {
    int level = -1;
    float height_m = 0;
  };

  core::CellIndex MapCellAt(geometry::Vec2 point_in_map) const;
  std::optional<Ground> StepOnto(core::CellIndex map_cell,
                                 const Ground& from) const;
  bool Seed(const CostmapWindow& window, const core::LevelPose& pose,
            std::vector<int>& open);
  void MeasureDistances(const CostmapWindow& window);

  // The ground's height there, of a level, as the map has it or as it was
  // freed.
  std::optional<float> FreeGround_m(int level, core::CellIndex map_cell) const;

  std::shared_ptr<const traversability::NavigationMap> map_;
  std::shared_ptr<const traversability::FreedCells> freed_;
  // The map's grid from the map's frame: a rotation, then cells.
  double map_cos_ = 1;
  double map_sin_ = 0;
  geometry::Vec2 map_origin_;

  // One a cell of the window.
  std::vector<Ground> ground_;
  std::vector<float> map_distance_m_;
  double robot_height_m_ = 0;
  bool map_is_unknown_ = false;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_GROUND_LAYER_H_
