// A map that was made of a drive through a synthetic world, cell by cell
// against that world as it is without what moves. Figures:
// docs/research/traversability.md.
//
//   score_map [--no-people] WORLD BUNDLE [PICTURE.png]
//
//   ghosts  the map has an obstacle, and the world is free there and in the
//           eight cells around
//   eaten   the map is free, nothing around is an obstacle in it, and the world
//           has one
//
// The drive must have begun at the world's start, as those of `treeline-agent
// simulate` do. --no-people: nobody was about; else the start is where nobody
// stood.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"
#include "nav_agent/map_bundle/map_bundle.h"
#include "nav_agent/traversability/traversability.h"
#include "simulation/simulator/scenario_player.h"
#include "simulation/worlds/ground_truth.h"

namespace treeline {
namespace {

// Ground of the map and of the world within this (m) is the same.
constexpr double kSameGround_m = 0.2;

enum class Cell : uint8_t {
  kNotSeen,
  kFree,
  kObstacle,
  kUnsure,  // next to another true state
  kMissed,  // free, and unknown to the map
  kGhost,
  kEaten
};

struct Counts {
  int64_t free = 0;
  int64_t obstacles = 0;
  int64_t ghosts = 0;
  int64_t eaten = 0;
};

class Scorer {
 public:
  Scorer(const worlds::GroundTruth& truth,
         const traversability::TraversableMap& map,
         const geometry::Rigid3& map_from_world)
      : truth_(truth), map_(map), map_from_world_(map_from_world) {
    for (const traversability::TraversableLevel& level : map.levels) {
      auto& [low_m, high_m] =
          ranges_.emplace_back(std::numeric_limits<double>::infinity(),
                               -std::numeric_limits<double>::infinity());
      for (size_t i = 0; i < level.grid.cells.size(); ++i) {
        if (level.grid.cells[i] != core::Occupancy::kFree) continue;
        low_m = std::min<double>(low_m, level.height_m[i]);
        high_m = std::max<double>(high_m, level.height_m[i]);
      }
    }
  }

  Cell Judge(const worlds::GroundCellIndex& at) const {
    const worlds::GroundCell& cell = truth_.at(at);
    if (cell.state == worlds::GroundState::kUnknown) return Cell::kNotSeen;
    const double cell_m = truth_.options().resolution_m;
    const geometry::Vec3 place =
        map_from_world_ * geometry::Vec3{(at.x + 0.5) * cell_m,
                                         (at.y + 0.5) * cell_m,
                                         double{cell.height_m}};
    const core::Occupancy here = StateAt(place, 0, 0);
    if (cell.state == worlds::GroundState::kFree) {
      if (here == core::Occupancy::kFree) return Cell::kFree;
      if (!IsFreeAround(at)) return Cell::kUnsure;
      return here == core::Occupancy::kOccupied ? Cell::kGhost : Cell::kMissed;
    }
    if (here == core::Occupancy::kOccupied) return Cell::kObstacle;
    if (here == core::Occupancy::kUnknown) return Cell::kNotSeen;
    return HasObstacleAround(place) ? Cell::kUnsure : Cell::kEaten;
  }

 private:
  // Of the level whose ground is near that height; free where there are two.
  core::Occupancy StateAt(const geometry::Vec3& place, int dx, int dy) const {
    core::Occupancy state = core::Occupancy::kUnknown;
    for (size_t i = 0; i < map_.levels.size(); ++i) {
      const traversability::TraversableLevel& level = map_.levels[i];
      if (place.z < ranges_[i].first - kSameGround_m ||
          place.z > ranges_[i].second + kSameGround_m) {
        continue;
      }
      core::CellIndex cell = level.grid.CellOf({place.x, place.y});
      cell.x += dx;
      cell.y += dy;
      if (!level.grid.Contains(cell)) continue;
      const size_t index = level.grid.IndexOf(cell);
      const core::Occupancy found = level.grid.cells[index];
      if (found == core::Occupancy::kUnknown) continue;
      const bool is_free =
          found == core::Occupancy::kFree &&
          std::abs(level.height_m[index] - place.z) < kSameGround_m;
      if (is_free) return core::Occupancy::kFree;
      state = core::Occupancy::kOccupied;
    }
    return state;
  }

  bool HasObstacleAround(const geometry::Vec3& place) const {
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        if (StateAt(place, dx, dy) == core::Occupancy::kOccupied) return true;
      }
    }
    return false;
  }

  bool IsFreeAround(const worlds::GroundCellIndex& at) const {
    const float height_m = truth_.at(at).height_m;
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        const worlds::GroundCellIndex next{at.level, at.x + dx, at.y + dy};
        if (next.x < 0 || next.y < 0 || next.x >= truth_.width() ||
            next.y >= truth_.height()) {
          return false;
        }
        const worlds::GroundCell& cell = truth_.at(next);
        if (cell.state != worlds::GroundState::kFree ||
            std::abs(cell.height_m - height_m) > 0.05F) {
          return false;
        }
      }
    }
    return true;
  }

  const worlds::GroundTruth& truth_;
  const traversability::TraversableMap& map_;
  geometry::Rigid3 map_from_world_;
  std::vector<std::pair<double, double>> ranges_;
};

std::array<uint8_t, 3> ColorOf(Cell cell) {
  switch (cell) {
    case Cell::kNotSeen:
      return {205, 205, 205};
    case Cell::kFree:
      return {255, 255, 255};
    case Cell::kObstacle:
      return {0, 0, 0};
    case Cell::kUnsure:
      return {140, 150, 190};
    case Cell::kMissed:
      return {225, 235, 205};
    case Cell::kGhost:
      return {255, 110, 0};
    case Cell::kEaten:
      return {200, 0, 255};
  }
  return {};
}

// All levels, one above the other.
Counts Score(const worlds::GroundTruth& truth, const Scorer& scorer,
             image::ColorImage& picture) {
  Counts counts;
  const int levels = static_cast<int>(truth.levels().size());
  picture = {
      .width = truth.width(), .height = levels * truth.height(), .rgb = {}};
  for (int level = 0; level < levels; ++level) {
    for (int y = truth.height() - 1; y >= 0; --y) {
      for (int x = 0; x < truth.width(); ++x) {
        const Cell cell = scorer.Judge({level, x, y});
        counts.free += cell == Cell::kFree;
        counts.obstacles += cell == Cell::kObstacle;
        counts.ghosts += cell == Cell::kGhost;
        counts.eaten += cell == Cell::kEaten;
        const std::array<uint8_t, 3> color = ColorOf(cell);
        picture.rgb.insert(picture.rgb.end(), color.begin(), color.end());
      }
    }
  }
  return counts;
}

absl::Status Run(bool with_people, const std::string& name,
                 const std::string& folder, const std::string& picture_path) {
  simulator::Scenario scenario;
  scenario.world = name;
  scenario.world_options = {
      .with_people = with_people, .threads = 1, .paint = false};
  TL_ASSIGN_OR_RETURN(const worlds::World world,
                      simulator::MakeWorldOf(scenario));
  const simulator::RobotPlacement& start = scenario.options.start;
  const geometry::Rigid3 world_from_map = {
      .rotation = geometry::Rotation3::FromAxisAngle({0, 0, start.yaw_rad}),
      .translation = {start.position.x, start.position.y, start.height_m}};
  TL_ASSIGN_OR_RETURN(const map_bundle::MapBundle bundle,
                      map_bundle::LoadMapBundle(folder));
  const traversability::TraversabilityOptions options;
  TL_ASSIGN_OR_RETURN(const worlds::GroundTruth truth,
                      worlds::GroundTruth::Compute(
                          world, {.resolution_m = 0.05,
                                  .max_slope_rad = options.max_slope_rad,
                                  .max_step_m = options.max_step_m,
                                  .clearance_m = options.robot_height_m}));
  image::ColorImage picture;
  const Counts counts = Score(
      truth, Scorer(truth, bundle.levels, world_from_map.Inverse()), picture);
  std::printf("%-12s free %lld obstacles %lld ghosts %lld eaten %lld\n",
              name.c_str(), static_cast<long long>(counts.free),
              static_cast<long long>(counts.obstacles),
              static_cast<long long>(counts.ghosts),
              static_cast<long long>(counts.eaten));
  if (picture_path.empty()) return absl::OkStatus();
  TL_ASSIGN_OR_RETURN(const std::string png, image::EncodePng(picture));
  return base::WriteFileAtomically(picture_path, png);
}

}  // namespace
}  // namespace treeline

int main(int argc, char** argv) {
  std::vector<std::string> names(argv + 1, argv + argc);
  const bool with_people = names.empty() || names[0] != "--no-people";
  if (!with_people) names.erase(names.begin());
  if (names.size() < 2 || names.size() > 3) {
    std::fprintf(stderr, "usage: %s [--no-people] WORLD BUNDLE [PICTURE.png]\n",
                 argv[0]);
    return EXIT_FAILURE;
  }
  names.resize(3);
  const absl::Status status =
      treeline::Run(with_people, names[0], names[1], names[2]);
  if (status.ok()) return EXIT_SUCCESS;
  std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return EXIT_FAILURE;
}
