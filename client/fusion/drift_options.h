// What a caller may choose of the drift corrector.
#ifndef CLIENT_FUSION_DRIFT_OPTIONS_H_
#define CLIENT_FUSION_DRIFT_OPTIONS_H_

#include "absl/status/status.h"
#include "client/fusion/parameters.h"

namespace treeline::drift {

// Every number is finite and positive; counts are at least 1. parameters.h says
// what each is for. "sigma" is a standard deviation along or about an axis.
struct DriftOptions {
  // Which fixes are looked at, and what they are worth.
  double min_confidence = kMinConfidence;  // in (0, 1]
  double max_fix_sigma_m = kMaxFixSigma_m;
  double max_fix_sigma_deg = kMaxFixSigma_deg;
  double fix_sigma_floor_m = kFixSigmaFloor_m;
  double fix_sigma_floor_deg = kFixSigmaFloor_deg;
  double repeated_view_factor = kRepeatedViewFactor;

  // Drift of the tracking: standard deviations that grow with a root.
  double drift_m_per_sqrt_m = kDrift_m_per_sqrt_m;
  double drift_m_per_sqrt_s = kDrift_m_per_sqrt_s;
  double drift_deg_per_sqrt_m = kDrift_deg_per_sqrt_m;
  double drift_deg_per_sqrt_rad = kDrift_deg_per_sqrt_rad;
  double drift_deg_per_sqrt_s = kDrift_deg_per_sqrt_s;

  // Agreement: squared Mahalanobis distances, and the most that one fix does.
  double world_gate = kWorldGate;
  double agreement_gate = kAgreementGate;
  double max_single_fix_m = kMaxSingleFix_m;
  double max_single_fix_deg = kMaxSingleFix_deg;

  // What a hypothesis needs to be the world.
  double min_odds = kMinOdds;
  double max_odds_of_fix = kMaxOddsOfFix;
  int lock_views = kLockViews;
  int lock_fixes = kLockFixes;
  double lock_view_m = kLockView_m;
  double lock_view_deg = kLockView_deg;
  int contradiction_views = kContradictionViews;
  double contradiction_view_m = kContradictionView_m;
  double contradiction_view_deg = kContradictionView_deg;
  double hypothesis_lifetime_s = kHypothesisLifetime_s;
  int max_hypotheses = kMaxHypotheses;

  // When the world is lost.
  double lost_after_s = kLostAfter_s;
  double lost_sigma_m = kLostSigma_m;
  double lost_sigma_deg = kLostSigma_deg;

  // What is shown moves to what is known.
  double max_correction_mps = kMaxCorrection_mps;
  double max_correction_degps = kMaxCorrection_degps;
  double snap_m = kSnap_m;
  double snap_deg = kSnap_deg;

  // The tracking: what is remembered, and what is no continuation.
  double history_s = kHistory_s;
  double max_gap_s = kMaxGap_s;
  double max_speed_mps = kMaxSpeed_mps;
  double max_turn_degps = kMaxTurn_degps;

  // INVALID_ARGUMENT names the first field that makes no sense.
  absl::Status Validate() const;
};

}  // namespace treeline::drift

#endif  // CLIENT_FUSION_DRIFT_OPTIONS_H_
