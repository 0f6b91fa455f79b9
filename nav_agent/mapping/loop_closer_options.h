// What loop closing may be told.
#ifndef NAV_AGENT_MAPPING_LOOP_CLOSER_OPTIONS_H_
#define NAV_AGENT_MAPPING_LOOP_CLOSER_OPTIONS_H_

#include "absl/status/status.h"
#include "nav_agent/mapping/loop_suspects.h"
#include "nav_agent/mapping/scan_bundle.h"

namespace treeline::mapping {

struct LoopCloserOptions {
  bool enabled = true;
  // Keyscans as recent as this are the front end's matter.
  int recent = 20;
  // A chain is a run of at least min_chain keyscans, and is looked at up to
  // max_chain of them, near the place in question; the nearest max_chains
  // chains are tried for each keyscan.
  int min_chain = 4;
  int max_chain = 14;
  int max_chains = 2;
  // Two scans within this of each other see the same things (m).
  double overlap_m = 4.0;
  // The search about where the robot is estimated to be: this many standard
  // deviations of the graph's own estimate, and this part of the way there,
  // within the limits.
  double search_sigmas = 3.0;
  double search_of_way = 0.02;
  double min_search_m = 0.2;
  double max_search_m = 4.0;
  double min_search_rad = 0.1;
  double max_search_rad = 0.6;
  // Wide searches are made with this many keyscans at once, on coarse cells
  // first, and must respond by this much.
  int query_scans = 8;
  double wide_m = 0.5;
  double min_coarse_response = 0.55;
  // What verifies a loop: response on fine cells, of the wide query or of the
  // one scan, and how well the place is then known.
  double min_wide_response = 0.60;
  double min_response = 0.55;
  // A place beyond wide_m from where the graph expects it must respond by this
  // much better than that one: rooms along a corridor are alike.
  double min_distinction = 0.1;
  double max_sigma_m = 0.15;
  double max_sigma_rad = 0.05;
  // Those that would move the robot far, and what scans tell of each other's
  // places.
  LoopSuspectOptions suspects;
  // Loops that the optimised graph contradicts by more than this squared error
  // (3 degrees of freedom) are dropped.
  double max_squared_error = 30.0;
  // How all keyscans are laid upon each other in the end.
  ScanBundleOptions bundle = {};
  // Chains for each keyscan when all is tied once more, and where they begin:
  // nearer than `recent`, since the front end saw only what was behind.
  int polish_chains = 3;
  int polish_recent = 20;
  // Keyscans whose planes are farther apart than this are of different floors:
  // how far heights may drift, on the way to a loop of any length and for each
  // metre of it, up to the largest (m). Those whose planes are inclined by more
  // than max_tilt to each other (m per m) see different things.
  double max_gap_m = 0.3;
  double max_gap_m_per_m = 0.005;
  double largest_gap_m = 0.8;
  double max_tilt = 0.03;
  // Keyscans of a loop that are this near to each other, seen from above, stand
  // on the same ground (m).
  double same_ground_m = 0.5;
  // Threads for the chains of one keyscan; results do not depend on it.
  int threads = 1;

  absl::Status Validate() const;
};

}  // namespace treeline::mapping

#endif  // NAV_AGENT_MAPPING_LOOP_CLOSER_OPTIONS_H_
