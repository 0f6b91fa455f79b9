// What stands around the robot: the map's ground, and what its sensors see.
#ifndef NAV_AGENT_CONTROL_LOCAL_COSTMAP_H_
#define NAV_AGENT_CONTROL_LOCAL_COSTMAP_H_

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "nav_agent/control/control_pose.h"
#include "nav_agent/control/footprint.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/core/sensor_data.h"
#include "nav_agent/traversability/navigation_map.h"

namespace treeline::control {

struct LocalCostmapOptions {
  // Along the map's x and y (m, 1 to 20), and of a cell (m, 0.01 to 0.2).
  double length_m = 4.0;
  double width_m = 4.0;
  double resolution_m = 0.05;
  // Scans or frames that must have hit a cell before it counts, the most that
  // are remembered, and how many each one takes back that looks through it.
  int hits_to_mark = 3;
  int most_hits = 8;
  int miss_weight = 2;
  // What ends this near to the height of the ground at its place is ground:
  // this, and this times the range (m, 1).
  double ground_m = 0.10;
  double ground_per_range = 0.01;
  // Seen obstacles are taken to be wider by this than what the sensors show of
  // them: people and carts are, above and below a laser's plane (m).
  double widening_m = 0.15;
  // What is seen this near to what the map has already is the map's (m).
  double map_band_m = 0.075;
  // Only what is seen further from the map's obstacles is widened, or so far
  // if its place was seen free before (m).
  double new_from_m = 0.20;
  double came_from_m = 0.12;
  // What has stood for so long stands; before that it moves, if the place was
  // seen free before (s).
  double standing_after_s = 1.0;
  // Unseen, what moves is forgotten after this time, and what stands after
  // that (s).
  double moving_memory_s = 2.0;
  double standing_memory_s = 60.0;
  // Depth beyond is not used; of a picture so many columns are at most, and
  // rows as far apart (m, 1).
  double depth_range_m = 3.0;
  int depth_columns = 160;

  absl::Status Validate() const;
};

// A point of something that a sensor saw.
struct SeenPoint {
  geometry::Vec2 in_map;
  // It was not there a moment ago.
  bool is_moving = false;
  // The map has nothing there.
  bool is_new = false;
};

// A cell's centre.
struct UnseenObstacle {
  geometry::Vec2 in_map;
  // Seen, rather than the map's.
  bool is_new = false;
};

enum class LocalCell : uint8_t { kFree = 0, kMapObstacle = 1, kSeen = 2 };

// A grid with the map's axes that rolls along with the robot.
//
// The map's layer is the ground that continues the robot's own: from its cell
// on, from neighbour to neighbour, where heights differ by one step of the
// map's voxels at most. So on ramps and over joins each cell has the level that
// the robot would be on there, and what is below or above a platform is not in
// the way. All else is an obstacle: walls, drops, unknown, what is off the map.
// For a robot that is lost (ControlPose::map_is_unknown) the map is not asked:
// there is level ground everywhere but where something was seen, and nothing is
// new.
//
// Seen obstacles: a beam's end is one if it lies above the ground of its place
// by more than ground_m + ground_per_range * range, and below the robot's
// height; what it passed on its way is free of what lasers saw. Depth points
// likewise, from the robot's ground clearance on where they are near.
//
// Seen obstacles that hang together.
struct SeenObstacle {
  geometry::Vec2 center_in_map;
  // 0: there is none.
  double radius_m = 0;
  // For how long its youngest tenth has been there (s).
  double age_s = 1e6;
};

// Deterministic; not thread-safe.
class LocalCostmap {
 public:
  static absl::StatusOr<LocalCostmap> Make(
      std::shared_ptr<const traversability::NavigationMap> map,
      const core::RobotModel& robot, const core::RobotLasers& lasers,
      const LocalCostmapOptions& options);

  // The window moves with the robot.
  void MoveTo(const ControlPose& pose);
  // INVALID_ARGUMENT: the number of beams is not the laser's, or the pose is
  // not finite.
  absl::Status AddScan(const ControlPose& pose, const core::LaserScan& scan,
                       core::LaserMount mount = core::LaserMount::kFront);
  absl::Status AddDepth(const ControlPose& pose, const core::RgbdFrame& frame);
  void ClearObstacles();
  // Forgets what is too old; distances are right afterwards.
  void Update(base::MonotonicTime now);

  int width() const { return width_; }
  int height() const { return height_; }
  double resolution_m() const { return options_.resolution_m; }
  geometry::Vec2 origin_in_map() const { return origin_in_map_; }
  LocalCell At(int x, int y) const { return cells_[IndexOf(x, y)]; }
  const std::vector<LocalCell>& cells() const { return cells_; }
  // From centre to centre of the nearest obstacle (m).
  const std::vector<float>& distances_m() const { return distance_m_; }
  geometry::Vec2 CenterInMap(int x, int y) const {
    return {origin_in_map_.x + (x + 0.5) * options_.resolution_m,
            origin_in_map_.y + (y + 0.5) * options_.resolution_m};
  }
  // Whether a point is in the window, `inset_m` from its edge.
  bool Contains(geometry::Vec2 point_in_map, double inset_m = 0) const;
  LocalCell CellAt(geometry::Vec2 point_in_map) const;
  // From a point to the nearest obstacle (seen ones widened), that fills its
  // cell: the distance of its centre, between centres by bilinear
  // interpolation, less half a cell. 0 at most in obstacles; outside of the
  // window less than 0: it is not known.
  double Distance_m(geometry::Vec2 point_in_map) const;
  // Unit vector away from the nearest obstacle; 0 where there is none.
  geometry::Vec2 Away(geometry::Vec2 point_in_map) const;
  // The free distance of the footprint at a pose; negative if it touches
  // something. Exact up to the grid: the least Distance_m along its edge.
  // Never more than at_most_m.
  double FootprintDistance_m(const geometry::Rigid2& map_from_base,
                             double at_most_m) const;
  // The ground there, if it continues the robot's.
  std::optional<core::LevelPlace> GroundAt(geometry::Vec2 point_in_map) const;

  // The seen obstacle nearest to a point, if it is within reach_m.
  SeenObstacle ObstacleNear(geometry::Vec2 point_in_map, double reach_m,
                            base::MonotonicTime now) const;

  // Centres of the obstacles' cells within radius_m of a point that no sensor
  // shows at this moment: the map's, where they border on ground, and seen ones
  // that are only remembered.
  std::vector<UnseenObstacle> UnseenObstacles(geometry::Vec2 at,
                                              double radius_m,
                                              base::MonotonicTime now) const;

  // Centres of the map's cells within radius_m of a pose, which need not be the
  // window's, that are not at the height of the pose's ground, within a step of
  // the map's voxels, and border on cells that are. On slopes of 1 in 12 that
  // holds for 0.9 m.
  std::vector<geometry::Vec2> MapObstacles(const core::LevelPose& pose,
                                           double radius_m) const;

  // The newest scan's and the newest frame's points on obstacles, the map's
  // included, near the robot.
  const std::vector<SeenPoint>& scan_points(
      core::LaserMount mount = core::LaserMount::kFront) const {
    return LaserAt(mount).points;
  }
  const std::vector<SeenPoint>& depth_points() const { return depth_points_; }
  std::optional<base::MonotonicTime> last_scan(
      core::LaserMount mount = core::LaserMount::kFront) const {
    return LaserAt(mount).last_scan;
  }
  std::optional<base::MonotonicTime> last_depth() const { return last_depth_; }

 private:
  // What is known of a cell's obstacles.
  struct Seen {
    uint8_t laser_hits = 0;
    uint8_t depth_hits = 0;
    bool was_free = false;
    // Somebody moved beside it when it was seen last: a cart's deck beside its
    // legs.
    bool is_of_mover = false;
    int64_t since_ms = 0;
    int64_t last_ms = 0;
    int64_t last_free_ms = 0;
  };
  struct Ground {
    int level = -1;
    float height_m = 0;
  };

  // One of the lasers, and what it has shown last. No beams: there is none.
  struct Laser {
    core::RangeSensorInfo info;
    std::vector<double> beam_cos;
    std::vector<double> beam_sin;
    std::optional<base::MonotonicTime> last_scan;
    std::vector<SeenPoint> points;
  };

  LocalCostmap(std::shared_ptr<const traversability::NavigationMap> map,
               const core::RobotModel& robot, const core::RobotLasers& lasers,
               const LocalCostmapOptions& options);

  const Laser& LaserAt(core::LaserMount mount) const {
    return lasers_[static_cast<size_t>(mount)];
  }

  size_t IndexOf(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width_) +
           static_cast<size_t>(x);
  }
  bool IsInside(int x, int y) const {
    return x >= 0 && y >= 0 && x < width_ && y < height_;
  }
  core::CellIndex CellOf(geometry::Vec2 point_in_map) const;
  std::optional<Ground> StepOnto(core::CellIndex map_cell,
                                 const Ground& from) const;
  core::CellIndex MapCellAt(geometry::Vec2 point_in_map) const;
  core::CellIndex MapCellOf(int x, int y) const {
    return MapCellAt(CenterInMap(x, y));
  }
  void SpreadGround(const core::LevelPose& pose);
  void MeasureMapDistances();
  void WidenSeen(std::vector<uint8_t>& is_obstacle) const;
  bool SeedGround(const core::LevelPose& pose, std::vector<int>& open);
  void Shift(int by_x, int by_y);
  int64_t Milliseconds(base::MonotonicTime time);
  bool IsHeightOfObstacle(core::CellIndex cell, double z_m, double range_m,
                          bool* near_map) const;
  void MarkHits(int64_t now_ms, uint8_t Seen::*hits);
  void ClearAlong(geometry::Vec3 from, geometry::Vec3 to, int64_t now_ms);
  // What is seen well away from all that the map has: nearer, it may be the
  // map's own, seen from an estimate that is off.
  bool IsNew(size_t i) const {
    return !map_is_unknown_ &&
           map_distance_m_[i] >
               (seen_[i].was_free ? options_.came_from_m : options_.new_from_m);
  }
  bool IsMoving(core::CellIndex cell, int64_t now_ms) const;
  bool IsBesideMover(size_t i) const;
  bool CountsAt(size_t i) const {
    return seen_[i].laser_hits >= options_.hits_to_mark ||
           seen_[i].depth_hits >= options_.hits_to_mark;
  }

  std::shared_ptr<const traversability::NavigationMap> map_;
  core::RobotModel robot_;
  LocalCostmapOptions options_;
  Footprint footprint_;
  std::vector<geometry::Vec2> edge_in_base_;
  std::vector<geometry::Vec2> area_in_base_;
  // By LaserMount.
  std::array<Laser, 2> lasers_;
  // The map's grid from the map's frame: a rotation, then cells.
  double map_cos_ = 1;
  double map_sin_ = 0;
  geometry::Vec2 map_origin_;

  int width_ = 0;
  int height_ = 0;
  // Of the window's lower left corner, in whole cells from the map's origin.
  int64_t cell_x_ = 0;
  int64_t cell_y_ = 0;
  geometry::Vec2 origin_in_map_;
  bool is_placed_ = false;
  core::LevelPose placed_at_;
  bool map_is_unknown_ = false;

  std::vector<Ground> ground_;
  std::vector<Seen> seen_;
  // To what of the map's is no ground (cells, squared; m).
  std::vector<float> map_distance_m_;
  std::vector<LocalCell> cells_;
  std::vector<float> distance_m_;
  // Cells that the scan or frame at hand hit, and passed: its number.
  std::vector<uint32_t> hit_in_;
  std::vector<uint32_t> passed_in_;
  std::vector<size_t> hit_cells_;
  uint32_t look_ = 1;
  // A second laser sees past the edges of what the first one hits: what was hit
  // in so many looks before is not passed.
  uint32_t held_looks_ = 0;

  std::optional<base::MonotonicTime> epoch_;
  std::optional<base::MonotonicTime> last_depth_;
  std::vector<SeenPoint> depth_points_;
};

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_LOCAL_COSTMAP_H_
