#include "evaluation/suites/suite_place.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/status_macros.h"
#include "common/geometry/planar_pose.h"
#include "simulation/runs/localize_world.h"

namespace treeline::suites {
namespace {

// As steep as a robot may stand on, less what Eq. 6.2 can be wrong by.
constexpr double kMaxSlope_rad = 0.175;
// Who walks needs less room.
constexpr double kPersonRadius_m = 0.3;
constexpr double kSeveralHeights_m = 0.25;

worlds::Float3 GroundPoint(const simulator::RobotPlacement& placement) {
  return {static_cast<float>(placement.position.x),
          static_cast<float>(placement.position.y),
          static_cast<float>(placement.height_m)};
}

geometry::Vec2 CenterOf(const worlds::GroundCellIndex& cell) {
  return {(cell.x + 0.5) * kPlaceCell_m, (cell.y + 0.5) * kPlaceCell_m};
}

absl::StatusOr<behavior::NavigatorMap> PerfectMapOf(
    const worlds::World& world) {
  behavior::NavigatorMap map;
  TL_ASSIGN_OR_RETURN(map.voxels, runs::VoxelsOfWorld(world, kPlaceCell_m));
  TL_ASSIGN_OR_RETURN(map.levels,
                      traversability::ExtractTraversableMap(map.voxels));
  return map;
}

bool IsBarred(geometry::Vec3 point, const std::vector<Barrier>& barriers,
              double robot_radius_m) {
  return std::ranges::any_of(barriers, [&](const Barrier& barrier) {
    return std::abs(barrier.center.z - point.z) < 1 &&
           std::hypot(barrier.center.x - point.x, barrier.center.y - point.y) <
               barrier.radius_m + robot_radius_m;
  });
}

}  // namespace

simulator::RobotPlacement PlacementOf(const geometry::Rigid3& world_from_base) {
  const geometry::Rigid2 planar = geometry::PlanarPose(world_from_base);
  return {.position = planar.translation,
          .yaw_rad = planar.yaw_rad,
          .height_m = world_from_base.translation.z};
}

absl::StatusOr<std::shared_ptr<const SuitePlace>> SuitePlace::MakePerfect(
    worlds::World world, double robot_radius_m) {
  TL_ASSIGN_OR_RETURN(behavior::NavigatorMap map, PerfectMapOf(world));
  return Make(std::move(world), std::move(map), geometry::Rigid3{},
              robot_radius_m, /*is_driven=*/false);
}

absl::StatusOr<std::shared_ptr<const SuitePlace>> SuitePlace::MakePerfect(
    worlds::World world, const worlds::World& mapped, double robot_radius_m) {
  TL_ASSIGN_OR_RETURN(behavior::NavigatorMap map, PerfectMapOf(mapped));
  return Make(std::move(world), std::move(map), geometry::Rigid3{},
              robot_radius_m);
}

absl::StatusOr<std::shared_ptr<const SuitePlace>> SuitePlace::Make(
    worlds::World world, behavior::NavigatorMap map,
    const geometry::Rigid3& map_from_world, double robot_radius_m) {
  return Make(std::move(world), std::move(map), map_from_world, robot_radius_m,
              /*is_driven=*/true);
}

absl::StatusOr<std::shared_ptr<const SuitePlace>> SuitePlace::Make(
    worlds::World world, behavior::NavigatorMap map,
    const geometry::Rigid3& map_from_world, double robot_radius_m,
    bool is_driven) {
  TL_ASSIGN_OR_RETURN(traversability::NavigationMap ground,
                      traversability::NavigationMap::Make(map.levels));
  TL_ASSIGN_OR_RETURN(
      worlds::GroundTruth truth,
      worlds::GroundTruth::Compute(world, {.resolution_m = kPlaceCell_m,
                                           .max_slope_rad = kMaxSlope_rad}));
  std::shared_ptr<SuitePlace> place(
      new SuitePlace(std::move(world), std::move(map), std::move(ground),
                     std::move(truth), map_from_world, robot_radius_m));
  place->FindPlaces();
  if (is_driven) place->KeepMappedPlaces();
  if (place->places_.empty()) {
    return absl::FailedPreconditionError(absl::StrCat(
        "world ", place->world_.name,
        " has no tour with room for the robot to begin at; a world file needs "
        "'tour' (docs/reference/world-files.md)"));
  }
  return place;
}

void SuitePlace::FindPlaces() {
  // From the corner of the tour from which most can be reached.
  worlds::GroundTruth::Reach reach;
  for (const worlds::Float3& corner : world_.tour) {
    worlds::GroundTruth::Reach from =
        truth_.ReachableFrom(corner, robot_radius_m_);
    if (from.count() > reach.count()) reach = std::move(from);
    if (2 * reach.count() > static_cast<size_t>(truth_.width()) *
                                static_cast<size_t>(truth_.height()) / 8) {
      break;
    }
  }
  std::vector<worlds::GroundCellIndex> places;
  for (int level = 0; level < static_cast<int>(truth_.levels().size());
       ++level) {
    for (int y = 0; y < truth_.height(); ++y) {
      for (int x = 0; x < truth_.width(); ++x) {
        const worlds::GroundCellIndex index = {.level = level, .x = x, .y = y};
        if (reach.count() > 0 && reach.Contains(index)) places.push_back(index);
      }
    }
  }
  SetPlaces(std::move(places));
}

void SuitePlace::SetPlaces(std::vector<worlds::GroundCellIndex> places) {
  places_ = std::move(places);
  place_of_cell_.assign(
      truth_.levels().size(),
      std::vector<int>(static_cast<size_t>(truth_.width() * truth_.height()),
                       -1));
  float lowest_m = std::numeric_limits<float>::infinity();
  float highest_m = -lowest_m;
  for (size_t i = 0; i < places_.size(); ++i) {
    const worlds::GroundCellIndex& cell = places_[i];
    place_of_cell_[static_cast<size_t>(cell.level)]
                  [static_cast<size_t>(cell.y * truth_.width() + cell.x)] =
                      static_cast<int>(i);
    lowest_m = std::min(lowest_m, truth_.at(cell).height_m);
    highest_m = std::max(highest_m, truth_.at(cell).height_m);
  }
  has_several_heights_ = highest_m - lowest_m > kSeveralHeights_m;
}

void SuitePlace::KeepMappedPlaces() {
  const size_t all = places_.size();
  std::vector<worlds::GroundCellIndex> mapped;
  for (const worlds::GroundCellIndex& cell : places_) {
    const absl::StatusOr<core::LevelPose> pose = InMap(
        {.position = CenterOf(cell), .height_m = truth_.at(cell).height_m});
    if (pose.ok() && ClearanceInMap_m(*pose) >= robot_radius_m_) {
      mapped.push_back(cell);
    }
  }
  SetPlaces(std::move(mapped));
  std::vector<int> most;
  std::vector<uint8_t> is_seen(places_.size(), 0);
  for (int i = 0; i < static_cast<int>(places_.size()); ++i) {
    if (is_seen[static_cast<size_t>(i)] != 0) continue;
    std::vector<int> reached = PlacesReachedFrom(i, is_seen);
    if (reached.size() > most.size()) most = std::move(reached);
  }
  std::ranges::sort(most);
  std::vector<worlds::GroundCellIndex> together;
  together.reserve(most.size());
  for (const int node : most) {
    together.push_back(places_[static_cast<size_t>(node)]);
  }
  SetPlaces(std::move(together));
  mapped_share_ =
      all == 0 ? 0
               : static_cast<double>(places_.size()) / static_cast<double>(all);
}

std::vector<int> SuitePlace::PlacesReachedFrom(
    int node, std::vector<uint8_t>& is_seen) const {
  std::vector<int> reached = {node};
  is_seen[static_cast<size_t>(node)] = 1;
  for (size_t next = 0; next < reached.size(); ++next) {
    for (const auto& [dx, dy] : {std::pair(1, 0), std::pair(-1, 0),
                                 std::pair(0, 1), std::pair(0, -1)}) {
      const int neighbour = NeighbourOf(reached[next], dx, dy);
      if (neighbour < 0 || is_seen[static_cast<size_t>(neighbour)] != 0) {
        continue;
      }
      is_seen[static_cast<size_t>(neighbour)] = 1;
      reached.push_back(neighbour);
    }
  }
  return reached;
}

simulator::RobotPlacement SuitePlace::PlacementOf(
    const worlds::GroundCellIndex& cell, base::Random& random) const {
  return {.position = CenterOf(cell),
          .yaw_rad = random.NextUniform(-std::numbers::pi, std::numbers::pi),
          .height_m = truth_.at(cell).height_m};
}

simulator::RobotPlacement SuitePlace::AnyPlace(base::Random& random) const {
  return PlacementOf(
      places_[random.NextBelow(static_cast<uint32_t>(places_.size()))], random);
}

std::optional<simulator::RobotPlacement> SuitePlace::AnyPlaceNear(
    geometry::Vec3 center, double radius_m, base::Random& random) const {
  constexpr int kTries = 4000;
  for (int i = 0; i < kTries; ++i) {
    const simulator::RobotPlacement place = AnyPlace(random);
    if (std::hypot(place.position.x - center.x, place.position.y - center.y) <
            radius_m &&
        std::abs(place.height_m - center.z) < 1) {
      return place;
    }
  }
  return std::nullopt;
}

int SuitePlace::NodeAt(geometry::Vec3 point) const {
  const int x = static_cast<int>(std::floor(point.x / kPlaceCell_m));
  const int y = static_cast<int>(std::floor(point.y / kPlaceCell_m));
  if (x < 0 || y < 0 || x >= truth_.width() || y >= truth_.height()) return -1;
  int best = -1;
  double best_m = 0.3;
  for (const std::vector<int>& level : place_of_cell_) {
    const int node = level[static_cast<size_t>(y * truth_.width() + x)];
    if (node < 0) continue;
    const double away_m = std::abs(
        truth_.at(places_[static_cast<size_t>(node)]).height_m - point.z);
    if (away_m >= best_m) continue;
    best_m = away_m;
    best = node;
  }
  return best;
}

int SuitePlace::NeighbourOf(int node, int dx, int dy) const {
  const worlds::GroundCellIndex& cell = places_[static_cast<size_t>(node)];
  const int x = cell.x + dx;
  const int y = cell.y + dy;
  if (x < 0 || y < 0 || x >= truth_.width() || y >= truth_.height()) return -1;
  constexpr float kStep_m = 0.04f;
  for (const std::vector<int>& level : place_of_cell_) {
    const int next = level[static_cast<size_t>(y * truth_.width() + x)];
    if (next >= 0 &&
        std::abs(truth_.at(places_[static_cast<size_t>(next)]).height_m -
                 truth_.at(cell).height_m) < kStep_m) {
      return next;
    }
  }
  return -1;
}

std::optional<double> SuitePlace::PathLength_m(
    const simulator::RobotPlacement& from, const simulator::RobotPlacement& to,
    const std::vector<Barrier>& barriers) const {
  const auto node_of = [this](const simulator::RobotPlacement& placement) {
    return NodeAt(
        {placement.position.x, placement.position.y, placement.height_m});
  };
  const int begin = node_of(from);
  const int end = node_of(to);
  if (begin < 0 || end < 0) return std::nullopt;
  constexpr double kFar_m = std::numeric_limits<double>::infinity();
  std::vector<double> way_m(places_.size(), kFar_m);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  way_m[static_cast<size_t>(begin)] = 0;
  open.push({0, begin});
  while (!open.empty()) {
    const auto [here_m, node] = open.top();
    open.pop();
    if (node == end) return here_m;
    if (here_m > way_m[static_cast<size_t>(node)]) continue;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (dx == 0 && dy == 0) continue;
        const int next = NeighbourOf(node, dx, dy);
        if (next < 0) continue;
        const double there_m = here_m + kPlaceCell_m * std::hypot(dx, dy);
        if (there_m >= way_m[static_cast<size_t>(next)]) continue;
        const worlds::GroundCellIndex& cell =
            places_[static_cast<size_t>(next)];
        const geometry::Vec2 center = CenterOf(cell);
        if (IsBarred({center.x, center.y, truth_.at(cell).height_m}, barriers,
                     robot_radius_m_)) {
          continue;
        }
        way_m[static_cast<size_t>(next)] = there_m;
        open.push({there_m, next});
      }
    }
  }
  return std::nullopt;
}

bool SuitePlace::IsStraightWay(const simulator::RobotPlacement& from,
                               const simulator::RobotPlacement& to) const {
  return truth_.IsDriveable({GroundPoint(from), GroundPoint(to)},
                            kPersonRadius_m);
}

absl::StatusOr<core::LevelPose> SuitePlace::InMap(
    const simulator::RobotPlacement& placement) const {
  const geometry::Vec3 point_in_map =
      map_from_world_ * geometry::Vec3{placement.position.x,
                                       placement.position.y,
                                       placement.height_m};
  const geometry::Vec2 at = {point_in_map.x, point_in_map.y};
  const auto ground = ground_.GroundNear(at, point_in_map.z);
  if (!ground.has_value() ||
      std::abs(ground->height_m - point_in_map.z) > kRightWithinHeight_m) {
    return absl::NotFoundError(absl::StrFormat(
        "the map of %s has no ground at (%.2f, %.2f, %.2f)", world_.name,
        point_in_map.x, point_in_map.y, point_in_map.z));
  }
  return core::LevelPose{{at, geometry::NormalizedAngle_rad(
                                  placement.yaw_rad +
                                  geometry::Yaw_rad(map_from_world_.rotation))},
                         *ground};
}

PoseMiss SuitePlace::ErrorOf(const core::LevelPose& estimate,
                             const geometry::Rigid3& world_from_base) const {
  const geometry::Rigid3 map_from_base = map_from_world_ * world_from_base;
  const geometry::Rigid2 truth = geometry::PlanarPose(map_from_base);
  return {.distance_m =
              Norm(truth.translation - estimate.map_from_base.translation),
          .turn_deg = std::abs(geometry::NormalizedAngle_rad(
                          truth.yaw_rad - estimate.map_from_base.yaw_rad)) *
                      180 / std::numbers::pi,
          .height_m =
              std::abs(map_from_base.translation.z - estimate.place.height_m)};
}

geometry::Vec3 SuitePlace::InWorld(geometry::Vec2 point_in_map,
                                   double height_m) const {
  return map_from_world_.Inverse() *
         geometry::Vec3{point_in_map.x, point_in_map.y, height_m};
}

}  // namespace treeline::suites
