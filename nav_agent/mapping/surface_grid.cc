#include "nav_agent/mapping/surface_grid.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "nav_agent/mapping/grid_kernels.h"

namespace treeline::mapping {
namespace {

constexpr double kMaxStepsPerCell2 = 32;
// More are left out: no building has as many.
constexpr size_t kMaxPieces = size_t{1} << kPieceBits;
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
    const double length_m = std::sqrt(geometry::Dot(chord, chord));
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
                         geometry::Vec2 low_in_target,
                         geometry::Vec2 high_in_target, double cell_m,
                         double sigma_m)
    : cell_m_(cell_m), sigma_m_(sigma_m) {
  const int whole = 2 * static_cast<int>(std::ceil(half_extent_m / cell_m)) + 2;
  const geometry::Vec2 corner =
      center_in_target - 0.5 * whole * cell_m * geometry::Vec2{1, 1};
  const auto cell_of = [&](double from_corner_m) {
    const double cells = std::floor(from_corner_m / cell_m);
    return static_cast<int>(std::clamp(cells, 0.0, whole - 1.0));
  };
  const int left = cell_of(low_in_target.x - corner.x);
  const int bottom = cell_of(low_in_target.y - corner.y);
  width_ = cell_of(high_in_target.x - corner.x) - left + 1;
  height_ = cell_of(high_in_target.y - corner.y) - bottom + 1;
  origin_ = corner + cell_m * geometry::Vec2{static_cast<double>(left),
                                             static_cast<double>(bottom)};
  drawn_left_ = width_;
  drawn_bottom_ = height_;
  const size_t cells =
      static_cast<size_t>(width_) * static_cast<size_t>(height_);
  levels_.emplace_back();
  nearest_.assign(cells + kGridSlack, kNoPiece);
  const double reach_cells = kReach * sigma_m / cell_m;
  steps_per_cell2_ = std::min(kMaxStepsPerCell2,
                              (kMaxSteps - 2) / (reach_cells * reach_cells));
  const int steps =
      static_cast<int>(reach_cells * reach_cells * steps_per_cell2_) + 1;
  table_.resize(static_cast<size_t>(steps));
  for (int i = 0; i < steps; ++i) {
    const double d2_m2 = (i + 0.5) / steps_per_cell2_ * cell_m * cell_m;
    table_[static_cast<size_t>(i)] = static_cast<uint8_t>(std::max(
        1.0, std::round(255 * std::exp(-d2_m2 / (2 * sigma_m * sigma_m)))));
  }
}

void SurfaceGrid::Draw(const PlacedScan& placed) {
  const ScanOutline& scan = *placed.scan;
  const geometry::Vec2 at = placed.target_from_scan.translation;
  const double c = std::cos(placed.target_from_scan.yaw_rad);
  const double s = std::sin(placed.target_from_scan.yaw_rad);
  const auto in_target = [&](size_t i) {
    const geometry::Vec2& p = scan.points_m[i];
    return geometry::Vec2{at.x + (c * p.x - s * p.y),
                          at.y + (s * p.x + c * p.y)};
  };
  bool ends_surface = false;  // point i is drawn already
  for (size_t i = 0; i < scan.size();) {
    const size_t end = StraightUntil(scan, i);
    if (end > i || !ends_surface) DrawPiece({in_target(i), in_target(end)});
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
  const double last_x = width_ - 1;
  const double last_y = height_ - 1;
  const double low_x = std::min(a.x, b.x) - reach;
  const double high_x = std::max(a.x, b.x) + reach;
  const double low_y = std::min(a.y, b.y) - reach;
  const double high_y = std::max(a.y, b.y) + reach;
  if (!(high_x >= 0) || !(high_y >= 0) || !(low_x <= last_x) ||
      !(low_y <= last_y)) {
    return;
  }
  if (pieces_.size() >= kMaxPieces) return;
  const auto number = static_cast<uint32_t>(pieces_.size());
  pieces_.push_back(piece);
  const GridSegment segment = {
      .begin_x = a.x,
      .begin_y = a.y,
      .along_x = b.x - a.x,
      .along_y = b.y - a.y,
      .left = static_cast<int>(std::max(0.0, std::ceil(low_x))),
      .right = static_cast<int>(std::min(last_x, std::floor(high_x))),
      .bottom = static_cast<int>(std::max(0.0, std::ceil(low_y))),
      .top = static_cast<int>(std::min(last_y, std::floor(high_y))),
      .reach = reach};
  drawn_left_ = std::min(drawn_left_, segment.left);
  drawn_right_ = std::max(drawn_right_, segment.right);
  drawn_bottom_ = std::min(drawn_bottom_, segment.bottom);
  drawn_top_ = std::max(drawn_top_, segment.top);
  DrawSegment(segment, number, steps_per_cell2_,
              static_cast<int>(table_.size()), width_, nearest_.data());
}

void SurfaceGrid::WriteLevel0() {
  levels_[0].assign(nearest_.size() - kGridSlack, uint8_t{0});
  for (int y = drawn_bottom_; y <= drawn_top_; ++y) {
    const size_t row = static_cast<size_t>(y) * static_cast<size_t>(width_);
    for (int x = drawn_left_; x <= drawn_right_; ++x) {
      const size_t cell = row + static_cast<size_t>(x);
      if (nearest_[cell] == kNoPiece) continue;
      levels_[0][cell] = table_[nearest_[cell] >> kPieceBits];
    }
  }
}

void SurfaceGrid::BuildPyramid(int levels) {
  const auto width = static_cast<size_t>(width_);
  levels_.resize(1);
  WriteLevel0();
  // What is 0 on the level below, and towards larger cells too, stays so.
  int left = drawn_left_;
  int bottom = drawn_bottom_;
  std::vector<uint8_t> wide;
  for (int h = 1; h < levels; ++h) {
    const std::vector<uint8_t>& below = levels_.back();
    std::vector<uint8_t> level(below.size(), uint8_t{0});
    const int step = 1 << (h - 1);
    left = std::max(0, left - step);
    const int rows_begin = bottom;
    bottom = std::max(0, bottom - step);
    if (drawn_right_ >= left) {
      const auto columns = static_cast<size_t>(drawn_right_ - left + 1);
      const int rows = drawn_top_ - rows_begin + 1;
      // First the larger of two columns, then the larger of two rows. Beyond
      // the border nothing is seen.
      wide.assign(columns * static_cast<size_t>(rows), 0);
      for (int y = 0; y < rows; ++y) {
        const uint8_t* from =
            &below[static_cast<size_t>(rows_begin + y) * width];
        uint8_t* to = &wide[static_cast<size_t>(y) * columns];
        const size_t paired = std::min(
            columns, width - std::min(width, static_cast<size_t>(left + step)));
        WriteLarger(from + left, from + left + step, to, paired);
        std::copy(from + left + paired, from + left + columns, to + paired);
      }
      for (int y = bottom; y <= drawn_top_; ++y) {
        uint8_t* to =
            &level[static_cast<size_t>(y) * width + static_cast<size_t>(left)];
        const int own = y - rows_begin;
        const int other = own + step;
        const auto row_of = [&](int row) {
          return &wide[static_cast<size_t>(row) * columns];
        };
        if (own >= 0 && other < rows) {
          WriteLarger(row_of(own), row_of(other), to, columns);
        } else if (own >= 0) {
          std::copy_n(row_of(own), columns, to);
        } else if (other >= 0 && other < rows) {
          std::copy_n(row_of(other), columns, to);
        }
      }
    }
    levels_.push_back(std::move(level));
  }
}

const SurfaceGrid::Piece* SurfaceGrid::NearestPiece(
    geometry::Vec2 point_in_target) const {
  const double x = (point_in_target.x - origin_.x) / cell_m_;
  const double y = (point_in_target.y - origin_.y) / cell_m_;
  if (!(x >= 0) || !(y >= 0) || !(x < width_) || !(y < height_)) return nullptr;
  const size_t cell = static_cast<size_t>(y) * static_cast<size_t>(width_) +
                      static_cast<size_t>(x);
  if (nearest_[cell] == kNoPiece) return nullptr;
  return &pieces_[nearest_[cell] & (kMaxPieces - 1)];
}

}  // namespace treeline::mapping
