#include "nav_agent/mapping/window_matcher.h"

#include <algorithm>

#include "nav_agent/mapping/surface_grid.h"

namespace treeline::mapping {
namespace {

// See FindNear: factor on odometry noise, and the gain that it must bring.
constexpr double kLooseOdometryFactor = 10;
constexpr double kClearlyBetter = 0.02;
// Coarse cells are this many times as large; the search on fine ones about
// what was found.
constexpr double kCoarse = 2.5;
constexpr double kFineSearch_cells = 1.5;
constexpr double kFineSearch_rad = 0.03;

ScanMatch FindNear(std::span<const PlacedScan> references,
                   const ScanOutline& scan, const geometry::Rigid2& guess,
                   const MatchSearch& search,
                   const ScanMatcherOptions& options) {
  const SurfaceGrid grid =
      MakeSurfaceGrid(references, scan, guess, search, options);
  ScanMatch match = MatchScan(grid, scan, guess, search, options);
  // Noise stands for small errors. Wheels that spin are wrong by far more: what
  // then fits clearly better with hardly any odometry is accepted.
  MatchSearch loose_search = search;
  loose_search.guess_sigma_m *= kLooseOdometryFactor;
  loose_search.guess_sigma_rad *= kLooseOdometryFactor;
  const ScanMatch other = RefineMatch(grid, scan, match.target_from_scan, guess,
                                      loose_search, options);
  return other.response > match.response + kClearlyBetter ? other : match;
}

ScanMatch FindWidely(std::span<const PlacedScan> references,
                     const ScanOutline& scan, const geometry::Rigid2& guess,
                     const MatchSearch& search, double half_angle_rad,
                     const LaserSlamOptions& options) {
  // On coarse cells first, where odometry says next to nothing.
  ScanMatcherOptions coarse = options.matcher;
  coarse.cell_m *= kCoarse;
  coarse.sigma_m *= kCoarse;
  const MatchSearch wide = {
      .half_extent_m = options.max_search_m,
      .half_angle_rad = half_angle_rad,
      .guess_sigma_m = std::max(search.guess_sigma_m, options.max_search_m),
      .guess_sigma_rad = std::max(search.guess_sigma_rad, half_angle_rad)};
  const SurfaceGrid grid =
      MakeSurfaceGrid(references, scan, guess, wide, coarse);
  const geometry::Rigid2 rough =
      MatchScan(grid, scan, guess, wide, coarse).target_from_scan;
  MatchSearch fine = {.half_extent_m = kFineSearch_cells * coarse.cell_m,
                      .half_angle_rad = kFineSearch_rad,
                      .guess_sigma_m = wide.guess_sigma_m,
                      .guess_sigma_rad = wide.guess_sigma_rad};
  const ScanMatch elsewhere =
      FindNear(references, scan, rough, fine, options.matcher);
  // Wheels that spin turn the robot more than they move it: where all places
  // along a corridor fit, it is still where odometry has it.
  fine.half_extent_m = std::max(fine.half_extent_m, search.half_extent_m);
  fine.guess_sigma_m = search.guess_sigma_m;
  const ScanMatch turned =
      FindNear(references, scan, {guess.translation, rough.yaw_rad}, fine,
               options.matcher);
  return elsewhere.response > turned.response + kClearlyBetter ? elsewhere
                                                               : turned;
}

}  // namespace

WindowMatch MatchInWindow(std::span<const PlacedScan> references,
                          const ScanOutline& scan,
                          const geometry::Rigid2& guess,
                          const MatchSearch& search, double enough,
                          const LaserSlamOptions& options) {
  WindowMatch found = {
      .match = FindNear(references, scan, guess, search, options.matcher)};
  for (const double half_angle_rad :
       {options.max_search_rad, options.lost_search_rad}) {
    if (found.match.response >= enough) break;
    ++found.searched_widely;
    const ScanMatch other =
        FindWidely(references, scan, guess, search, half_angle_rad, options);
    if (other.response < found.match.response + options.better_response) {
      continue;
    }
    ++found.found_widely;
    found.match = other;
  }
  return found;
}

}  // namespace treeline::mapping
