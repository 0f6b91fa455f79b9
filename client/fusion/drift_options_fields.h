// The fields of DriftOptions by their names, as client/fusion_vectors has them.
#ifndef CLIENT_FUSION_DRIFT_OPTIONS_FIELDS_H_
#define CLIENT_FUSION_DRIFT_OPTIONS_FIELDS_H_

#include "client/fusion/drift_options.h"

namespace treeline::drift {

// Calls visit(name, field) for each field, a double or an int, in their order.
// Options is DriftOptions, const or not.
template <typename Options, typename Visit>
void ForEachField(Options& options, Visit visit) {
  visit("min_confidence", options.min_confidence);
  visit("max_fix_sigma_m", options.max_fix_sigma_m);
  visit("max_fix_sigma_deg", options.max_fix_sigma_deg);
  visit("fix_sigma_floor_m", options.fix_sigma_floor_m);
  visit("fix_sigma_floor_deg", options.fix_sigma_floor_deg);
  visit("repeated_view_factor", options.repeated_view_factor);
  visit("drift_m_per_sqrt_m", options.drift_m_per_sqrt_m);
  visit("drift_m_per_sqrt_s", options.drift_m_per_sqrt_s);
  visit("drift_deg_per_sqrt_m", options.drift_deg_per_sqrt_m);
  visit("drift_deg_per_sqrt_rad", options.drift_deg_per_sqrt_rad);
  visit("drift_deg_per_sqrt_s", options.drift_deg_per_sqrt_s);
  visit("world_gate", options.world_gate);
  visit("agreement_gate", options.agreement_gate);
  visit("max_single_fix_m", options.max_single_fix_m);
  visit("max_single_fix_deg", options.max_single_fix_deg);
  visit("min_odds", options.min_odds);
  visit("max_odds_of_fix", options.max_odds_of_fix);
  visit("lock_views", options.lock_views);
  visit("lock_fixes", options.lock_fixes);
  visit("lock_view_m", options.lock_view_m);
  visit("lock_view_deg", options.lock_view_deg);
  visit("contradiction_views", options.contradiction_views);
  visit("contradiction_view_m", options.contradiction_view_m);
  visit("contradiction_view_deg", options.contradiction_view_deg);
  visit("hypothesis_lifetime_s", options.hypothesis_lifetime_s);
  visit("max_hypotheses", options.max_hypotheses);
  visit("lost_after_s", options.lost_after_s);
  visit("lost_sigma_m", options.lost_sigma_m);
  visit("lost_sigma_deg", options.lost_sigma_deg);
  visit("max_correction_mps", options.max_correction_mps);
  visit("max_correction_degps", options.max_correction_degps);
  visit("snap_m", options.snap_m);
  visit("snap_deg", options.snap_deg);
  visit("history_s", options.history_s);
  visit("max_gap_s", options.max_gap_s);
  visit("max_speed_mps", options.max_speed_mps);
  visit("max_turn_degps", options.max_turn_degps);
}

}  // namespace treeline::drift

#endif  // CLIENT_FUSION_DRIFT_OPTIONS_FIELDS_H_
