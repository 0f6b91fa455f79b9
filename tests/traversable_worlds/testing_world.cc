#include "tests/traversable_worlds/testing_world.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "simulation/renderer/ray_caster.h"

namespace treeline {
namespace {

constexpr double kDegPerRad = 180 / std::numbers::pi;
// Voxels below the lowest and above the highest surface.
constexpr int kMargin = 4;
// Ground of the truth and of a map is the same if it differs by less (m).
constexpr double kSameGround_m = 0.12;

octree::VoxelMap EmptyMapOf(const worlds::World& world, double resolution_m) {
  const auto cells = [resolution_m](float length_m) {
    return static_cast<int>(std::ceil(length_m / resolution_m - 1e-4));
  };
  return *octree::VoxelMap::Make(resolution_m, {.x = 0, .y = 0, .z = -kMargin},
                                 {cells(world.size_m.x), cells(world.size_m.y),
                                  cells(world.size_m.z) + 2 * kMargin});
}

void AddSurface(const worlds::Surface& surface, double lift_m,
                octree::VoxelMap& voxels) {
  const auto samples = [&voxels](float length_m) {
    return static_cast<int>(std::ceil(length_m / voxels.resolution_m() * 4)) +
           1;
  };
  const int count_u = samples(surface.LengthU());
  const int count_v = samples(surface.LengthV());
  for (int i = 0; i < count_u; ++i) {
    for (int j = 0; j < count_v; ++j) {
      const auto part = [](int k, int count) {
        return (static_cast<float>(k) + 0.5F) / static_cast<float>(count);
      };
      const worlds::Float3 point =
          surface.PointAt(part(i, count_u), part(j, count_v));
      const octree::VoxelIndex v =
          voxels.IndexOf({point.x, point.y, point.z + lift_m});
      if (voxels.Contains(v)) voxels.Set(v, octree::Voxel::kOccupied);
    }
  }
}

// Log-odds of voxels, in thousandths, and which were touched by a picture.
class Fusion {
 public:
  explicit Fusion(const octree::VoxelMap& box) : box_(box) {
    const octree::VoxelIndex size = box.size();
    const size_t count = static_cast<size_t>(size.x) *
                         static_cast<size_t>(size.y) *
                         static_cast<size_t>(size.z);
    odds_.resize(count, kUnseen);
    stamp_.resize(count, 0);
  }

  // The rays of one picture; hits win over misses.
  void Add(geometry::Vec3 origin, const std::vector<geometry::Vec3>& ends,
           const std::vector<uint8_t>& is_hit) {
    ++picture_;
    for (size_t i = 0; i < ends.size(); ++i) {
      if (is_hit[i] == 0) continue;
      const octree::VoxelIndex v = box_.IndexOf(ends[i]);
      if (box_.Contains(v) && Touch(v)) Change(v, 850);
    }
    for (const geometry::Vec3& end : ends) Carve(origin, end);
  }

  octree::VoxelMap Map() const {
    octree::VoxelMap map = box_;
    const octree::VoxelIndex size = box_.size();
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) {
        for (int z = 0; z < size.z; ++z) {
          const int16_t odds = odds_[At({x, y, z})];
          if (odds == kUnseen) continue;
          // A probability of 0.7.
          map.Set({x, y, z}, odds >= 847 ? octree::Voxel::kOccupied
                                         : octree::Voxel::kFree);
        }
      }
    }
    return map;
  }

 private:
  static constexpr int16_t kUnseen = -32768;

  size_t At(octree::VoxelIndex v) const {
    const octree::VoxelIndex size = box_.size();
    return (static_cast<size_t>(v.y) * static_cast<size_t>(size.x) +
            static_cast<size_t>(v.x)) *
               static_cast<size_t>(size.z) +
           static_cast<size_t>(v.z);
  }
  bool Touch(octree::VoxelIndex v) {
    uint32_t& stamp = stamp_[At(v)];
    const bool first = stamp != picture_;
    stamp = picture_;
    return first;
  }
  void Change(octree::VoxelIndex v, int by) {
    int16_t& odds = odds_[At(v)];
    const int before = odds == kUnseen ? 0 : odds;
    odds = static_cast<int16_t>(std::clamp(before + by, -2000, 3500));
  }
  // All voxels from origin up to the one before the end (Amanatides, Woo
  // 1987).
  void Carve(geometry::Vec3 origin, geometry::Vec3 end) {
    const octree::VoxelIndex last = box_.IndexOf(end);
    octree::VoxelIndex v = box_.IndexOf(origin);
    const double r = box_.resolution_m();
    const std::array<double, 3> from = {origin.x, origin.y, origin.z};
    const std::array<double, 3> way = {end.x - origin.x, end.y - origin.y,
                                       end.z - origin.z};
    const octree::VoxelIndex lowest = box_.lowest();
    std::array<int*, 3> at = {&v.x, &v.y, &v.z};
    const std::array<int, 3> low = {lowest.x, lowest.y, lowest.z};
    std::array<double, 3> next{};
    std::array<double, 3> step{};
    std::array<int, 3> sign{};
    for (size_t a = 0; a < 3; ++a) {
      sign[a] = way[a] < 0 ? -1 : 1;
      const double plane = (*at[a] + low[a] + (way[a] < 0 ? 0 : 1)) * r;
      step[a] = way[a] == 0 ? 1e30 : r / std::abs(way[a]);
      next[a] = way[a] == 0 ? 1e30 : (plane - from[a]) / way[a];
    }
    while (v != last) {
      if (box_.Contains(v) && Touch(v)) Change(v, -405);
      const size_t a = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2)
                                         : (next[1] < next[2] ? 1 : 2);
      if (next[a] > 1) return;
      *at[a] += sign[a];
      next[a] += step[a];
    }
  }

  const octree::VoxelMap& box_;
  std::vector<int16_t> odds_;
  std::vector<uint32_t> stamp_;
  uint32_t picture_ = 0;
};

constexpr double kCameraHeight_m = 1.1;
constexpr double kCameraDown_rad = 0.21;
constexpr double kHalfWidth = 0.554;   // tan of 29 deg
constexpr double kHalfHeight = 0.414;  // tan of 22.5 deg

// One picture from a place of the tour.
void AddPicture(const worlds::World& world, const renderer::RayCaster& caster,
                const ScanOptions& options, geometry::Vec3 place,
                double yaw_rad, base::Random& random, Fusion& fusion) {
  const int width = options.width_px;
  const int height = width * 3 / 4;
  const double c = std::cos(yaw_rad);
  const double s = std::sin(yaw_rad);
  const worlds::Float3 forward{
      static_cast<float>(c * std::cos(kCameraDown_rad)),
      static_cast<float>(s * std::cos(kCameraDown_rad)),
      static_cast<float>(-std::sin(kCameraDown_rad))};
  const worlds::Float3 left{static_cast<float>(-s), static_cast<float>(c), 0};
  const worlds::Float3 up = Cross(forward, left);
  const worlds::Float3 origin{static_cast<float>(place.x),
                              static_cast<float>(place.y),
                              static_cast<float>(place.z + kCameraHeight_m)};
  std::vector<worlds::Float3> directions;
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const double u = kHalfWidth * (1 - 2 * (column + 0.5) / width);
      const double v = kHalfHeight * (1 - 2 * (row + 0.5) / height);
      directions.push_back(forward + static_cast<float>(u) * left +
                           static_cast<float>(v) * up);
    }
  }
  std::vector<renderer::RayHit> hits(directions.size());
  caster.CastMany(origin, directions, hits);
  // What the map's maker believes of the camera is a little off.
  const double off_m = options.height_noise_m * random.NextGaussian();
  const double pitch_rad = options.tilt_noise_rad * random.NextGaussian();
  const double roll_rad = options.tilt_noise_rad * random.NextGaussian();
  const double lift_m = options.lift_m + off_m;
  const geometry::Vec3 believed{origin.x, origin.y, origin.z + lift_m};
  std::vector<geometry::Vec3> ends;
  std::vector<uint8_t> is_hit;
  for (size_t i = 0; i < hits.size(); ++i) {
    const worlds::Float3 ray = directions[i];
    // Depth along the optical axis: directions have 1 along it.
    double depth_m = hits[i].surface == renderer::RayHit::kNothing
                         ? options.max_range_m + 1
                         : hits[i].distance;
    const bool far = depth_m > options.max_range_m;
    if (!far) {
      const worlds::Float3 normal = world.surfaces[hits[i].surface].Normal();
      const float sine = std::abs(Dot(normal, Normalized(ray)));
      if (sine < 0.17F || depth_m < 0.4) continue;
      const double beyond_m = depth_m - 0.4;
      depth_m += (options.noise_base_m +
                  options.noise_square_per_m * beyond_m * beyond_m) *
                 random.NextGaussian();
    } else {
      continue;  // a depth camera says nothing there
    }
    const double x = depth_m * ray.x;
    const double y = depth_m * ray.y;
    const double ahead = c * x + s * y;
    const double aside = -s * x + c * y;
    ends.push_back({origin.x + x, origin.y + y,
                    origin.z + depth_m * ray.z + lift_m + pitch_rad * ahead +
                        roll_rad * aside});
    is_hit.push_back(1);
  }
  fusion.Add(believed, ends, is_hit);
}

struct Near {
  worlds::GroundState state = worlds::GroundState::kUnknown;
  float height_m = 0;
};

// Compares a map with the truth.
class Scorer {
 public:
  Scorer(const worlds::GroundTruth& truth, const octree::VoxelMap& voxels,
         const traversability::TraversableMap& map, double lift_m)
      : truth_(truth), voxels_(voxels), map_(map), lift_m_(lift_m) {
    for (const traversability::TraversableLevel& level : map.levels) {
      Range range;
      for (size_t i = 0; i < level.grid.cells.size(); ++i) {
        if (level.grid.cells[i] != core::Occupancy::kFree) continue;
        range.low_m = std::min<double>(range.low_m, level.height_m[i]);
        range.high_m = std::max<double>(range.high_m, level.height_m[i]);
      }
      ranges_.push_back(range);
    }
  }

  WorldScore Score() {
    for (size_t level = 0; level < truth_.levels().size(); ++level) {
      std::vector<Verdict> verdicts;
      for (int y = 0; y < truth_.height(); ++y) {
        for (int x = 0; x < truth_.width(); ++x) {
          verdicts.push_back(Judge({static_cast<int>(level), x, y}));
        }
      }
      score_.verdicts.push_back(std::move(verdicts));
    }
    return std::move(score_);
  }

 private:
  struct Range {
    double low_m = 1e9;
    double high_m = -1e9;
  };
  // Ours at a place.
  struct Answer {
    bool free = false;
    bool occupied = false;
    bool at_height = false;  // occupied, and ground of this height
    bool elsewhere = false;  // ground of another height is shown here
    size_t level = 0;
    size_t cell = 0;
  };

  core::CellIndex CellOf(int x, int y) const {
    return {x - voxels_.lowest().x, y - voxels_.lowest().y};
  }

  Answer AnswerAt(int x, int y, double height_m) const {
    Answer answer;
    const double in_map_m = height_m + lift_m_;
    for (size_t i = 0; i < map_.levels.size(); ++i) {
      const traversability::TraversableLevel& level = map_.levels[i];
      const core::CellIndex at = CellOf(x, y);
      if (!level.grid.Contains(at)) continue;
      const size_t cell = level.grid.IndexOf(at);
      const bool near =
          std::abs(level.height_m[cell] - in_map_m) < kSameGround_m;
      answer.elsewhere = answer.elsewhere || level.height_m[cell] > in_map_m;
      if (level.grid.cells[cell] == core::Occupancy::kFree && near) {
        answer.free = true;
        answer.level = i;
        answer.cell = cell;
      }
      if (level.grid.cells[cell] == core::Occupancy::kOccupied &&
          in_map_m > ranges_[i].low_m - 0.4 &&
          in_map_m < ranges_[i].high_m + 0.4) {
        answer.occupied = true;
        answer.at_height = answer.at_height || near;
      }
    }
    return answer;
  }

  // The truth's state around a height, on whatever level.
  Near TruthNear(int x, int y, double height_m) const {
    Near near;
    double best_m = 0.3;
    if (x < 0 || y < 0 || x >= truth_.width() || y >= truth_.height()) {
      return near;
    }
    for (size_t i = 0; i < truth_.levels().size(); ++i) {
      const worlds::GroundCell& cell = truth_.at({static_cast<int>(i), x, y});
      const double off_m = std::abs(cell.height_m - height_m);
      if (cell.state == worlds::GroundState::kUnknown || off_m >= best_m)
        continue;
      best_m = off_m;
      near = {.state = cell.state, .height_m = cell.height_m};
    }
    return near;
  }

  bool IsObserved(int x, int y, const worlds::GroundCell& cell) const {
    const core::CellIndex at = CellOf(x, y);
    const double r = voxels_.resolution_m();
    const int z = static_cast<int>(std::floor((cell.height_m + lift_m_) / r)) -
                  voxels_.lowest().z;
    // The ground itself; or of an obstacle, what is above the ground.
    const bool obstacle = cell.clearance_m < truth_.options().clearance_m;
    const int top = obstacle
                        ? z + static_cast<int>(truth_.options().clearance_m / r)
                        : z + 1;
    for (int i = obstacle ? z + 2 : z - 1; i <= top; ++i) {
      if (voxels_.At({at.x, at.y, i}) == octree::Voxel::kOccupied) return true;
    }
    return false;
  }

  // Whether space right below a height has been seen to be free.
  bool IsOpen(int x, int y, double height_m) const {
    const core::CellIndex at = CellOf(x, y);
    const int z = static_cast<int>(std::floor((height_m + lift_m_) /
                                              voxels_.resolution_m())) -
                  voxels_.lowest().z;
    return voxels_.At({at.x, at.y, z - 1}) == octree::Voxel::kFree &&
           voxels_.At({at.x, at.y, z}) == octree::Voxel::kFree;
  }

  // How far one falls beside a cell that is the edge of a drop, where a free
  // cell of ours leads up to it; 0 if no edge.
  double OpenDrop(const worlds::GroundCellIndex& index) const {
    const worlds::GroundCell& cell = truth_.at(index);
    double drop_m = 0;
    for (const traversability::GridStep& step : traversability::kNeighbors) {
      const int x = index.x + step.x;
      const int y = index.y + step.y;
      const Near near = TruthNear(x, y, cell.height_m);
      if (near.state == worlds::GroundState::kUnknown &&
          !IsOpen(x, y, cell.height_m)) {
        continue;  // inside of a wall
      }
      const double lower_m = near.state == worlds::GroundState::kUnknown
                                 ? 1.0
                                 : cell.height_m - near.height_m;
      if (lower_m <
          0.035 + (cell.kind == worlds::SurfaceKind::kRamp ? 0.02 : 0)) {
        continue;
      }
      // What lies beyond is marked at this height: the edge is there.
      if (AnswerAt(x, y, cell.height_m).at_height) continue;
      drop_m = std::max(drop_m, lower_m);
    }
    return drop_m;
  }

  bool IsEdge(const worlds::GroundCell& cell) const {
    return cell.state == worlds::GroundState::kOccupied &&
           (cell.kind == worlds::SurfaceKind::kFloor ||
            cell.kind == worlds::SurfaceKind::kRamp) &&
           cell.slope_rad <= truth_.options().max_slope_rad &&
           cell.clearance_m >= truth_.options().clearance_m;
  }

  Verdict Danger(const worlds::GroundCellIndex& index, const Answer& answer) {
    const worlds::GroundCell& cell = truth_.at(index);
    if (!answer.free || cell.state != worlds::GroundState::kOccupied) {
      return Verdict::kRight;
    }
    if (cell.kind == worlds::SurfaceKind::kStair && cell.clearance_m > 0) {
      ++score_.free_stairs;
      return Verdict::kDanger;
    }
    if (!IsEdge(cell)) return Verdict::kRight;
    const double drop_m = OpenDrop(index);
    if (drop_m == 0) return Verdict::kRight;
    if (drop_m < 2 * voxels_.resolution_m() + 0.01) {
      ++score_.free_low_edges;
      return Verdict::kRight;
    }
    ++score_.free_edges;
    return Verdict::kDanger;
  }

  bool IsBoundary(const worlds::GroundCellIndex& index) const {
    const worlds::GroundCell& cell = truth_.at(index);
    const double off_m =
        std::abs(cell.clearance_m - truth_.options().clearance_m);
    if (off_m < voxels_.resolution_m() * 1.01) return true;
    for (const traversability::GridStep& step : traversability::kNeighbors) {
      const Near near =
          TruthNear(index.x + step.x, index.y + step.y, cell.height_m);
      if (near.state != cell.state) return true;
    }
    return false;
  }

  void Measure(const worlds::GroundCell& cell, const Answer& answer) {
    const traversability::TraversableLevel& level = map_.levels[answer.level];
    const auto error = static_cast<float>(
        std::abs(level.slope_rad[answer.cell] - cell.slope_rad) * kDegPerRad);
    score_.slope_errors_deg.push_back(error);
    if (cell.kind == worlds::SurfaceKind::kRamp) {
      score_.ramp_slope_errors_deg.push_back(error);
    }
    if (cell.clearance_m < 4 && std::isfinite(level.clearance_m[answer.cell])) {
      score_.clearance_errors_m.push_back(
          std::abs(level.clearance_m[answer.cell] - cell.clearance_m));
    }
  }

  Verdict Judge(const worlds::GroundCellIndex& index) {
    const worlds::GroundCell& cell = truth_.at(index);
    if (cell.state == worlds::GroundState::kUnknown ||
        !IsObserved(index.x, index.y, cell)) {
      return Verdict::kNotCounted;
    }
    const Answer answer = AnswerAt(index.x, index.y, cell.height_m);
    ++score_.cells;
    if (Danger(index, answer) == Verdict::kDanger) {
      ++score_.wrong;
      return Verdict::kDanger;
    }
    const bool is_free = cell.state == worlds::GroundState::kFree;
    if (is_free && answer.free) Measure(cell, answer);
    // A low place under what a level shows instead cannot be driven into.
    const bool right =
        is_free ? answer.free
                : (answer.occupied || answer.elsewhere) && !answer.free;
    if (right || (IsBoundary(index) && (answer.free || answer.occupied))) {
      return Verdict::kRight;
    }
    ++score_.wrong;
    if (!is_free) {
      if (answer.free) ++score_.free_but_occupied;
    } else if (answer.occupied) {
      ++score_.occupied_but_free;
    } else {
      ++score_.unknown_but_free;
    }
    return Verdict::kWrong;
  }

  const worlds::GroundTruth& truth_;
  const octree::VoxelMap& voxels_;
  const traversability::TraversableMap& map_;
  double lift_m_;
  std::vector<Range> ranges_;
  WorldScore score_;
};

}  // namespace

octree::VoxelMap VoxelizeWorld(const worlds::World& world, double resolution_m,
                               double lift_m) {
  octree::VoxelMap voxels = EmptyMapOf(world, resolution_m);
  for (const worlds::Surface& surface : world.surfaces) {
    AddSurface(surface, lift_m, voxels);
  }
  if (world.tour.empty()) return voxels;
  const worlds::Float3 start = world.tour.front();
  std::vector<octree::VoxelIndex> front = {
      voxels.IndexOf({start.x, start.y, start.z + 0.5})};
  while (!front.empty()) {
    const octree::VoxelIndex v = front.back();
    front.pop_back();
    if (!voxels.Contains(v) || voxels.At(v) != octree::Voxel::kUnknown)
      continue;
    voxels.Set(v, octree::Voxel::kFree);
    for (const int step : {-1, 1}) {
      front.push_back({v.x + step, v.y, v.z});
      front.push_back({v.x, v.y + step, v.z});
      front.push_back({v.x, v.y, v.z + step});
    }
  }
  return voxels;
}

absl::StatusOr<octree::VoxelMap> ScanWorld(const worlds::World& world,
                                           const ScanOptions& options) {
  if (world.tour.empty()) return absl::InvalidArgumentError("no tour");
  TL_ASSIGN_OR_RETURN(const renderer::RayCaster caster,
                      renderer::RayCaster::Create(world));
  const octree::VoxelMap box = EmptyMapOf(world, options.resolution_m);
  Fusion fusion(box);
  base::Random random(options.seed, 0);
  for (size_t i = 0; i < world.tour.size(); ++i) {
    const worlds::Float3 from = world.tour[i];
    const worlds::Float3 to = world.tour[(i + 1) % world.tour.size()];
    const float length_m = Norm(to - from);
    const int steps =
        std::max(1, static_cast<int>(std::lround(length_m / options.step_m)));
    const double ahead_rad = std::atan2(to.y - from.y, to.x - from.x);
    for (int k = 0; k < steps; ++k) {
      const worlds::Float3 at = worlds::Mix(
          from, to, static_cast<float>(k) / static_cast<float>(steps));
      for (int d = 0; d < options.directions; ++d) {
        AddPicture(world, caster, options, {at.x, at.y, at.z},
                   ahead_rad + d * 2 * std::numbers::pi / options.directions,
                   random, fusion);
      }
    }
  }
  return fusion.Map();
}

WorldScore ScoreWorld(const worlds::GroundTruth& truth,
                      const octree::VoxelMap& voxels,
                      const traversability::TraversableMap& map,
                      double lift_m) {
  return Scorer(truth, voxels, map, lift_m).Score();
}

double Quantile(std::vector<float> values, double share) {
  if (values.empty()) return 0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(
                           share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace treeline
