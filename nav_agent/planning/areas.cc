#include "nav_agent/planning/areas.h"

namespace treeline::planning {
namespace {

constexpr int32_t kClosed = -1;
constexpr int32_t kOpen = -2;

}  // namespace

Areas::Areas(const ConfigurationSpace& space)
    : areas_(
          space.ground().cells() * static_cast<size_t>(space.ground().levels()),
          kClosed) {
  const GroundIndex& ground = space.ground();
  const auto width = static_cast<size_t>(ground.width());
  const auto cell_of = [&ground, width](size_t number) {
    const size_t cell = number % ground.cells();
    return core::CellIndex{static_cast<int>(cell % width),
                           static_cast<int>(cell / width)};
  };
  for (size_t number = 0; number < areas_.size(); ++number) {
    const int level = static_cast<int>(number / ground.cells());
    const core::CellIndex cell = cell_of(number);
    if (ground.map().IsFree(level, cell) &&
        space.MayHoldDisc({ground.CenterOf(cell), level})) {
      areas_[number] = kOpen;
    }
  }
  for (size_t first = 0; first < areas_.size(); ++first) {
    if (areas_[first] != kOpen) continue;
    const auto area = static_cast<int32_t>(cells_.size());
    std::vector<uint32_t> found = {static_cast<uint32_t>(first)};
    areas_[first] = area;
    for (size_t i = 0; i < found.size(); ++i) {
      const int level = static_cast<int>(found[i] / ground.cells());
      const core::CellIndex from = cell_of(found[i]);
      for (int k = 0; k < 9; ++k) {
        const core::CellIndex next = {from.x + k % 3 - 1, from.y + k / 3 - 1};
        const int to = ground.LevelAfter(level, from, next);
        if (to < 0) continue;
        const size_t number =
            static_cast<size_t>(to) * ground.cells() + ground.IndexOf(next);
        if (areas_[number] != kOpen) continue;
        areas_[number] = area;
        found.push_back(static_cast<uint32_t>(number));
      }
    }
    cells_.push_back(std::move(found));
  }
}

int Areas::Of(const GroundIndex& ground, const Spot& spot) const {
  const core::CellIndex cell = ground.CellOf(spot.at);
  if (!ground.Contains(cell)) return kClosed;
  return areas_[static_cast<size_t>(spot.level) * ground.cells() +
                ground.IndexOf(cell)];
}

}  // namespace treeline::planning
