#include "nav_agent/mapless/evidence_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace treeline::mapless {
namespace {

// It grows by so much more than is needed (m).
constexpr double kGrowth_m = 4;

}  // namespace

EvidenceGrid::EvidenceGrid(double cell_m, double max_size_m)
    : cell_m_(cell_m), max_cells_(static_cast<int>(max_size_m / cell_m)) {}

core::CellIndex EvidenceGrid::CellOf(geometry::Vec2 point) const {
  return {static_cast<int>(std::floor((point.x - origin_.x) / cell_m_)),
          static_cast<int>(std::floor((point.y - origin_.y) / cell_m_))};
}

geometry::Vec2 EvidenceGrid::CenterOf(core::CellIndex cell) const {
  return {origin_.x + (cell.x + 0.5) * cell_m_,
          origin_.y + (cell.y + 0.5) * cell_m_};
}

core::Occupancy EvidenceGrid::At(core::CellIndex cell) const {
  if (!Contains(cell)) return core::Occupancy::kUnknown;
  const int8_t evidence = evidence_[IndexOf(cell)];
  if (evidence == kUnseen) return core::Occupancy::kUnknown;
  return evidence > 0 ? core::Occupancy::kOccupied : core::Occupancy::kFree;
}

bool EvidenceGrid::HasStood(core::CellIndex cell, uint32_t scans) const {
  if (At(cell) != core::Occupancy::kOccupied) return false;
  return scans_ - since_[IndexOf(cell)] >= scans;
}

bool EvidenceGrid::MakeRoomFor(geometry::Vec2 low, geometry::Vec2 high) {
  if (width_ == 0) {
    origin_ = {std::floor((low.x - kGrowth_m) / cell_m_) * cell_m_,
               std::floor((low.y - kGrowth_m) / cell_m_) * cell_m_};
  }
  if (width_ == 0) {
    seen_low_ = low;
    seen_high_ = high;
  }
  const core::CellIndex first = CellOf(low);
  const core::CellIndex last = CellOf(high);
  const auto note_seen = [&] {
    seen_low_ = {std::min(seen_low_.x, low.x), std::min(seen_low_.y, low.y)};
    seen_high_ = {std::max(seen_high_.x, high.x),
                  std::max(seen_high_.y, high.y)};
  };
  if (width_ > 0 && Contains(first) && Contains(last)) {
    note_seen();
    return true;
  }
  const int growth = static_cast<int>(kGrowth_m / cell_m_);
  const int left = first.x < 0 ? growth - first.x : 0;
  const int below = first.y < 0 ? growth - first.y : 0;
  const int columns = std::max(width_, last.x + 1 + growth) + left;
  const int rows = std::max(height_, last.y + 1 + growth) + below;
  if (columns > max_cells_ || rows > max_cells_) return false;
  const auto size = static_cast<size_t>(columns) * static_cast<size_t>(rows);
  std::vector<int8_t> evidence(size, kUnseen);
  std::vector<uint32_t> since(size, 0);
  for (int y = 0; y < height_; ++y) {
    const auto from = static_cast<ptrdiff_t>(IndexOf({0, y}));
    const ptrdiff_t to = static_cast<ptrdiff_t>(y + below) * columns + left;
    std::copy_n(evidence_.begin() + from, width_, evidence.begin() + to);
    std::copy_n(since_.begin() + from, width_, since.begin() + to);
  }
  evidence_ = std::move(evidence);
  since_ = std::move(since);
  touched_.assign(size, 0);
  scan_ = 0;
  origin_ = {origin_.x - left * cell_m_, origin_.y - below * cell_m_};
  width_ = columns;
  height_ = rows;
  note_seen();
  return true;
}

void EvidenceGrid::AddScan(std::span<const GridBeam> beams) {
  if (beams.empty()) return;
  geometry::Vec2 low = beams.front().from;
  geometry::Vec2 high = low;
  for (const GridBeam& beam : beams) {
    for (const geometry::Vec2 point : {beam.from, beam.to}) {
      low = {std::min(low.x, point.x), std::min(low.y, point.y)};
      high = {std::max(high.x, point.x), std::max(high.y, point.y)};
    }
  }
  MakeRoomFor(low, high);
  ++scan_;
  ++scans_;
  for (const GridBeam& beam : beams) {
    const core::CellIndex cell = CellOf(beam.to);
    if (beam.is_on_mover || !Contains(cell)) continue;
    const size_t index = IndexOf(cell);
    if (touched_[index] == scan_) continue;
    touched_[index] = scan_;
    if (evidence_[index] <= 0) since_[index] = scans_;
    const int evidence = std::max<int>(evidence_[index], -kHitEvidence + 1);
    evidence_[index] = static_cast<int8_t>(
        std::min<int>(evidence + kHitEvidence, kMaxEvidence));
  }
  for (const GridBeam& beam : beams) Pass(beam);
}

void EvidenceGrid::Pass(const GridBeam& beam) {
  core::CellIndex cell = CellOf(beam.from);
  const core::CellIndex end = CellOf(beam.to);
  const geometry::Vec2 way = beam.to - beam.from;
  // From the border of one cell to the next (Amanatides and Woo, 1987).
  const int step_x = way.x > 0 ? 1 : -1;
  const int step_y = way.y > 0 ? 1 : -1;
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const double each_x = way.x == 0 ? kNever : cell_m_ / std::abs(way.x);
  const double each_y = way.y == 0 ? kNever : cell_m_ / std::abs(way.y);
  const auto first = [this](double from, double low, double way_m, int at) {
    if (way_m == 0) return kNever;
    const double border = low + (at + (way_m > 0 ? 1 : 0)) * cell_m_;
    return (border - from) / way_m;
  };
  double next_x = first(beam.from.x, origin_.x, way.x, cell.x);
  double next_y = first(beam.from.y, origin_.y, way.y, cell.y);
  int left = std::abs(end.x - cell.x) + std::abs(end.y - cell.y);
  while (left-- > 0) {
    if (!Contains(cell)) return;
    const size_t index = IndexOf(cell);
    if (touched_[index] != scan_) {
      touched_[index] = scan_;
      const int evidence = std::min<int>(
          evidence_[index] == kUnseen ? 0 : evidence_[index], kMaxEvidence);
      evidence_[index] =
          static_cast<int8_t>(std::max(evidence - 1, -kHitEvidence + 1));
    }
    if (next_x < next_y) {
      cell.x += step_x;
      next_x += each_x;
    } else {
      cell.y += step_y;
      next_y += each_y;
    }
  }
}

void EvidenceGrid::Mark(geometry::Vec2 point) {
  if (!MakeRoomFor(point, point)) return;
  evidence_[IndexOf(CellOf(point))] = kMaxEvidence;
}

void EvidenceGrid::ForgetNew(geometry::Vec2 center, double radius_m,
                             uint32_t scans) {
  const geometry::Vec2 reach = {radius_m, radius_m};
  const core::CellIndex low = CellOf(center - reach);
  const core::CellIndex high = CellOf(center + reach);
  for (int y = low.y; y <= high.y; ++y) {
    for (int x = low.x; x <= high.x; ++x) {
      const core::CellIndex cell = {x, y};
      if (At(cell) == core::Occupancy::kOccupied && !HasStood(cell, scans) &&
          geometry::Norm(CenterOf(cell) - center) <= radius_m) {
        evidence_[IndexOf(cell)] = 0;
      }
    }
  }
}

void EvidenceGrid::Clear() {
  std::fill(evidence_.begin(), evidence_.end(), kUnseen);
}

std::vector<uint8_t> EvidenceGrid::ObstaclesIn(int x0, int y0, int columns,
                                               int rows) const {
  std::vector<uint8_t> obstacles(
      static_cast<size_t>(columns) * static_cast<size_t>(rows), 0);
  const int first_x = std::max(0, -x0);
  const int last_x = std::min(columns, width_ - x0);
  for (int y = std::max(0, -y0); y < std::min(rows, height_ - y0); ++y) {
    const size_t row = static_cast<size_t>(y) * static_cast<size_t>(columns);
    for (int x = first_x; x < last_x; ++x) {
      obstacles[row + static_cast<size_t>(x)] =
          evidence_[IndexOf({x0 + x, y0 + y})] > 0 ? 1 : 0;
    }
  }
  return obstacles;
}

core::OccupancyGrid EvidenceGrid::Grid() const {
  core::OccupancyGrid grid = core::OccupancyGrid::Filled(
      width_, height_, cell_m_, {origin_, 0}, core::Occupancy::kUnknown);
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) grid.Set({x, y}, At({x, y}));
  }
  return grid;
}

}  // namespace treeline::mapless
