// Where one may drive in a synthetic world: what a robot's own maps are scored
// against. Computed from the surfaces themselves: each is cut to the square
// columns of a grid, and each column's ground is where the surfaces say.
// Bodies, which move, are no part of it.
#ifndef SIMULATION_WORLDS_GROUND_TRUTH_H_
#define SIMULATION_WORLDS_GROUND_TRUTH_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "simulation/worlds/float3.h"
#include "simulation/worlds/world.h"

namespace treeline::worlds {

struct GroundTruthOptions {
  double resolution_m = 0.05;  // in [0.01, 0.5]
  // What the robot can do. Its footprint is no part of it; see ReachableFrom.
  double max_slope_rad = 0.175;  // in (0, 1]
  double max_step_m = 0.02;      // in [0, 0.5]
  double clearance_m = 1.3;      // room above the ground; in (0, 10]

  absl::Status Validate() const;
};

enum class GroundState : uint8_t {
  // Outside, or where nobody can get to.
  kUnknown,
  kFree,
  // Obstacles; ground that is too steep, too low, or stairs; and the cells
  // along edges that one would fall from.
  kOccupied
};

struct GroundCell {
  GroundState state = GroundState::kUnknown;
  SurfaceKind kind = SurfaceKind::kOther;  // of the ground
  float height_m = 0;
  float slope_rad = 0;
  // From the ground to what is above; 0 in an obstacle, at most 100.
  float clearance_m = 0;
};

// One storey: at most one height at each place. Storeys lie over one another;
// where a ramp joins two, each has its half of the ramp, and cells side by
// side at the join are of two levels.
struct GroundLevel {
  std::vector<GroundCell> cells;  // rows along x, from y = 0
};

struct GroundCellIndex {
  int level = 0;
  int x = 0;
  int y = 0;
};

// Immutable and thread-safe.
class GroundTruth {
 public:
  // INVALID_ARGUMENT for options out of range, or more than 8 million cells.
  // Known is what can be got to from the world's places and its tour; in a
  // world that has none, the largest free area.
  static absl::StatusOr<GroundTruth> Compute(const World& world,
                                             const GroundTruthOptions& options);

  const GroundTruthOptions& options() const { return options_; }
  // Cell (x, y) reaches from x to x + 1 and y to y + 1 times the resolution.
  int width() const { return width_; }
  int height() const { return height_; }
  const std::vector<GroundLevel>& levels() const { return levels_; }
  const GroundCell& at(const GroundCellIndex& index) const {
    return levels_[static_cast<size_t>(index.level)]
        .cells[Cell(index.x, index.y)];
  }

  // The known cell whose ground is within 10 cm of a point's height.
  std::optional<GroundCellIndex> Find(Float3 point) const;

  // Cells where the middle of a round robot can be that starts at a point:
  // free as far as its radius, and connected, over all levels.
  class Reach {
   public:
    bool Contains(const GroundCellIndex& index) const;
    size_t count() const { return count_; }

   private:
    friend class GroundTruth;
    int width_ = 0;
    size_t count_ = 0;
    std::vector<std::vector<bool>> levels_;
  };
  // Nothing if the robot cannot stand at `from`.
  Reach ReachableFrom(Float3 from, double radius_m) const;
  // Whether that robot can drive straight from one point to the next, all
  // along a way.
  bool IsDriveable(const std::vector<Float3>& way, double radius_m) const;

 private:
  size_t Cell(int x, int y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(width_) +
           static_cast<size_t>(x);
  }
  // The free cell at (x, y), on any level, nearest to a height.
  std::optional<GroundCellIndex> FreeAt(int x, int y, float height_m,
                                        float tolerance_m) const;
  // A cell below a robot, from that below its middle, and how much higher or
  // lower it may be.
  struct FootprintCell {
    int x = 0;
    int y = 0;
    float tolerance_m = 0;
  };
  std::vector<FootprintCell> Footprint(double radius_m) const;
  bool HasRoom(const GroundCellIndex& index,
               const std::vector<FootprintCell>& footprint) const;
  float StepLimit(double distance_m) const;

  GroundTruthOptions options_;
  int width_ = 0;
  int height_ = 0;
  std::vector<GroundLevel> levels_;
};

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_GROUND_TRUTH_H_
