// All scans of a drive laid upon each other at once.
#ifndef NAV_AGENT_MAPPING_SCAN_BUNDLE_H_
#define NAV_AGENT_MAPPING_SCAN_BUNDLE_H_

#include <span>
#include <vector>

#include "common/geometry/rigid2.h"
#include "nav_agent/mapping/pose_graph.h"
#include "nav_agent/mapping/scan_neighbours.h"
#include "nav_agent/mapping/scan_surfels.h"

namespace treeline::mapping {

struct ScanBundleOptions {
  ScanSurfelOptions surfels = {};
  // Two scans within this of each other see the same things (m, above 0).
  double overlap_m = 5.0;
  // Rounds of finding what lies upon what, and of moving the scans (1 or more).
  int rounds = 5;
  // The deviation of a surfel from another that it lies upon, beyond which its
  // pull wanes (Welsch's kernel): in the first round, where scans are off by
  // what the graph knows, and in the last (m, above 0).
  double first_sigma_m = 0.06;
  double last_sigma_m = 0.03;
  // What one pair of surfels tells, as one Gaussian of this deviation: less
  // than they scatter, as many share an error (m, above 0).
  double surfel_sigma_m = 0.1;
  // Surfels that are turned by more than this to each other are of different
  // surfaces (cosine).
  double min_cosine = 0.94;
  // Results do not depend on it.
  int threads = 1;

  bool IsValid() const;
};

// Moves poses 1 and up (pose 0 stays) so that
//
//   sum_pairs sum_surfels rho((n . (p - q))^2) + sum_priors
//
// becomes small, with p a surfel of one scan, q and n that of the other which
// it lies upon, and the priors as in OptimizePoseGraph, those that may be wrong
// under Cauchy's kernel: Gauss-Newton, with a sparse Cholesky factor (Eigen).
// Deterministic. False: it was not solved, and the poses are as they were.
bool AdjustBundle(std::span<const ScanSurfels> scans,
                  std::span<const ScanPair> pairs,
                  std::span<const PoseConstraint> priors,
                  const ScanBundleOptions& options,
                  std::vector<geometry::Rigid2>* map_from_scans);

// A scan at its place in the map.
struct PlacedSurfels {
  const ScanSurfels* scan = nullptr;
  geometry::Rigid2 map_from_scan;
};

// One scan's surfels laid upon those of others, which stay; it is known
// beforehand to be at `guess`, to a standard deviation (m, rad).
geometry::Rigid2 AlignWithBundle(std::span<const Surfel> surfels,
                                 std::span<const PlacedSurfels> others,
                                 const geometry::Rigid2& guess, double sigma_m,
                                 double sigma_rad,
                                 const ScanBundleOptions& options);

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_SCAN_BUNDLE_H_
