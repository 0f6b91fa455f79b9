#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nav_agent/localization/likelihood_field.cc"
#include "nav_agent/localization/likelihood_field.h"

#include <algorithm>
#include <cmath>

#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"

#ifndef NAV_AGENT_LOCALIZATION_LOG_TABLE_
#define NAV_AGENT_LOCALIZATION_LOG_TABLE_
namespace treeline {
// width x height cells.
struct LogTable {
  const float* logs;
  int width;
  int height;
};
}  // namespace treeline
#endif

HWY_BEFORE_NAMESPACE();
namespace treeline::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The sum over the points (in cells) of the logs of the cells that they fall
// into when they are turned and shifted.
float SumOfLogs(const LogTable& table, const float* px, const float* py,
                size_t count, float x, float y, float cosine, float sine) {
  const hn::ScalableTag<float> d;
  const hn::RebindToSigned<decltype(d)> di;
  const size_t lanes = hn::Lanes(d);
  const auto c = hn::Set(d, cosine);
  const auto s = hn::Set(d, sine);
  const auto x0 = hn::Set(d, x);
  const auto y0 = hn::Set(d, y);
  const auto zero = hn::Zero(d);
  // Clamped to the rim before it becomes a number of cells.
  const auto last_x = hn::Set(d, static_cast<float>(table.width - 1));
  const auto last_y = hn::Set(d, static_cast<float>(table.height - 1));
  const auto width = hn::Set(di, table.width);
  auto sum = hn::Zero(d);
  size_t i = 0;
  const auto logs_at = [&](auto bx, auto by) HWY_ATTR {
    const auto gx = hn::NegMulAdd(s, by, hn::MulAdd(c, bx, x0));
    const auto gy = hn::MulAdd(s, bx, hn::MulAdd(c, by, y0));
    const auto ix = hn::ConvertTo(di, hn::Min(hn::Max(gx, zero), last_x));
    const auto iy = hn::ConvertTo(di, hn::Min(hn::Max(gy, zero), last_y));
    return hn::GatherIndex(d, table.logs, hn::Add(hn::Mul(iy, width), ix));
  };
  for (; i + lanes <= count; i += lanes) {
    sum = hn::Add(sum, logs_at(hn::LoadU(d, px + i), hn::LoadU(d, py + i)));
  }
  if (i < count) {
    const auto mask = hn::FirstN(d, count - i);
    const auto logs = logs_at(hn::MaskedLoad(mask, d, px + i),
                              hn::MaskedLoad(mask, d, py + i));
    sum = hn::Add(sum, hn::IfThenElseZero(mask, logs));
  }
  return hn::GetLane(hn::SumOfLanes(d, sum));
}

void SumsOfLogs(const LogTable& table, const float* px, const float* py,
                size_t count, const PoseArrays& grid_from_base, float* sums) {
  for (size_t i = 0; i < grid_from_base.size(); ++i) {
    sums[i] = SumOfLogs(table, px, py, count, grid_from_base.x_m[i],
                        grid_from_base.y_m[i], grid_from_base.cos_yaw[i],
                        grid_from_base.sin_yaw[i]);
  }
}

}  // namespace treeline::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "nav_agent/core/distance_field.h"

namespace treeline {

HWY_EXPORT(SumsOfLogs);

absl::Status LikelihoodFieldOptions::Validate() const {
  if (!(sigma_hit_m > 0) || !(sigma_hit_m <= 10)) {
    return absl::InvalidArgumentError(
        absl::StrCat("likelihood field: sigma_hit_m is ", sigma_hit_m,
                     "; it must be above 0 and at most 10"));
  }
  if (!(hit_share > 0) || !(hit_share < 1)) {
    return absl::InvalidArgumentError(
        absl::StrCat("likelihood field: hit_share is ", hit_share,
                     "; it must be between 0 and 1"));
  }
  return absl::OkStatus();
}

void PoseArrays::Resize(size_t count) {
  x_m.resize(count);
  y_m.resize(count);
  cos_yaw.resize(count);
  sin_yaw.resize(count);
}

void PoseArrays::Set(size_t i, const Rigid2& map_from_base) {
  x_m[i] = static_cast<float>(map_from_base.translation.x);
  y_m[i] = static_cast<float>(map_from_base.translation.y);
  cos_yaw[i] = static_cast<float>(std::cos(map_from_base.yaw_rad));
  sin_yaw[i] = static_cast<float>(std::sin(map_from_base.yaw_rad));
}

absl::StatusOr<LikelihoodField> LikelihoodField::Create(
    const OccupancyGrid& grid, const LikelihoodFieldOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  if (grid.width < 1 || grid.height < 1 || !(grid.resolution_m > 0)) {
    return absl::InvalidArgumentError("likelihood field: a map without cells");
  }
  LikelihoodField field;
  field.options_ = options;
  field.width_ = grid.width + 2;
  field.height_ = grid.height + 2;
  field.cells_per_m_ = 1 / grid.resolution_m;
  field.grid_from_map_ = grid.map_from_grid.Inverse();
  // Beyond five sigma nothing is left of the hit.
  const double reach_m = 5 * options.sigma_hit_m;
  const std::vector<float> distances = DistanceToOccupied(grid, reach_m);
  const size_t row = static_cast<size_t>(field.width_);
  field.logs_.assign(row * static_cast<size_t>(field.height_),
                     field.LogAt(reach_m));
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      field.logs_[static_cast<size_t>(y + 1) * row +
                  static_cast<size_t>(x + 1)] =
          field.LogAt(distances[grid.IndexOf({x, y})]);
    }
  }
  return field;
}

float LikelihoodField::LogAt(double distance_m) const {
  const double ratio = distance_m / options_.sigma_hit_m;
  return static_cast<float>(
      std::log(options_.hit_share * std::exp(-0.5 * ratio * ratio) + 1 -
               options_.hit_share));
}

void LikelihoodField::SumLogLikelihoods(const ScanPoints& points,
                                        const PoseArrays& poses,
                                        std::span<float> sums) const {
  const float scale = static_cast<float>(cells_per_m_);
  const float c = static_cast<float>(std::cos(grid_from_map_.yaw_rad));
  const float s = static_cast<float>(std::sin(grid_from_map_.yaw_rad));
  const float tx = static_cast<float>(grid_from_map_.translation.x);
  const float ty = static_cast<float>(grid_from_map_.translation.y);
  // All lengths in cells, and one more for the rim.
  PoseArrays in_cells;
  in_cells.Resize(poses.size());
  for (size_t i = 0; i < poses.size(); ++i) {
    const float x = poses.x_m[i];
    const float y = poses.y_m[i];
    in_cells.x_m[i] = scale * (tx + c * x - s * y) + 1;
    in_cells.y_m[i] = scale * (ty + s * x + c * y) + 1;
    in_cells.cos_yaw[i] = scale * (c * poses.cos_yaw[i] - s * poses.sin_yaw[i]);
    in_cells.sin_yaw[i] = scale * (s * poses.cos_yaw[i] + c * poses.sin_yaw[i]);
  }
  HWY_DYNAMIC_DISPATCH(SumsOfLogs)
  ({logs_.data(), width_, height_}, points.x_m.data(), points.y_m.data(),
   points.size(), in_cells, sums.data());
}

void LikelihoodField::LogLikelihoods(const ScanPoints& points,
                                     const Rigid2& map_from_base,
                                     std::span<float> logs) const {
  const Rigid2 grid_from_base = grid_from_map_ * map_from_base;
  for (size_t i = 0; i < points.size(); ++i) {
    const Vec2 point =
        cells_per_m_ * (grid_from_base * Vec2{points.x_m[i], points.y_m[i]});
    const double x = std::clamp(point.x + 1, 0.0, width_ - 1.0);
    const double y = std::clamp(point.y + 1, 0.0, height_ - 1.0);
    logs[i] = logs_[static_cast<size_t>(y) * static_cast<size_t>(width_) +
                    static_cast<size_t>(x)];
  }
}

}  // namespace treeline
#endif  // HWY_ONCE
