// A world cut into square columns: what GroundTruth is made of.
#ifndef SIMULATION_WORLDS_GROUND_COLUMNS_H_
#define SIMULATION_WORLDS_GROUND_COLUMNS_H_

#include <cstdint>
#include <span>
#include <vector>

#include "simulation/worlds/world.h"

namespace treeline::worlds {

// The heights between which a surface is in a column.
struct ColumnSpan {
  float low_m = 0;
  float high_m = 0;
  uint32_t surface = 0;
};

class GroundColumns {
 public:
  GroundColumns(const World& world, int width, int height, double resolution_m);

  std::span<const ColumnSpan> At(size_t cell) const {
    return std::span(spans_).subspan(first_[cell],
                                     first_[cell + 1] - first_[cell]);
  }

 private:
  std::vector<size_t> first_;
  std::vector<ColumnSpan> spans_;
};

// The height at which an upright line through (x, y) meets a surface, if it
// does; surfaces that are upright themselves have none.
bool HeightOnSurface(const Surface& surface, float x, float y, float& height_m);

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_GROUND_COLUMNS_H_
