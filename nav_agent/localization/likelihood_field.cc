#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nav_agent/localization/likelihood_field.cc"
#include "nav_agent/localization/likelihood_field.h"

#include <algorithm>
#include <cmath>

#include "hwy/foreach_target.h"  // IWYU pragma: keep
#include "hwy/highway.h"

#ifndef NAV_AGENT_LOCALIZATION_LOG_TABLE_
#define NAV_AGENT_LOCALIZATION_LOG_TABLE_
namespace treeline::localization {
// width x height cells in each of so many layers.
struct LogTable {
  const float* logs;
  int width;
  int height;
  int layers;
  // Layers a metre; 0 where points have no heights.
  float layers_per_m;
};
// x, y and z of points; z is null where there is one layer.
struct PointArrays {
  const float* x;
  const float* y;
  const float* z;
  size_t count;
};
// One pose: a shift in cells and layers, and a turn.
struct CellPose {
  float x;
  float y;
  float layer;
  float cosine;
  float sine;
};
}  // namespace treeline::localization
#endif

HWY_BEFORE_NAMESPACE();
namespace treeline::localization::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The sum over the points of the logs of the cells that they fall into when
// they are turned and shifted.
template <bool kLayered>
float SumOfLogs(const LogTable& table, const PointArrays& points,
                const CellPose& pose) {
  const hn::ScalableTag<float> d;
  const hn::RebindToSigned<decltype(d)> di;
  const size_t lanes = hn::Lanes(d);
  const auto c = hn::Set(d, pose.cosine);
  const auto s = hn::Set(d, pose.sine);
  const auto x0 = hn::Set(d, pose.x);
  const auto y0 = hn::Set(d, pose.y);
  const auto z0 = hn::Set(d, pose.layer);
  const auto zero = hn::Zero(d);
  const auto per_m = hn::Set(d, table.layers_per_m);
  // Clamped to the rim before it becomes a number of cells.
  const auto last_x = hn::Set(d, static_cast<float>(table.width - 1));
  const auto last_y = hn::Set(d, static_cast<float>(table.height - 1));
  const auto last_z = hn::Set(d, static_cast<float>(table.layers - 1));
  const auto width = hn::Set(di, table.width);
  const auto cells = hn::Set(di, table.width * table.height);
  auto sum = hn::Zero(d);
  size_t i = 0;
  const auto logs_at = [&](auto bx, auto by,
                           [[maybe_unused]] auto bz) HWY_ATTR {
    const auto gx = hn::NegMulAdd(s, by, hn::MulAdd(c, bx, x0));
    const auto gy = hn::MulAdd(s, bx, hn::MulAdd(c, by, y0));
    const auto ix = hn::ConvertTo(di, hn::Min(hn::Max(gx, zero), last_x));
    const auto iy = hn::ConvertTo(di, hn::Min(hn::Max(gy, zero), last_y));
    auto cell = hn::Add(hn::Mul(iy, width), ix);
    if constexpr (kLayered) {
      const auto gz = hn::MulAdd(per_m, bz, z0);
      const auto iz = hn::ConvertTo(di, hn::Min(hn::Max(gz, zero), last_z));
      cell = hn::Add(cell, hn::Mul(iz, cells));
    }
    return hn::GatherIndex(d, table.logs, cell);
  };
  for (; i + lanes <= points.count; i += lanes) {
    auto z = zero;
    if constexpr (kLayered) z = hn::LoadU(d, points.z + i);
    sum = hn::Add(sum, logs_at(hn::LoadU(d, points.x + i),
                               hn::LoadU(d, points.y + i), z));
  }
  if (i < points.count) {
    const auto mask = hn::FirstN(d, points.count - i);
    auto z = zero;
    if constexpr (kLayered) z = hn::MaskedLoad(mask, d, points.z + i);
    const auto logs = logs_at(hn::MaskedLoad(mask, d, points.x + i),
                              hn::MaskedLoad(mask, d, points.y + i), z);
    sum = hn::Add(sum, hn::IfThenElseZero(mask, logs));
  }
  return hn::GetLane(hn::SumOfLanes(d, sum));
}

// Heights of `grid_from_base` are in layers.
void SumsOfLogs(const LogTable& table, const PointArrays& points,
                const PoseArrays& grid_from_base, float* sums) {
  for (size_t i = 0; i < grid_from_base.size(); ++i) {
    const CellPose pose = {grid_from_base.x_m[i], grid_from_base.y_m[i],
                           grid_from_base.height_m[i],
                           grid_from_base.cos_yaw[i],
                           grid_from_base.sin_yaw[i]};
    sums[i] = points.z == nullptr ? SumOfLogs<false>(table, points, pose)
                                  : SumOfLogs<true>(table, points, pose);
  }
}

}  // namespace treeline::localization::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "nav_agent/core/distance_field.h"

namespace treeline::localization {

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
  height_m.resize(count);
  cos_yaw.resize(count);
  sin_yaw.resize(count);
}

void PoseArrays::Set(size_t i, const geometry::Rigid2& map_from_base,
                     double ground_m) {
  x_m[i] = static_cast<float>(map_from_base.translation.x);
  y_m[i] = static_cast<float>(map_from_base.translation.y);
  height_m[i] = static_cast<float>(ground_m);
  cos_yaw[i] = static_cast<float>(std::cos(map_from_base.yaw_rad));
  sin_yaw[i] = static_cast<float>(std::sin(map_from_base.yaw_rad));
}

absl::StatusOr<LikelihoodField> LikelihoodField::Create(
    const core::OccupancyGrid& grid, const LikelihoodFieldOptions& options) {
  OccupancyLayers layers;
  layers.grids.push_back(grid);
  TL_ASSIGN_OR_RETURN(LikelihoodField field, CreateLayered(layers, options));
  field.layers_per_m_ = 0;
  return field;
}

absl::StatusOr<LikelihoodField> LikelihoodField::CreateLayered(
    const OccupancyLayers& layers, const LikelihoodFieldOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  if (layers.grids.empty() || layers.grids[0].width < 1 ||
      layers.grids[0].height < 1 || !(layers.grids[0].resolution_m > 0) ||
      !(layers.layer_m > 0) || !std::isfinite(layers.lowest_m)) {
    return absl::InvalidArgumentError("likelihood field: a map without cells");
  }
  const core::OccupancyGrid& first = layers.grids[0];
  // What is numbered by 32 bits.
  if (static_cast<double>(first.width + 2) * (first.height + 2) *
          static_cast<double>(layers.grids.size()) >
      0x1p30) {
    return absl::InvalidArgumentError(
        "likelihood field: more than 2^30 cells in all layers");
  }
  LikelihoodField field;
  field.options_ = options;
  field.width_ = first.width + 2;
  field.height_ = first.height + 2;
  field.layers_ = static_cast<int>(layers.grids.size());
  field.lowest_m_ = layers.lowest_m;
  field.layers_per_m_ = 1 / layers.layer_m;
  field.cells_per_m_ = 1 / first.resolution_m;
  field.grid_from_map_ = first.map_from_grid.Inverse();
  for (const core::OccupancyGrid& grid : layers.grids) {
    if (grid.width != first.width || grid.height != first.height ||
        grid.resolution_m != first.resolution_m ||
        grid.map_from_grid != first.map_from_grid) {
      return absl::InvalidArgumentError(
          "likelihood field: layers with different cells");
    }
    field.AddLayer(grid);
  }
  return field;
}

void LikelihoodField::AddLayer(const core::OccupancyGrid& grid) {
  // Beyond five sigma nothing is left of the hit.
  const double reach_m = 5 * options_.sigma_hit_m;
  const std::vector<float> distances = core::DistanceToOccupied(grid, reach_m);
  const size_t row = static_cast<size_t>(width_);
  const size_t begin = logs_.size();
  logs_.resize(begin + row * static_cast<size_t>(height_), LogAt(reach_m));
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      logs_[begin + static_cast<size_t>(y + 1) * row +
            static_cast<size_t>(x + 1)] =
          LogAt(distances[grid.IndexOf({x, y})]);
    }
  }
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
  const float per_m = static_cast<float>(layers_per_m_);
  const float lowest = static_cast<float>(lowest_m_);
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
    in_cells.height_m[i] = per_m * (poses.height_m[i] - lowest);
  }
  const bool is_layered = per_m > 0 && points.has_heights();
  HWY_DYNAMIC_DISPATCH(SumsOfLogs)
  ({logs_.data(), width_, height_, layers_, per_m},
   {points.x_m.data(), points.y_m.data(),
    is_layered ? points.z_m.data() : nullptr, points.size()},
   in_cells, sums.data());
}

void LikelihoodField::LogLikelihoods(const ScanPoints& points,
                                     const geometry::Rigid2& map_from_base,
                                     std::span<float> logs,
                                     double ground_m) const {
  const geometry::Rigid2 grid_from_base = grid_from_map_ * map_from_base;
  const bool is_layered = layers_per_m_ > 0 && points.has_heights();
  const size_t cells =
      static_cast<size_t>(width_) * static_cast<size_t>(height_);
  for (size_t i = 0; i < points.size(); ++i) {
    const geometry::Vec2 point =
        cells_per_m_ *
        (grid_from_base * geometry::Vec2{points.x_m[i], points.y_m[i]});
    const double x = std::clamp(point.x + 1, 0.0, width_ - 1.0);
    const double y = std::clamp(point.y + 1, 0.0, height_ - 1.0);
    double layer = 0;
    if (is_layered) {
      layer = std::clamp(layers_per_m_ * (ground_m + points.z_m[i] - lowest_m_),
                         0.0, layers_ - 1.0);
    }
    logs[i] = logs_[static_cast<size_t>(layer) * cells +
                    static_cast<size_t>(y) * static_cast<size_t>(width_) +
                    static_cast<size_t>(x)];
  }
}

}  // namespace treeline::localization
#endif  // HWY_ONCE
