#include "nav_agent/traversability/ground_links.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <utility>
#include <vector>

namespace treeline::traversability {
namespace {

constexpr size_t kEast = 0;
constexpr size_t kNorth = 2;
constexpr size_t kWest = 4;
constexpr size_t kSouth = 6;

// What lies beyond ground that does not go on.
enum class Beyond : uint8_t { kUnknown, kWall, kStepUp, kDrop };

Beyond WhatIsBeyond(const CleanColumns& columns, const VoxelLimits& limits,
                    std::span<const GroundNode> column, int x, int y, int z) {
  for (const GroundNode& node : column) {
    if (node.z > z && node.z - z <= limits.riser) return Beyond::kStepUp;
  }
  // Voxels at the ground's own height and up to the robot's.
  const int body = z + std::min(limits.robot_height, limits.riser);
  if (columns.AnyOccupied(x, y, z - limits.step, body + 1)) {
    return Beyond::kWall;
  }
  const bool lower = std::any_of(
      column.begin(), column.end(),
      [z](const GroundNode& node) { return node.z < z && node.seen; });
  if (lower || columns.AnyFree(x, y, z - 1, z + 1)) return Beyond::kDrop;
  return Beyond::kUnknown;
}

// Links `node`. A node whose links lead both up and down by more than a step
// in all lies on the face of a step that a voxel missed, or one too many, has
// broken in two: the edge of a drop as well. (Slopes that are
// not steep rise by less than a voxel from one side of it to the other.)
void LinkNode(const CleanColumns& columns, const VoxelLimits& limits,
              const GroundColumns& ground, int x, int y, GroundNode& node) {
  int lowest = node.z;
  int highest = node.z;
  for (size_t d = 0; d < kNeighbors.size(); ++d) {
    const int nx = x + kNeighbors[d].x;
    const int ny = y + kNeighbors[d].y;
    if (!ground.rect.Contains(nx, ny)) continue;
    const auto column = ground.At(ground.ColumnOf(nx, ny));
    int nearest = limits.step + 1;
    for (size_t i = 0; i < std::min<size_t>(column.size(), kNoLink); ++i) {
      const int rise = std::abs(column[i].z - node.z);
      if (rise < nearest) {
        nearest = rise;
        node.link[d] = static_cast<uint8_t>(i);
      }
    }
    if (node.link[d] != kNoLink) {
      lowest = std::min(lowest, column[node.link[d]].z);
      highest = std::max(highest, column[node.link[d]].z);
      continue;
    }
    const Beyond beyond = WhatIsBeyond(columns, limits, column, nx, ny, node.z);
    node.edge = node.edge || beyond == Beyond::kDrop;
    node.step =
        node.step || beyond == Beyond::kDrop || beyond == Beyond::kStepUp;
  }
  if (highest - lowest > limits.step) {
    node.edge = true;
    node.step = true;
  }
}

// For each node the index of the one it is linked to in direction d; -1 if
// there is none.
std::vector<int32_t> LinksOf(const GroundColumns& ground, size_t d) {
  std::vector<int32_t> links(ground.nodes.size(), -1);
  const ColumnRect& rect = ground.rect;
  for (int y = rect.begin_y; y < rect.end_y; ++y) {
    for (int x = rect.begin_x; x < rect.end_x; ++x) {
      const int nx = x + kNeighbors[d].x;
      const int ny = y + kNeighbors[d].y;
      if (!rect.Contains(nx, ny)) continue;
      const size_t column = ground.ColumnOf(x, y);
      const uint32_t beyond = ground.begin[ground.ColumnOf(nx, ny)];
      for (size_t i = ground.begin[column]; i < ground.begin[column + 1]; ++i) {
        const uint8_t slot = ground.nodes[i].link[d];
        if (slot != kNoLink) links[i] = static_cast<int32_t>(beyond + slot);
      }
    }
  }
  return links;
}

std::vector<int32_t> Doubled(const std::vector<int32_t>& links) {
  std::vector<int32_t> doubled(links.size(), -1);
  for (size_t i = 0; i < links.size(); ++i) {
    if (links[i] >= 0) doubled[i] = links[static_cast<size_t>(links[i])];
  }
  return doubled;
}

// A value at each node, and how much it counts.
struct Field {
  std::vector<float> value;
  std::vector<float> weight;
};

// How far the ground rises from each node's predecessor to its successor, a
// cell: Delta z. Where there is but one of them, from or to it.
Field RiseAlong(const GroundColumns& ground, const std::vector<int32_t>& next,
                const std::vector<int32_t>& previous) {
  Field rise{.value = std::vector<float>(next.size()),
             .weight = std::vector<float>(next.size())};
  for (size_t i = 0; i < next.size(); ++i) {
    const int z = ground.nodes[i].z;
    int cells = 0;
    int sum = 0;
    if (next[i] >= 0) {
      sum += ground.nodes[static_cast<size_t>(next[i])].z - z;
      ++cells;
    }
    if (previous[i] >= 0) {
      sum += z - ground.nodes[static_cast<size_t>(previous[i])].z;
      ++cells;
    }
    if (cells == 0) continue;
    // Sums are weighted with how many differences they are of.
    rise.value[i] = static_cast<float>(sum);
    rise.weight[i] = static_cast<float>(cells);
  }
  return rise;
}

// Weights 1/4, 1/2, 1/4; what lies beyond an end counts as what lies at it.
void SmoothOnce(const std::vector<int32_t>& next,
                const std::vector<int32_t>& previous,
                std::vector<float>& values, std::vector<float>& scratch) {
  for (size_t i = 0; i < values.size(); ++i) {
    const float a =
        next[i] < 0 ? values[i] : values[static_cast<size_t>(next[i])];
    const float b =
        previous[i] < 0 ? values[i] : values[static_cast<size_t>(previous[i])];
    scratch[i] = 0.25F * (a + b) + 0.5F * values[i];
  }
  values.swap(scratch);
}

// ---- level runs ----

// Runs are measured this far, each way, from a cell.
constexpr int kRunReach = 20;
// Runs from this long on say more of the slope than the bell does.
constexpr int kLongRun = 8;
// What is this short before a wall is its foot: skirting, or noise.
constexpr int kShortRun = 3;

// How many nodes after each are level with it, and how the run ends.
struct RunAhead {
  std::vector<int16_t> cells;
  std::vector<int8_t> end;  // a step up or down; 0: the ground ends, or farther
};

// `next` leads to higher indices if `ascending`, and to lower ones if not.
RunAhead MeasureRuns(const GroundColumns& ground,
                     const std::vector<int32_t>& next, bool ascending) {
  const size_t count = next.size();
  RunAhead run{.cells = std::vector<int16_t>(count),
               .end = std::vector<int8_t>(count)};
  for (size_t k = 0; k < count; ++k) {
    const size_t i = ascending ? count - 1 - k : k;
    if (next[i] < 0) continue;
    const auto to = static_cast<size_t>(next[i]);
    const int step = ground.nodes[to].z - ground.nodes[i].z;
    if (step != 0) {
      run.end[i] = step > 0 ? 1 : -1;
    } else if (run.cells[to] < kRunReach - 1) {
      run.cells[i] = static_cast<int16_t>(run.cells[to] + 1);
      run.end[i] = run.end[to];
    } else {
      run.cells[i] = kRunReach;
    }
  }
  return run;
}

// The level run beyond the end of one, from node i on.
struct RunBeyond {
  int cells = 0;  // 0: there is none
  int8_t end = 0;
};

RunBeyond FindRunBeyond(const std::vector<int32_t>& next, const RunAhead& run,
                        size_t i) {
  for (int cells = run.cells[i]; cells >= 0; --cells) {
    if (next[i] < 0) return {};
    i = static_cast<size_t>(next[i]);
  }
  return {.cells = run.cells[i] + 1, .end = run.end[i]};
}

// Whether a slope begins right ahead: its first layer is as far away at most as
// it is long, and it goes on the same way.
bool SlopeBegins(const std::vector<int32_t>& next, const RunAhead& ahead,
                 size_t i) {
  if (ahead.end[i] == 0 || ahead.cells[i] >= kLongRun) return false;
  const RunBeyond beyond = FindRunBeyond(next, ahead, i);
  return beyond.end == ahead.end[i] && beyond.cells < kLongRun &&
         ahead.cells[i] <= beyond.cells;
}

// Of a slope whose layers' edges are v cells apart every level run is between
// v - 1 and v + 1 cells long (Eq. 6.2). The bell is short for gentle slopes:
// it sees a step or sees none. So what it says is kept between 1 / (run + 1)
// and 1 / (run - 1); the former if the ground goes on the same way at both
// ends.
void BoundByRuns(const GroundColumns& ground, const std::vector<int32_t>& next,
                 const std::vector<int32_t>& previous,
                 std::vector<float>& gradients) {
  const RunAhead ahead = MeasureRuns(ground, next, /*ascending=*/true);
  const RunAhead behind = MeasureRuns(ground, previous, /*ascending=*/false);
  for (size_t i = 0; i < gradients.size(); ++i) {
    int run = ahead.cells[i] + behind.cells[i] + 1;
    if (run <= kShortRun && ahead.end[i] == 0) {
      run += FindRunBeyond(previous, behind, i).cells;
    } else if (run <= kShortRun && behind.end[i] == 0) {
      run += FindRunBeyond(next, ahead, i).cells;
    }
    if (run < kLongRun || SlopeBegins(next, ahead, i) ||
        SlopeBegins(previous, behind, i)) {
      continue;
    }
    float& gradient = gradients[i];
    const float most = 1 / static_cast<float>(run - 1);
    gradient = std::clamp(gradient, -most, most);
    if (ahead.end[i] == 0 || ahead.end[i] != -behind.end[i]) continue;
    const auto sign = static_cast<float>(ahead.end[i]);
    const float least = 1 / static_cast<float>(run + 1);
    gradient = sign * std::max(sign * gradient, least);
  }
}

// One erosion, or dilation, of `set` through links: to all neighbours or only
// to those that share a side.
void Spread(const std::array<std::vector<int32_t>, 8>& links, bool all,
            std::vector<uint8_t>& set) {
  std::vector<uint8_t> spread = set;
  for (size_t d = 0; d < links.size(); d += all ? 1 : 2) {
    for (size_t i = 0; i < set.size(); ++i) {
      if (links[d][i] >= 0) {
        spread[i] |= set[static_cast<size_t>(links[d][i])];
      }
    }
  }
  set.swap(spread);
}

}  // namespace

void LinkGround(const CleanColumns& columns, const VoxelLimits& limits,
                GroundColumns& ground) {
  const ColumnRect& rect = ground.rect;
  for (int y = rect.begin_y; y < rect.end_y; ++y) {
    for (int x = rect.begin_x; x < rect.end_x; ++x) {
      const size_t column = ground.ColumnOf(x, y);
      for (size_t i = ground.begin[column]; i < ground.begin[column + 1]; ++i) {
        LinkNode(columns, limits, ground, x, y, ground.nodes[i]);
      }
    }
  }
}

// The mean of the differences between neighbours, weighted with a bell of
// about four cells (steps of 1, 2, 4 and 4 cells: variance 1/2 + 2 + 8 + 8
// each way). Differences, not heights, are averaged, and only along continuous
// ground, so the ends of a ramp do not flatten it; a bell and not a window,
// since the rounding of heights is periodic along a ramp and a bell lets none
// of its period pass that is shorter than itself.
void MeasureGradients(GroundColumns& ground) {
  std::array<std::vector<int32_t>, 4> links;
  for (size_t side = 0; side < links.size(); ++side) {
    links[side] = LinksOf(ground, 2 * side);
  }
  static_assert(kEast == 0 && kNorth == 2 && kWest == 4 && kSouth == 6);
  const std::array<std::vector<int32_t>, 4> neighbors = links;
  Field along_x = RiseAlong(ground, links[0], links[2]);
  Field along_y = RiseAlong(ground, links[1], links[3]);
  std::vector<float> scratch(ground.nodes.size());
  for (int pass = 0; pass < 4; ++pass) {
    for (std::vector<float>* values :
         {&along_x.value, &along_x.weight, &along_y.value, &along_y.weight}) {
      SmoothOnce(links[0], links[2], *values, scratch);
      SmoothOnce(links[1], links[3], *values, scratch);
    }
    if (pass >= 2) continue;
    for (std::vector<int32_t>& link : links) link = Doubled(link);
  }
  for (Field* field : {&along_x, &along_y}) {
    for (size_t i = 0; i < field->value.size(); ++i) {
      if (field->weight[i] > 0) field->value[i] /= field->weight[i];
    }
  }
  BoundByRuns(ground, neighbors[0], neighbors[2], along_x.value);
  BoundByRuns(ground, neighbors[1], neighbors[3], along_y.value);
  for (size_t i = 0; i < ground.nodes.size(); ++i) {
    ground.nodes[i].gradient_x = along_x.value[i];
    ground.nodes[i].gradient_y = along_y.value[i];
  }
}

// An opening with an octagon: what no disc fits into that is free of steps.
void FindNarrowGround(const VoxelLimits& limits, GroundColumns& ground) {
  if (limits.erosion == 0) return;
  std::array<std::vector<int32_t>, 8> links;
  for (size_t d = 0; d < links.size(); ++d) links[d] = LinksOf(ground, d);
  std::vector<uint8_t> set(ground.nodes.size());
  for (size_t i = 0; i < set.size(); ++i) {
    set[i] = ground.nodes[i].step ? 1 : 0;
  }
  for (int i = 0; i < limits.erosion; ++i) Spread(links, i % 2 == 1, set);
  for (uint8_t& value : set) value ^= 1;
  for (int i = 0; i < limits.erosion; ++i) Spread(links, i % 2 == 1, set);
  // Cells beside a step are ground as well.
  Spread(links, /*all=*/true, set);
  for (size_t i = 0; i < set.size(); ++i) ground.nodes[i].narrow = set[i] == 0;
}

}  // namespace treeline::traversability
