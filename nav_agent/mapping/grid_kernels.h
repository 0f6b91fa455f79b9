// Loops over bytes of lookup grids, by Highway for whatever processor it is.
#ifndef NAV_AGENT_MAPPING_GRID_KERNELS_H_
#define NAV_AGENT_MAPPING_GRID_KERNELS_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace treeline::mapping {

// A straight piece of surface in cells of a grid, the centre of cell (0, 0) at
// the origin, and the cells about it.
struct GridSegment {
  double begin_x = 0;
  double begin_y = 0;
  double along_x = 0;
  double along_y = 0;
  int left = 0;
  int right = 0;
  int bottom = 0;
  int top = 0;
  // Cells farther away are left alone.
  double reach = 0;
};

// What a cell knows of the nearest piece: its squared distance, in steps, above
// kPieceBits, and its number below. Less is nearer. kNoPiece: there is none.
inline constexpr int kPieceBits = 22;
inline constexpr int kMaxSteps = 1 << (32 - kPieceBits);
inline constexpr uint32_t kNoPiece = 0xFFFFFFFF;
// Cells after the last one that must be there, and are not changed.
inline constexpr size_t kGridSlack = 64;

// Where the piece is nearer than what a cell knows. steps_per_cell2: of a
// squared distance in cells; those of max_steps, at most kMaxSteps - 1, and
// more are too far.
void DrawSegment(const GridSegment& segment, uint32_t piece,
                 double steps_per_cell2, int max_steps, int width,
                 uint32_t* cells);

// to[i] = max(a[i], b[i]) for i < count; `to` may be `a`.
void WriteLarger(const uint8_t* a, const uint8_t* b, uint8_t* to, size_t count);

// The window of cells whose sums are taken: rows and columns, and how many
// bytes of each row are read.
inline constexpr int kSumWindow = 11;
inline constexpr int kSumRow = 16;
using WindowSums = std::array<uint32_t, size_t{kSumWindow} * kSumRow>;

// sums[kSumRow * y + x] = the sum over offsets of corner[offset + y * width +
// x]; the columns from kSumWindow on mean nothing, and must be readable.
void SumWindows(const uint8_t* corner, std::span<const int32_t> offsets,
                int width, WindowSums& sums);

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_GRID_KERNELS_H_
