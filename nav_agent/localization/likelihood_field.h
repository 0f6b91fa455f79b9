// How well a scan fits a map at a pose, by the distances from where its beams
// end to the nearest obstacles.
#ifndef NAV_AGENT_LOCALIZATION_LIKELIHOOD_FIELD_H_
#define NAV_AGENT_LOCALIZATION_LIKELIHOOD_FIELD_H_

#include <cstdint>
#include <span>
#include <vector>

#include "absl/status/statusor.h"
#include "nav_agent/core/occupancy_grid.h"
#include "nav_agent/localization/parameters.h"
#include "nav_agent/localization/scan_points.h"

namespace treeline::localization {

// Probabilistic Robotics, table 6.3, without its constant for beams of the
// largest range (they are left out):
//   p(beam) = hit_share * exp(-d^2 / (2 sigma_hit^2)) + 1 - hit_share
// where d is the distance of its end to the nearest occupied cell, so that a
// beam that fits perfectly has 1 and one that does not fit at all 1 -
// hit_share.
struct LikelihoodFieldOptions {
  double sigma_hit_m = kHitStd_m;
  // The share of beams that obstacles of the map explain.
  double hit_share = kBeamHitShare;

  // INVALID_ARGUMENT for sigma_hit_m outside (0, 10], hit_share outside (0, 1).
  absl::Status Validate() const;
};

// Poses of many particles, one array a coordinate; yaw as cosine and sine.
// Heights of the ground matter to fields of several layers only.
struct PoseArrays {
  std::vector<float> x_m;
  std::vector<float> y_m;
  std::vector<float> height_m;
  std::vector<float> cos_yaw;
  std::vector<float> sin_yaw;

  void Resize(size_t count);
  void Set(size_t i, const geometry::Rigid2& map_from_base,
           double ground_m = 0);
  size_t size() const { return x_m.size(); }
};

// What is occupied between heights: layer i reaches from lowest_m + i *
// layer_m to lowest_m + (i + 1) * layer_m. All grids have the same cells.
struct OccupancyLayers {
  double lowest_m = 0;
  double layer_m = kLayer_m;
  std::vector<core::OccupancyGrid> grids;
};

// Immutable and thread-safe. Four bytes a cell and layer.
class LikelihoodField {
 public:
  // INVALID_ARGUMENT for bad options and for a grid without cells.
  static absl::StatusOr<LikelihoodField> Create(
      const core::OccupancyGrid& grid, const LikelihoodFieldOptions& options);
  // A field for each layer: points need their heights above the ground (z_m),
  // and poses that of the ground. What is above or below all layers belongs to
  // the nearest. INVALID_ARGUMENT for bad options, for no layers, and for
  // grids that differ in their cells.
  static absl::StatusOr<LikelihoodField> CreateLayered(
      const OccupancyLayers& layers, const LikelihoodFieldOptions& options);

  // Of no cells: to be replaced.
  static LikelihoodField Empty() { return {}; }

  // sums[i] = sum over the points of log p(point seen from poses i).
  void SumLogLikelihoods(const ScanPoints& points, const PoseArrays& poses,
                         std::span<float> sums) const;

  // log p of each point seen from one pose.
  void LogLikelihoods(const ScanPoints& points,
                      const geometry::Rigid2& map_from_base,
                      std::span<float> logs, double ground_m = 0) const;

  // log p of a point at this distance from the nearest obstacle.
  float LogAt(double distance_m) const;

 private:
  LikelihoodField() = default;
  void AddLayer(const core::OccupancyGrid& grid);

  LikelihoodFieldOptions options_;
  // One cell wider on each side than the grid: what lies outside ends there.
  int width_ = 0;
  int height_ = 0;
  int layers_ = 1;
  double lowest_m_ = 0;
  // 0: one layer for all heights.
  double layers_per_m_ = 0;
  // Layer by layer.
  std::vector<float> logs_;
  // From the map to cells of logs_.
  geometry::Rigid2 grid_from_map_;
  double cells_per_m_ = 0;
};

}  // namespace treeline::localization

#endif  // NAV_AGENT_LOCALIZATION_LIKELIHOOD_FIELD_H_
