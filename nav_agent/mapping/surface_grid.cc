#include "nav_agent/mapping/surface_grid.h"

#include <algorithm>
#include <cmath>

namespace treeline::mapping {
namespace {

constexpr double kStepsPerCell2 = 32;
// Points of one surface are drawn as one piece if it is straight: between
// points that are as near to each other as they are noisy, pieces would point
// anywhere, and hold a scan along a wall that does not.
constexpr double kMaxPiece_m = 0.4;
constexpr double kStraight_m = 0.03;

// The last point of the straight piece of surface that begins at point i.
size_t StraightUntil(const ScanOutline& scan, size_t i) {
  const geometry::Vec2 begin = scan.points_m[i];
  size_t end = i;
  while (end + 1 < scan.size() && scan.joined[end] != 0) {
    const geometry::Vec2 chord = scan.points_m[end + 1] - begin;
    const double length_m = geometry::Norm(chord);
    if (end > i && length_m > kMaxPiece_m) break;
    bool straight = true;
    for (size_t k = i + 1; k <= end && straight; ++k) {
      straight = std::abs(geometry::Cross(chord, scan.points_m[k] - begin)) <=
                 kStraight_m * length_m;
    }
    if (!straight) break;
    ++end;
  }
  return end;
}

}  // namespace

SurfaceGrid::SurfaceGrid(geometry::Vec2 center_in_target, double half_extent_m,
                         double cell_m, double sigma_m)
    : cell_m_(cell_m),
      sigma_m_(sigma_m),
      width_(2 * static_cast<int>(std::ceil(half_extent_m / cell_m)) + 2),
      origin_(center_in_target - 0.5 * width_ * cell_m * geometry::Vec2{1, 1}) {
  const size_t cells =
      static_cast<size_t>(width_) * static_cast<size_t>(width_);
  levels_.emplace_back(cells, uint8_t{0});
  nearest_.assign(cells, -1);
  const double reach_cells = kReach * sigma_m / cell_m;
  const int steps =
      static_cast<int>(reach_cells * reach_cells * kStepsPerCell2) + 1;
  table_.resize(static_cast<size_t>(steps));
  for (int i = 0; i < steps; ++i) {
    const double d2_m2 = (i + 0.5) / kStepsPerCell2 * cell_m * cell_m;
    table_[static_cast<size_t>(i)] = static_cast<uint8_t>(std::max(
        1.0, std::round(255 * std::exp(-d2_m2 / (2 * sigma_m * sigma_m)))));
  }
}

void SurfaceGrid::Draw(const PlacedScan& placed) {
  const ScanOutline& scan = *placed.scan;
  bool ends_surface = false;  // point i is drawn already
  for (size_t i = 0; i < scan.size();) {
    const size_t end = StraightUntil(scan, i);
    if (end > i || !ends_surface) {
      DrawPiece({placed.target_from_scan * scan.points_m[i],
                 placed.target_from_scan * scan.points_m[end]});
    }
    ends_surface = end > i;
    i = std::max(end, i + 1);
    if (end == i && scan.joined[end] == 0) {
      ends_surface = false;
      ++i;
    }
  }
}

void SurfaceGrid::DrawPiece(const Piece& piece) {
  // In cells, with the centre of cell (0, 0) at the origin.
  const double scale = 1 / cell_m_;
  const geometry::Vec2 a =
      scale * (piece.begin - origin_) - geometry::Vec2{0.5, 0.5};
  const geometry::Vec2 b =
      scale * (piece.end - origin_) - geometry::Vec2{0.5, 0.5};
  const double reach = kReach * sigma_m_ * scale;
  const double last = width_ - 1;
  if (!(std::max(a.x, b.x) + reach >= 0) ||
      !(std::max(a.y, b.y) + reach >= 0) ||
      !(std::min(a.x, b.x) - reach <= last) ||
      !(std::min(a.y, b.y) - reach <= last)) {
    return;
  }
  const auto first_cell = [&](double low) {
    return static_cast<int>(std::max(0.0, std::ceil(low - reach)));
  };
  const auto last_cell = [&](double high) {
    return static_cast<int>(std::min(last, std::floor(high + reach)));
  };
  const auto index = static_cast<int32_t>(pieces_.size());
  pieces_.push_back(piece);
  const geometry::Vec2 along = b - a;
  const double length2 = geometry::Dot(along, along);
  const double inverse_length2 = length2 > 0 ? 1 / length2 : 0;
  const int x_begin = first_cell(std::min(a.x, b.x));
  const int x_end = last_cell(std::max(a.x, b.x));
  for (int y = first_cell(std::min(a.y, b.y));
       y <= last_cell(std::max(a.y, b.y)); ++y) {
    const size_t row = static_cast<size_t>(y) * static_cast<size_t>(width_);
    for (int x = x_begin; x <= x_end; ++x) {
      const geometry::Vec2 from_a =
          geometry::Vec2{static_cast<double>(x), static_cast<double>(y)} - a;
      const double t =
          std::clamp(geometry::Dot(from_a, along) * inverse_length2, 0.0, 1.0);
      const geometry::Vec2 off = from_a - t * along;
      const auto step =
          static_cast<size_t>(geometry::Dot(off, off) * kStepsPerCell2);
      if (step >= table_.size()) continue;
      const size_t cell = row + static_cast<size_t>(x);
      if (table_[step] > levels_[0][cell]) {
        levels_[0][cell] = table_[step];
        nearest_[cell] = index;
      }
    }
  }
}

void SurfaceGrid::BuildPyramid(int levels) {
  const auto width = static_cast<size_t>(width_);
  levels_.resize(1);
  for (int h = 1; h < levels; ++h) {
    const std::vector<uint8_t>& below = levels_.back();
    const size_t step = size_t{1} << (h - 1);
    // First the larger of two columns, then the larger of two rows. Beyond the
    // border nothing is seen.
    std::vector<uint8_t> wide = below;
    for (size_t y = 0; y < width; ++y) {
      const uint8_t* from = &below[y * width];
      uint8_t* to = &wide[y * width];
      for (size_t x = 0; x + step < width; ++x) {
        to[x] = std::max(from[x], from[x + step]);
      }
    }
    std::vector<uint8_t> level = wide;
    for (size_t y = 0; y + step < width; ++y) {
      const uint8_t* other = &wide[(y + step) * width];
      uint8_t* to = &level[y * width];
      for (size_t x = 0; x < width; ++x) to[x] = std::max(to[x], other[x]);
    }
    levels_.push_back(std::move(level));
  }
}

const SurfaceGrid::Piece* SurfaceGrid::NearestPiece(
    geometry::Vec2 point_in_target) const {
  const double x = std::floor((point_in_target.x - origin_.x) / cell_m_);
  const double y = std::floor((point_in_target.y - origin_.y) / cell_m_);
  if (!(x >= 0) || !(y >= 0) || !(x < width_) || !(y < width_)) return nullptr;
  const int32_t index =
      nearest_[static_cast<size_t>(y) * static_cast<size_t>(width_) +
               static_cast<size_t>(x)];
  return index < 0 ? nullptr : &pieces_[static_cast<size_t>(index)];
}

}  // namespace treeline::mapping
