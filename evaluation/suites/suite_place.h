// What the mission and kidnap suites know of a world: its ground as it really
// is, and the map of it that the robot is given.
#ifndef EVALUATION_SUITES_SUITE_PLACE_H_
#define EVALUATION_SUITES_SUITE_PLACE_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "common/base/random.h"
#include "nav_agent/behavior/navigator.h"
#include "nav_agent/traversability/navigation_map.h"
#include "simulation/simulator/simulator.h"
#include "simulation/worlds/ground_truth.h"
#include "simulation/worlds/world.h"

namespace treeline::suites {

// Of the grid of places.
inline constexpr double kPlaceCell_m = 0.05;
// PlaceRadius_m of the default robot.
inline constexpr double kDefaultRobotRadius_m = 0.45;

// A robot has arrived, or knows where it is, up to these.
inline constexpr double kRightWithin_m = 0.5;
inline constexpr double kRightWithin_deg = 20;
// Levels lie further apart than this.
inline constexpr double kRightWithinHeight_m = 0.5;

struct PoseMiss {
  double distance_m = 0;
  double turn_deg = 0;
  double height_m = 0;

  bool IsRight() const {
    return distance_m <= kRightWithin_m && turn_deg <= kRightWithin_deg &&
           height_m <= kRightWithinHeight_m;
  }
};

// A disc on the ground that a robot cannot go through.
struct Barrier {
  geometry::Vec3 center;
  double radius_m = 0;
};

// Immutable and thread-safe. `robot_radius_m` of what makes one is that of a
// circle that holds the robot.
class SuitePlace {
 public:
  // What VoxelsOfWorld knows of it; the map's frame is the world's. Errors of
  // VoxelsOfWorld, GroundTruth and NavigationMap; FAILED_PRECONDITION if the
  // world has no tour with room for the robot.
  static absl::StatusOr<std::shared_ptr<const SuitePlace>> MakePerfect(
      worlds::World world, double robot_radius_m = kDefaultRobotRadius_m);
  // The same with the map of another state of that world, as Make.
  static absl::StatusOr<std::shared_ptr<const SuitePlace>> MakePerfect(
      worlds::World world, const worlds::World& mapped,
      double robot_radius_m = kDefaultRobotRadius_m);
  // The map of a bundle; map_from_world: where its drive began. Places are
  // those that the map has, too, with as much room: nobody sends a robot to
  // where its map has nothing. MappedShare() says how many those are.
  static absl::StatusOr<std::shared_ptr<const SuitePlace>> Make(
      worlds::World world, behavior::NavigatorMap map,
      const geometry::Rigid3& map_from_world,
      double robot_radius_m = kDefaultRobotRadius_m);

  // As it stands, people included.
  const worlds::World& world() const { return world_; }
  const behavior::NavigatorMap& map() const { return map_; }
  const geometry::Rigid3& map_from_world() const { return map_from_world_; }

  // Of the places with room for the robot in the world, the share that a robot
  // gets to in its map; 1 of a perfect map.
  double MappedShare() const { return mapped_share_; }

  // Anywhere with room for the robot, looking anywhere. Somebody may stand
  // there all the same.
  simulator::RobotPlacement AnyPlace(base::Random& random) const;
  // The same, within a distance.
  std::optional<simulator::RobotPlacement> AnyPlaceNear(
      geometry::Vec3 center, double radius_m, base::Random& random) const;
  // The shortest way for a round robot that holds the real one, over all
  // levels, around barriers (m); nullopt: there is none. Along a grid, so up to
  // 8 % longer than it really is.
  std::optional<double> PathLength_m(
      const simulator::RobotPlacement& from,
      const simulator::RobotPlacement& to,
      const std::vector<Barrier>& barriers = {}) const;
  // Whether somebody can walk straight from one to the other.
  bool IsStraightWay(const simulator::RobotPlacement& from,
                     const simulator::RobotPlacement& to) const;
  bool HasSeveralHeights() const { return has_several_heights_; }

  // As the map has it; NOT_FOUND where the map has no ground.
  absl::StatusOr<core::LevelPose> InMap(
      const simulator::RobotPlacement& placement) const;
  // How wrong an estimate is.
  PoseMiss ErrorOf(const core::LevelPose& estimate,
                   const geometry::Rigid3& world_from_base) const;
  // From there to what the map says a robot must not touch (m).
  double ClearanceInMap_m(const core::LevelPose& pose) const {
    return ground_.Clearance_m(pose.place.level,
                               pose.map_from_base.translation);
  }
  // In the world's frame, for pictures.
  geometry::Vec3 InWorld(geometry::Vec2 point_in_map, double height_m) const;

 private:
  SuitePlace(worlds::World world, behavior::NavigatorMap map,
             traversability::NavigationMap ground, worlds::GroundTruth truth,
             const geometry::Rigid3& map_from_world, double robot_radius_m)
      : world_(std::move(world)),
        map_(std::move(map)),
        ground_(std::move(ground)),
        truth_(std::move(truth)),
        map_from_world_(map_from_world),
        robot_radius_m_(robot_radius_m) {}
  static absl::StatusOr<std::shared_ptr<const SuitePlace>> Make(
      worlds::World world, behavior::NavigatorMap map,
      const geometry::Rigid3& map_from_world, double robot_radius_m,
      bool is_driven);
  void FindPlaces();
  void SetPlaces(std::vector<worlds::GroundCellIndex> places);
  // Leaves the places that the map has and that hang together there.
  void KeepMappedPlaces();
  // Numbers of the places that can be got to from this one, itself included.
  std::vector<int> PlacesReachedFrom(int node,
                                     std::vector<uint8_t>& is_seen) const;
  int NodeAt(geometry::Vec3 point) const;
  int NeighbourOf(int node, int dx, int dy) const;
  simulator::RobotPlacement PlacementOf(const worlds::GroundCellIndex& cell,
                                        base::Random& random) const;

  worlds::World world_;
  behavior::NavigatorMap map_;
  traversability::NavigationMap ground_;
  worlds::GroundTruth truth_;
  geometry::Rigid3 map_from_world_;
  // Of the round robot that there must be room for.
  double robot_radius_m_;
  double mapped_share_ = 1;
  bool has_several_heights_ = false;
  // Cells with room for the robot, and which of them each cell of each level
  // is (-1: none).
  std::vector<worlds::GroundCellIndex> places_;
  std::vector<std::vector<int>> place_of_cell_;
};

// Where a robot is, seen from above.
simulator::RobotPlacement PlacementOf(const geometry::Rigid3& world_from_base);

}  // namespace treeline::suites

#endif  // EVALUATION_SUITES_SUITE_PLACE_H_
