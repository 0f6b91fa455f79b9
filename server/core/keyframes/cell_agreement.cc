#include "server/core/keyframes/cell_agreement.h"

#include <algorithm>

namespace treeline::keyframes {
namespace {

size_t CellOf(float pixel, float cells_per_px, int cells) {
  return static_cast<size_t>(
      std::clamp(static_cast<int>(pixel * cells_per_px), 0, cells - 1));
}

}  // namespace

CellAgreement::CellAgreement(int width, int height)
    : columns_per_px_(static_cast<float>(kCellColumns) /
                      static_cast<float>(width)),
      rows_per_px_(static_cast<float>(kCellRows) / static_cast<float>(height)) {
}

void CellAgreement::Add(float u, float v, float expected, float brightness,
                        bool agrees) {
  Cell& cell = cells_[CellOf(v, rows_per_px_, kCellRows) * kCellColumns +
                      CellOf(u, columns_per_px_, kCellColumns)];
  cell.moments.Add(expected, brightness);
  cell.agreeing += agrees;
}

bool CellAgreement::Cell::Tells() const {
  return moments.sums.w >= kMinCellPoints;
}

bool CellAgreement::Cell::Contradicts() const {
  return Tells() &&
         static_cast<float>(agreeing) < kMinCellAgreement * moments.sums.w &&
         moments.Correlation() < kMinCellCorrelation;
}

double CellAgreement::Contradicted() const {
  const auto told = std::ranges::count_if(cells_, &Cell::Tells);
  if (told == 0) return 0;
  return static_cast<double>(
             std::ranges::count_if(cells_, &Cell::Contradicts)) /
         static_cast<double>(told);
}

}  // namespace treeline::keyframes
