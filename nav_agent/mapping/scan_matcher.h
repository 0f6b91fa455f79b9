// Where a scan was taken, relative to others.
#ifndef NAV_AGENT_MAPPING_SCAN_MATCHER_H_
#define NAV_AGENT_MAPPING_SCAN_MATCHER_H_

#include <array>
#include <limits>
#include <span>

#include "absl/status/status.h"
#include "nav_agent/mapping/surface_grid.h"

namespace treeline::mapping {

// Of (x, y, yaw), row-major, as docs/frames.md defines covariance of a
// transform a_from_b: translation along a's axes (m), rotation about b's
// origin (rad).
using Covariance3 = std::array<double, 9>;

struct ScanMatcherOptions {
  // Cells of the lookup grid, and the deviation of a return from the surface
  // it is of, with what the references are off among themselves (m, above 0).
  double cell_m = 0.04;
  double sigma_m = 0.05;
  // By how much the log likelihood of one point counts: points that share an
  // error, as those on one wall do, are not independent (0 to 1).
  double point_weight = 0.3;
  // Steps in yaw move this part of the points by less than a cell (0 to 1).
  double angle_quantile = 0.8;

  absl::Status Validate() const;
};

// What is searched, and what is known beforehand.
struct MatchSearch {
  // The scan is assumed within this of the guess: in x and y, and in yaw.
  double half_extent_m = 0.3;
  double half_angle_rad = 0.35;
  // Standard deviations of the guess; infinite: it says nothing.
  double guess_sigma_m = std::numeric_limits<double>::infinity();
  double guess_sigma_rad = std::numeric_limits<double>::infinity();
};

struct ScanMatch {
  geometry::Rigid2 target_from_scan;
  // The mean over points of exp(-d^2 / (2 sigma^2)): 1 if all lie on surfaces.
  double response = 0;
  // Of target_from_scan.
  Covariance3 covariance{};
  int points = 0;
  // The best pose is at the edge of what was searched: the peak may lie beyond.
  bool is_at_border = false;
};

// A grid that MatchScan can search in around `guess`.
SurfaceGrid MakeSurfaceGrid(std::span<const PlacedScan> references,
                            const ScanOutline& scan,
                            const geometry::Rigid2& guess,
                            const MatchSearch& search,
                            const ScanMatcherOptions& options);

// The pose that maximises
//
//   log p = w sum_i exp(-d_i^2 / (2 sigma^2)) - |pose - guess|^2 / 2
//
// with w = point_weight, d_i the distance of point i to the nearest surface
// and the last term in standard deviations of the guess: the robust likelihood
// of Welsch. It is found exactly on the grid, by branch and bound (Olson,
// "Real-Time Correlative Scan Matching", ICRA 2009; Hess et al. 2016), then
// refined on the surfaces themselves, not on their cells, by iteratively
// reweighted least squares. The covariance is that of p over the cells around
// the best one (Olson, section IV) plus that of the peak itself, the inverse
// of its curvature: along a featureless corridor it is large.
//
// Deterministic. If the scan has no points, the guess comes back with response
// 0 and a covariance of the whole search.
ScanMatch MatchScan(const SurfaceGrid& grid, const ScanOutline& scan,
                    const geometry::Rigid2& guess, const MatchSearch& search,
                    const ScanMatcherOptions& options);

// The refinement alone, from `start`.
ScanMatch RefineMatch(const SurfaceGrid& grid, const ScanOutline& scan,
                      const geometry::Rigid2& start,
                      const geometry::Rigid2& guess, const MatchSearch& search,
                      const ScanMatcherOptions& options);

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_SCAN_MATCHER_H_
