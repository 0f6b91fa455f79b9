#include "simulation/building/cylinder_field.h"

#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <string>
#include <utility>

#include "common/base/random.h"
#include "simulation/building/field_hall.h"

namespace treeline::building {
namespace {

constexpr int kColumns = CylinderField::kColumns;
constexpr int kRows = CylinderField::kRows;
constexpr int kFieldRows = CylinderField::kFieldRows;
constexpr int kFirstRow = kRows - kFieldRows;
constexpr double kCell_m = CylinderField::kCell_m;
constexpr uint64_t kStream = 0xba54;
// A robot's square reaches so many cells beyond the middle one.
constexpr int kReach = 2;
// Start and goal, in the field's frame.
constexpr double kMiddle_m = kColumns * kCell_m / 2;
constexpr double kStartRow_m = kFirstRow * kCell_m - 2;
// Of the hall, around it.
constexpr double kMargin_m = 3.5;
constexpr double kHallWidth_m = 12;
constexpr double kHallDepth_m = 17.4;

using Cells = std::vector<std::vector<bool>>;  // [row][column] of the automaton

// Cells beside the sides count as filled, those before and behind as free.
int FilledAround(const Cells& cells, int x, int y) {
  int count = 0;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (dx == 0 && dy == 0) continue;
      const int nx = x + dx;
      const int ny = y + dy;
      if (nx < 0 || nx >= kColumns) {
        ++count;
      } else if (ny >= 0 && ny < kFieldRows) {
        count +=
            cells[static_cast<size_t>(ny)][static_cast<size_t>(nx)] ? 1 : 0;
      }
    }
  }
  return count;
}

Cells Automaton(double fill, int smoothings, base::Random& random) {
  Cells cells(kFieldRows, std::vector<bool>(kColumns, false));
  for (std::vector<bool>& row : cells) {
    for (size_t x = 0; x < row.size(); ++x) {
      row[x] = x == 0 || x + 1 == row.size() || random.NextUnit() < fill;
    }
  }
  for (int step = 0; step < smoothings; ++step) {
    Cells next = cells;
    for (int y = 0; y < kFieldRows; ++y) {
      for (int x = 0; x < kColumns; ++x) {
        const int around = FilledAround(cells, x, y);
        if (around > 4)
          next[static_cast<size_t>(y)][static_cast<size_t>(x)] = true;
        if (around < 2)
          next[static_cast<size_t>(y)][static_cast<size_t>(x)] = false;
      }
    }
    cells = std::move(next);
  }
  return cells;
}

bool IsOpen(const CylinderField& field, int x, int y) {
  for (int dy = -kReach; dy <= kReach; ++dy) {
    for (int dx = -kReach; dx <= kReach; ++dx) {
      if (x + dx < 0 || x + dx >= kColumns) return false;
      // Behind the field, and before the corridor's back, it is free.
      if (y + dy < 0 || y + dy >= kRows) continue;
      if (field.At(x + dx, y + dy)) return false;
    }
  }
  return true;
}

}  // namespace

double BestWay_m(const CylinderField& field) {
  // Over the field's rows; from and to there it is straight.
  const auto middle_of = [](int x) { return (x + 0.5) * kCell_m; };
  const double before_m = (kFirstRow + 0.5) * kCell_m - kStartRow_m;
  const double behind_m =
      kStartRow_m + kFieldGoalAhead_m - (kRows - 0.5) * kCell_m;
  std::vector<double> far(static_cast<size_t>(kColumns * kRows),
                          std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  for (int x = 0; x < kColumns; ++x) {
    if (!IsOpen(field, x, kFirstRow)) continue;
    const int index = kFirstRow * kColumns + x;
    far[static_cast<size_t>(index)] =
        std::hypot(before_m, middle_of(x) - kMiddle_m);
    open.emplace(far[static_cast<size_t>(index)], index);
  }
  double best = std::numeric_limits<double>::infinity();
  while (!open.empty()) {
    const auto [way, index] = open.top();
    open.pop();
    if (way > far[static_cast<size_t>(index)]) continue;
    const int x = index % kColumns;
    const int y = index / kColumns;
    if (y == kRows - 1) {
      best =
          std::min(best, way + std::hypot(behind_m, middle_of(x) - kMiddle_m));
    }
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const int nx = x + dx;
        const int ny = y + dy;
        if (nx < 0 || nx >= kColumns || ny < kFirstRow || ny >= kRows ||
            !IsOpen(field, nx, ny)) {
          continue;
        }
        const auto next = static_cast<size_t>(ny * kColumns + nx);
        const double there = way + kCell_m * std::hypot(dx, dy);
        if (there < far[next]) {
          far[next] = there;
          open.emplace(there, static_cast<int>(next));
        }
      }
    }
  }
  return best;
}

CylinderField DrawField(uint64_t seed) {
  CylinderField field;
  field.seed = seed;
  field.fill = 0.15 + 0.05 * static_cast<double>(seed % 4);
  field.smoothings = 2 + static_cast<int>(seed / 4 % 3);
  base::Random random(seed, kStream);
  do {
    const Cells cells = Automaton(field.fill, field.smoothings, random);
    field.is_filled.assign(static_cast<size_t>(kColumns * kRows), false);
    for (int y = 0; y < kRows; ++y) {
      for (int x = 0; x < kColumns; ++x) {
        const bool is_corridor = y < kFirstRow;
        const bool is_wall = x == 0 || x == kColumns - 1 || y == 0;
        field.is_filled[static_cast<size_t>(y * kColumns + x)] =
            is_corridor ? is_wall
                        : cells[static_cast<size_t>(y - kFirstRow)]
                               [static_cast<size_t>(x)];
      }
    }
  } while (std::isinf(BestWay_m(field)));
  return field;
}

BuildingPlan FieldPlan(const CylinderField& field) {
  BuildingPlan plan =
      PlanOf(FieldHall{.width_m = kHallWidth_m,
                       .depth_m = kHallDepth_m,
                       .lamps = {2, 3},
                       .start_y_m = ToMillimetres(kMargin_m + kStartRow_m),
                       .goal_ahead_m = kFieldGoalAhead_m},
             field.seed);
  const double left_m = (kHallWidth_m - kColumns * kCell_m) / 2;
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < kColumns; ++x) {
      if (!field.At(x, y)) continue;
      // Nobody sees one that stands among others on all sides.
      bool is_hidden = true;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          is_hidden = is_hidden && x + dx >= 0 && x + dx < kColumns &&
                      y + dy >= 0 && y + dy < kRows && field.At(x + dx, y + dy);
        }
      }
      if (is_hidden) continue;
      PlanPillar post;
      post.at = {ToMillimetres(left_m + (x + 0.5) * kCell_m),
                 ToMillimetres(kMargin_m + (y + 0.5) * kCell_m),
                 {}};
      post.width_m = kCell_m;
      post.is_round = true;
      post.height_m = 1;
      plan.pillars.push_back(post);
    }
  }
  return plan;
}

}  // namespace treeline::building
