#include "simulation/worlds/ground_truth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "common/base/check_range.h"
#include "common/base/status_macros.h"
#include "simulation/worlds/ground_columns.h"

namespace treeline::worlds {
namespace {

constexpr double kMaxCells = 8e6;
constexpr float kMaxClearance_m = 100;
constexpr float kSameGround_m = 0.1f;
// Heights nearer than this are the same ground, of two surfaces that meet.
constexpr float kOneGround_m = 0.01f;
// An obstacle's own ground may be this far from the ground beside it.
constexpr float kBesideGround_m = 0.3f;
constexpr int kNoLevel = -1;
// The radius of the largest robot, in cells.
constexpr double kMaxFootprint = 1000;

struct Offset {
  int x = 0;
  int y = 0;
};
constexpr std::array<Offset, 8> kAround = {
    {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};
constexpr size_t kBeside = 4;  // the first ones of kAround

// Ground at one place.
struct Node {
  size_t cell = 0;
  GroundCell ground;
  bool is_buried = false;  // below other ground
  bool is_reached = false;
  int level = kNoLevel;
};

// How levels are found: nodes of ground, and which are next to which.
class GroundFinder {
 public:
  GroundFinder(const World& world, const GroundTruthOptions& options, int width,
               int height)
      : world_(world),
        options_(options),
        width_(width),
        height_(height),
        columns_(world, width, height, options.resolution_m) {}

  std::vector<GroundLevel> Find() {
    FindNodes();
    MarkBuried();
    MarkEdges();
    Reach();
    LabelLevels();
    std::vector<GroundLevel> levels(static_cast<size_t>(level_count_));
    for (int level = 0; level < level_count_; ++level) {
      levels[static_cast<size_t>(level)] = MakeLevel(level);
    }
    return levels;
  }

 private:
  float StepLimit(double cells) const {
    return static_cast<float>(options_.max_step_m +
                              std::tan(options_.max_slope_rad) * cells *
                                  options_.resolution_m);
  }

  std::span<Node> NodesAt(size_t cell) {
    return std::span(nodes_).subspan(first_[cell],
                                     first_[cell + 1] - first_[cell]);
  }

  // Calls visit(cell) for each neighbour within the grid.
  template <typename Visit>
  void ForNeighbours(size_t cell, size_t count, Visit visit) const {
    const int x = static_cast<int>(cell % static_cast<size_t>(width_));
    const int y = static_cast<int>(cell / static_cast<size_t>(width_));
    for (size_t i = 0; i < count; ++i) {
      const int nx = x + kAround[i].x;
      const int ny = y + kAround[i].y;
      if (nx < 0 || ny < 0 || nx >= width_ || ny >= height_) continue;
      visit(static_cast<size_t>(ny) * static_cast<size_t>(width_) +
            static_cast<size_t>(nx));
    }
  }

  void FindNodes() {
    const size_t cells =
        static_cast<size_t>(width_) * static_cast<size_t>(height_);
    const float side = static_cast<float>(options_.resolution_m);
    first_.assign(cells + 1, 0);
    for (size_t cell = 0; cell < cells; ++cell) {
      first_[cell] = nodes_.size();
      const float x =
          (static_cast<float>(cell % static_cast<size_t>(width_)) + 0.5f) *
          side;
      const float y =
          (static_cast<float>(cell / static_cast<size_t>(width_)) + 0.5f) *
          side;
      for (const ColumnSpan& span : columns_.At(cell)) {
        AddNode(cell, span.surface, x, y);
      }
      std::sort(nodes_.begin() + static_cast<std::ptrdiff_t>(first_[cell]),
                nodes_.end(), [](const Node& a, const Node& b) {
                  return a.ground.height_m < b.ground.height_m;
                });
    }
    first_[cells] = nodes_.size();
  }

  void AddNode(size_t cell, uint32_t index, float x, float y) {
    const Surface& surface = world_.surfaces[index];
    if (surface.kind != SurfaceKind::kFloor &&
        surface.kind != SurfaceKind::kRamp &&
        surface.kind != SurfaceKind::kStair) {
      return;
    }
    float height_m = 0;
    const Float3 normal = surface.Normal();
    if (normal.z < 0.1f || !HeightOnSurface(surface, x, y, height_m)) return;
    Node node;
    node.cell = cell;
    node.ground.height_m = height_m;
    node.ground.kind = surface.kind;
    node.ground.slope_rad = std::acos(std::min(1.0f, normal.z));
    node.ground.clearance_m = ClearanceAbove(cell, height_m, index);
    const bool is_free =
        surface.kind != SurfaceKind::kStair &&
        node.ground.slope_rad <= static_cast<float>(options_.max_slope_rad) &&
        node.ground.clearance_m >= static_cast<float>(options_.clearance_m);
    node.ground.state = is_free ? GroundState::kFree : GroundState::kOccupied;
    for (size_t i = first_[cell]; i < nodes_.size(); ++i) {
      const GroundCell& other = nodes_[i].ground;
      // Two sheets that meet at this place; the stricter one counts.
      if (std::abs(other.height_m - height_m) > kOneGround_m) continue;
      if (node.ground.state == GroundState::kOccupied) nodes_[i] = node;
      return;
    }
    nodes_.push_back(node);
  }

  // From the ground to the first thing above that is too high to drive over.
  float ClearanceAbove(size_t cell, float height_m, uint32_t own) const {
    const float step = height_m + static_cast<float>(options_.max_step_m);
    float clearance_m = kMaxClearance_m;
    for (const ColumnSpan& span : columns_.At(cell)) {
      if (span.surface == own || span.high_m <= step) continue;
      clearance_m = std::min(clearance_m,
                             span.low_m <= step ? 0.0f : span.low_m - height_m);
    }
    return clearance_m;
  }

  bool IsBlocked(size_t cell, float height_m) const {
    const float low = height_m + static_cast<float>(options_.max_step_m);
    const float high = height_m + static_cast<float>(options_.clearance_m);
    const auto spans = columns_.At(cell);
    return std::any_of(spans.begin(), spans.end(), [&](const ColumnSpan& s) {
      return s.high_m > low && s.low_m < high;
    });
  }

  // Ground below other ground: a floor that goes on below a ramp's foot.
  void MarkBuried() {
    for (size_t i = 0; i + 1 < nodes_.size(); ++i) {
      GroundCell& ground = nodes_[i].ground;
      if (nodes_[i + 1].cell == nodes_[i].cell &&
          nodes_[i + 1].ground.height_m - ground.height_m <
              static_cast<float>(options_.clearance_m)) {
        ground.state = GroundState::kOccupied;
        nodes_[i].is_buried = true;
      }
    }
  }

  // Ground that ends without a wall is an edge to fall from.
  void MarkEdges() {
    std::vector<size_t> edges;
    const float limit = StepLimit(std::sqrt(2.0));
    for (size_t i = 0; i < nodes_.size(); ++i) {
      const Node& node = nodes_[i];
      if (node.ground.state != GroundState::kFree) continue;
      bool is_edge = false;
      ForNeighbours(node.cell, kAround.size(), [&](size_t cell) {
        const auto others = NodesAt(cell);
        const bool goes_on =
            std::any_of(others.begin(), others.end(), [&](const Node& other) {
              return std::abs(other.ground.height_m - node.ground.height_m) <=
                     limit;
            });
        is_edge |= !goes_on && !IsBlocked(cell, node.ground.height_m);
      });
      if (is_edge) edges.push_back(i);
    }
    for (const size_t i : edges) {
      nodes_[i].ground.state = GroundState::kOccupied;
    }
  }

  // Calls visit(index) for each free node beside this one.
  template <typename Visit>
  void ForFreeBeside(size_t index, Visit visit) {
    const Node node = nodes_[index];
    const float limit = StepLimit(1);
    ForNeighbours(node.cell, kBeside, [&](size_t cell) {
      for (size_t i = first_[cell]; i < first_[cell + 1]; ++i) {
        const GroundCell& other = nodes_[i].ground;
        if (other.state == GroundState::kFree &&
            std::abs(other.height_m - node.ground.height_m) <= limit) {
          visit(i);
        }
      }
    });
  }

  size_t Flood(size_t start) {
    if (nodes_[start].is_reached) return 0;
    std::vector<size_t> queue = {start};
    nodes_[start].is_reached = true;
    for (size_t next = 0; next < queue.size(); ++next) {
      ForFreeBeside(queue[next], [&](size_t i) {
        if (nodes_[i].is_reached) return;
        nodes_[i].is_reached = true;
        queue.push_back(i);
      });
    }
    return queue.size();
  }

  void FloodFrom(Float3 point) {
    const int x = static_cast<int>(point.x / options_.resolution_m);
    const int y = static_cast<int>(point.y / options_.resolution_m);
    if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
    const size_t cell = static_cast<size_t>(y) * static_cast<size_t>(width_) +
                        static_cast<size_t>(x);
    for (size_t i = first_[cell]; i < first_[cell + 1]; ++i) {
      if (nodes_[i].ground.state == GroundState::kFree &&
          std::abs(nodes_[i].ground.height_m - point.z) < kSameGround_m) {
        Flood(i);
      }
    }
  }

  void Reach() {
    for (const NamedPlace& place : world_.places) {
      FloodFrom(place.placement.origin);
    }
    for (const Float3& corner : world_.tour) FloodFrom(corner);
    if (!world_.places.empty() || !world_.tour.empty()) return;
    size_t largest = 0;
    size_t most = 0;
    for (size_t i = 0; i < nodes_.size(); ++i) {
      if (nodes_[i].ground.state != GroundState::kFree) continue;
      const size_t count = Flood(i);
      if (count > most) {
        most = count;
        largest = i;
      }
    }
    for (Node& node : nodes_) node.is_reached = false;
    if (most > 0) Flood(largest);
  }

  // Where ground lies over ground, the lowest is level 0, the next 1 and so
  // on; everything else belongs to the level that is nearest on the ground.
  void LabelLevels() {
    std::vector<size_t> queue;
    level_count_ = 1;
    for (size_t cell = 0; cell + 1 < first_.size(); ++cell) {
      std::vector<size_t> reached;
      for (size_t i = first_[cell]; i < first_[cell + 1]; ++i) {
        if (nodes_[i].is_reached) reached.push_back(i);
      }
      if (reached.size() < 2) continue;
      level_count_ = std::max(level_count_, static_cast<int>(reached.size()));
      for (size_t rank = 0; rank < reached.size(); ++rank) {
        nodes_[reached[rank]].level = static_cast<int>(rank);
        queue.push_back(reached[rank]);
      }
    }
    for (size_t next = 0; next < queue.size(); ++next) {
      const int level = nodes_[queue[next]].level;
      ForFreeBeside(queue[next], [&](size_t i) {
        if (nodes_[i].level != kNoLevel) return;
        nodes_[i].level = level;
        queue.push_back(i);
      });
    }
    for (Node& node : nodes_) {
      if (node.is_reached && node.level == kNoLevel) node.level = 0;
    }
  }

  GroundLevel MakeLevel(int level) {
    GroundLevel made;
    made.cells.resize(first_.size() - 1);
    std::vector<size_t> queue;
    for (const Node& node : nodes_) {
      if (!node.is_reached || node.level != level) continue;
      made.cells[node.cell] = node.ground;
      queue.push_back(node.cell);
    }
    // What is beside free ground, and beside that, as far as there is any.
    for (size_t next = 0; next < queue.size(); ++next) {
      const float height_m = made.cells[queue[next]].height_m;
      ForNeighbours(queue[next], kBeside, [&](size_t cell) {
        if (made.cells[cell].state != GroundState::kUnknown) return;
        if (const auto occupied = OccupiedAt(cell, height_m)) {
          made.cells[cell] = *occupied;
          queue.push_back(cell);
        }
      });
    }
    return made;
  }

  std::optional<GroundCell> OccupiedAt(size_t cell, float height_m) {
    const Node* nearest = nullptr;
    for (const Node& node : NodesAt(cell)) {
      const float off = std::abs(node.ground.height_m - height_m);
      if (off > kBesideGround_m) continue;
      if (node.is_reached) return std::nullopt;  // of another level
      if (nearest == nullptr || (nearest->is_buried && !node.is_buried) ||
          (nearest->is_buried == node.is_buried &&
           off < std::abs(nearest->ground.height_m - height_m))) {
        nearest = &node;
      }
    }
    if (nearest != nullptr && nearest->ground.state == GroundState::kOccupied) {
      return nearest->ground;
    }
    if (!IsBlocked(cell, height_m)) return std::nullopt;
    GroundCell obstacle;
    obstacle.state = GroundState::kOccupied;
    obstacle.height_m = height_m;
    return obstacle;
  }

  const World& world_;
  const GroundTruthOptions& options_;
  int width_;
  int height_;
  GroundColumns columns_;
  std::vector<Node> nodes_;
  std::vector<size_t> first_;  // nodes by cell
  int level_count_ = 1;
};

}  // namespace

absl::Status GroundTruthOptions::Validate() const {
  TL_RETURN_IF_ERROR(base::CheckRange("resolution_m", resolution_m, 0.01, 0.5));
  TL_RETURN_IF_ERROR(base::CheckRange("max_slope_rad", max_slope_rad, 1e-3, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("max_step_m", max_step_m, 0, 0.5));
  return base::CheckRange("clearance_m", clearance_m, 1e-3, 10);
}

absl::StatusOr<GroundTruth> GroundTruth::Compute(
    const World& world, const GroundTruthOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  const double width = std::ceil(world.size_m.x / options.resolution_m - 1e-4);
  const double height = std::ceil(world.size_m.y / options.resolution_m - 1e-4);
  if (!(width >= 1) || !(height >= 1) || width * height > kMaxCells) {
    return absl::InvalidArgumentError(absl::StrCat(
        width, " x ", height, " cells; there may be at most ", kMaxCells));
  }
  GroundTruth truth;
  truth.options_ = options;
  truth.width_ = static_cast<int>(width);
  truth.height_ = static_cast<int>(height);
  truth.levels_ =
      GroundFinder(world, options, truth.width_, truth.height_).Find();
  return truth;
}

float GroundTruth::StepLimit(double distance_m) const {
  return static_cast<float>(options_.max_step_m +
                            std::tan(options_.max_slope_rad) * distance_m);
}

std::optional<GroundCellIndex> GroundTruth::Find(Float3 point) const {
  const int x = static_cast<int>(std::floor(point.x / options_.resolution_m));
  const int y = static_cast<int>(std::floor(point.y / options_.resolution_m));
  if (x < 0 || y < 0 || x >= width_ || y >= height_) return std::nullopt;
  for (size_t level = 0; level < levels_.size(); ++level) {
    const GroundCell& cell = levels_[level].cells[Cell(x, y)];
    if (cell.state != GroundState::kUnknown &&
        std::abs(cell.height_m - point.z) <= kSameGround_m) {
      return GroundCellIndex{static_cast<int>(level), x, y};
    }
  }
  return std::nullopt;
}

std::optional<GroundCellIndex> GroundTruth::FreeAt(int x, int y, float height_m,
                                                   float tolerance_m) const {
  if (x < 0 || y < 0 || x >= width_ || y >= height_) return std::nullopt;
  std::optional<GroundCellIndex> found;
  float best_m = tolerance_m;
  for (size_t level = 0; level < levels_.size(); ++level) {
    const GroundCell& cell = levels_[level].cells[Cell(x, y)];
    const float off_m = std::abs(cell.height_m - height_m);
    if (cell.state != GroundState::kFree || off_m > best_m) continue;
    best_m = off_m;
    found = GroundCellIndex{static_cast<int>(level), x, y};
  }
  return found;
}

std::vector<GroundTruth::FootprintCell> GroundTruth::Footprint(
    double radius_m) const {
  std::vector<FootprintCell> cells;
  const double radius =
      std::clamp(radius_m / options_.resolution_m, 0.0, kMaxFootprint);
  const int reach = static_cast<int>(std::ceil(radius));
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const double distance = std::hypot(dx, dy);
      if (distance > radius) continue;
      cells.push_back({dx, dy, StepLimit(distance * options_.resolution_m)});
    }
  }
  return cells;
}

bool GroundTruth::HasRoom(const GroundCellIndex& index,
                          const std::vector<FootprintCell>& footprint) const {
  const float height_m = at(index).height_m;
  return std::all_of(footprint.begin(), footprint.end(),
                     [&](const FootprintCell& cell) {
                       return FreeAt(index.x + cell.x, index.y + cell.y,
                                     height_m, cell.tolerance_m)
                           .has_value();
                     });
}

bool GroundTruth::Reach::Contains(const GroundCellIndex& index) const {
  return levels_[static_cast<size_t>(index.level)]
                [static_cast<size_t>(index.y) * static_cast<size_t>(width_) +
                 static_cast<size_t>(index.x)];
}

GroundTruth::Reach GroundTruth::ReachableFrom(Float3 from,
                                              double radius_m) const {
  Reach reach;
  reach.width_ = width_;
  reach.levels_.assign(levels_.size(),
                       std::vector<bool>(Cell(0, height_), false));
  const std::vector<FootprintCell> footprint = Footprint(radius_m);
  const auto start = Find(from);
  if (!start || at(*start).state != GroundState::kFree ||
      !HasRoom(*start, footprint)) {
    return reach;
  }
  const auto mark = [&](const GroundCellIndex& index) {
    reach.levels_[static_cast<size_t>(index.level)][Cell(index.x, index.y)] =
        true;
    ++reach.count_;
  };
  std::vector<GroundCellIndex> queue = {*start};
  mark(*start);
  for (size_t next = 0; next < queue.size(); ++next) {
    const GroundCellIndex here = queue[next];
    for (size_t i = 0; i < kBeside; ++i) {
      const auto there =
          FreeAt(here.x + kAround[i].x, here.y + kAround[i].y,
                 at(here).height_m, StepLimit(options_.resolution_m));
      if (!there || reach.Contains(*there) || !HasRoom(*there, footprint)) {
        continue;
      }
      mark(*there);
      queue.push_back(*there);
    }
  }
  return reach;
}

bool GroundTruth::IsDriveable(const std::vector<Float3>& way,
                              double radius_m) const {
  const std::vector<FootprintCell> footprint = Footprint(radius_m);
  for (size_t i = 0; i + 1 < way.size(); ++i) {
    const Float3 step = way[i + 1] - way[i];
    const int count = std::max(
        1, static_cast<int>(std::ceil(Norm(step) / options_.resolution_m)));
    for (int k = 0; k <= count; ++k) {
      const auto index =
          Find(Mix(way[i], way[i + 1],
                   static_cast<float>(k) / static_cast<float>(count)));
      if (!index || at(*index).state != GroundState::kFree ||
          !HasRoom(*index, footprint)) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace treeline::worlds
