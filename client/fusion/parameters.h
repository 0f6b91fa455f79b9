// The tuned constants of the drift corrector: the defaults of DriftOptions.
// docs/explanation/device-fusion.md has this table, client/fusion_vectors and
// the TypeScript client have the same values.
#ifndef CLIENT_FUSION_PARAMETERS_H_
#define CLIENT_FUSION_PARAMETERS_H_

#include "common/base/parameter.h"

namespace treeline::drift {

// Which fixes are looked at, and what they are worth.
inline constexpr base::Parameter<double> kMinConfidence{
    "min_confidence", 0.5, "", base::ParameterOrigin::kPhysics,
    "less is more often wrong than right"};
inline constexpr base::Parameter<double> kMaxFixSigma_m{
    "max_fix_sigma", 0.3, "m", base::ParameterOrigin::kTuned,
    "what is less certain agrees with anything"};
inline constexpr base::Parameter<double> kMaxFixSigma_deg{
    "max_fix_sigma", 5, "deg", base::ParameterOrigin::kTuned,
    "the same, of the rotation"};
inline constexpr base::Parameter<double> kFixSigmaFloor_m{
    "fix_sigma_floor", 0.02, "m", base::ParameterOrigin::kTuned,
    "calibration, time stamps and scale are not in a fix's covariance"};
inline constexpr base::Parameter<double> kFixSigmaFloor_deg{
    "fix_sigma_floor", 0.5, "deg", base::ParameterOrigin::kTuned,
    "the same, of the rotation"};
inline constexpr base::Parameter<double> kRepeatedViewFactor{
    "repeated_view_factor", 4, "", base::ParameterOrigin::kTuned,
    "variance: fixes of one view share half of their error"};

// Drift of the tracking: standard deviations that grow with a root.
inline constexpr base::Parameter<double> kDrift_m_per_sqrt_m{
    "drift", 0.03, "m/sqrt(m)", base::ParameterOrigin::kTuned,
    "1 % of 10 m, as phones drift"};
inline constexpr base::Parameter<double> kDrift_m_per_sqrt_s{
    "drift", 0.002, "m/sqrt(s)", base::ParameterOrigin::kTuned,
    "a device at rest hardly drifts"};
inline constexpr base::Parameter<double> kDrift_deg_per_sqrt_m{
    "drift", 0.15, "deg/sqrt(m)", base::ParameterOrigin::kTuned,
    "half a degree in 10 m, ..."};
inline constexpr base::Parameter<double> kDrift_deg_per_sqrt_rad{
    "drift", 0.3, "deg/sqrt(rad)", base::ParameterOrigin::kTuned,
    "... or in half a turn"};
inline constexpr base::Parameter<double> kDrift_deg_per_sqrt_s{
    "drift", 0.02, "deg/sqrt(s)", base::ParameterOrigin::kTuned,
    "a device at rest hardly drifts"};

// Agreement: squared Mahalanobis distances, and the most that one fix does.
inline constexpr base::Parameter<double> kWorldGate{
    "world_gate", 22.46, "", base::ParameterOrigin::kPhysics,
    "chi-square, 6 degrees of freedom, 99.9 %"};
inline constexpr base::Parameter<double> kAgreementGate{
    "agreement_gate", 16.81, "", base::ParameterOrigin::kPhysics,
    "99 %: stricter, since chance must not bring lies together"};
inline constexpr base::Parameter<double> kMaxSingleFix_m{
    "max_single_fix", 0.15, "m", base::ParameterOrigin::kTuned,
    "three times what a right fix errs at most"};
inline constexpr base::Parameter<double> kMaxSingleFix_deg{
    "max_single_fix", 3, "deg", base::ParameterOrigin::kTuned,
    "the same, of the rotation"};

// What a hypothesis needs to be the world.
inline constexpr base::Parameter<double> kMinOdds{
    "min_odds", 99, "", base::ParameterOrigin::kPhysics,
    "the odds that Treeline's own threshold stands for"};
inline constexpr base::Parameter<double> kMaxOddsOfFix{
    "max_odds_of_fix", 49, "", base::ParameterOrigin::kTuned,
    "no single fix decides"};
inline constexpr base::Parameter<int> kLockViews{
    "lock_views", 2, "", base::ParameterOrigin::kTuned,
    "a hand trembles enough for two views; a tripod does not"};
inline constexpr base::Parameter<int> kLockFixes{"lock_fixes", 4, "",
                                                 base::ParameterOrigin::kTuned,
                                                 "for a device on a tripod"};
inline constexpr base::Parameter<double> kLockView_m{
    "lock_view", 0.05, "m", base::ParameterOrigin::kTuned, "a step aside"};
inline constexpr base::Parameter<double> kLockView_deg{
    "lock_view", 2, "deg", base::ParameterOrigin::kTuned, "a glance"};
inline constexpr base::Parameter<int> kContradictionViews{
    "contradiction_views", 3, "", base::ParameterOrigin::kTuned,
    "places that look alike deceive one view, seldom three"};
inline constexpr base::Parameter<double> kContradictionView_m{
    "contradiction_view", 0.3, "m", base::ParameterOrigin::kTuned,
    "really another view"};
inline constexpr base::Parameter<double> kContradictionView_deg{
    "contradiction_view", 15, "deg", base::ParameterOrigin::kTuned,
    "the same, of the rotation"};
inline constexpr base::Parameter<double> kHypothesisLifetime_s{
    "hypothesis_lifetime", 30, "s", base::ParameterOrigin::kTuned,
    "what nobody supports for so long is forgotten"};
inline constexpr base::Parameter<int> kMaxHypotheses{
    "max_hypotheses", 8, "", base::ParameterOrigin::kTuned,
    "bounds the work of a frame"};

// When the world is lost.
inline constexpr base::Parameter<double> kLostAfter_s{
    "lost_after", 60, "s", base::ParameterOrigin::kTuned,
    "no good fix for so long"};
inline constexpr base::Parameter<double> kLostSigma_m{
    "lost_sigma", 0.5, "m", base::ParameterOrigin::kTuned,
    "content is no longer where it belongs"};
inline constexpr base::Parameter<double> kLostSigma_deg{
    "lost_sigma", 5, "deg", base::ParameterOrigin::kTuned,
    "the same, of the rotation"};

// What is shown moves to what is known.
inline constexpr base::Parameter<double> kMaxCorrection_mps{
    "max_correction", 0.05, "m/s", base::ParameterOrigin::kTuned,
    "hardly seen in motion"};
inline constexpr base::Parameter<double> kMaxCorrection_degps{
    "max_correction", 2, "deg/s", base::ParameterOrigin::kTuned,
    "the same, of the rotation"};
inline constexpr base::Parameter<double> kSnap_m{
    "snap", 1, "m", base::ParameterOrigin::kTuned,
    "to creep there would take 20 s"};
inline constexpr base::Parameter<double> kSnap_deg{
    "snap", 20, "deg", base::ParameterOrigin::kTuned,
    "the same, of the rotation"};

// The tracking: what is remembered, and what is no continuation.
inline constexpr base::Parameter<double> kHistory_s{
    "history", 10, "s", base::ParameterOrigin::kTuned,
    "longer than any deadline"};
inline constexpr base::Parameter<double> kMaxGap_s{
    "max_gap", 1, "s", base::ParameterOrigin::kTuned,
    "a tracker that was away that long has begun anew"};
inline constexpr base::Parameter<double> kMaxSpeed_mps{
    "max_speed", 10, "m/s", base::ParameterOrigin::kPhysics,
    "nobody moves so fast"};
inline constexpr base::Parameter<double> kMaxTurn_degps{
    "max_turn", 720, "deg/s", base::ParameterOrigin::kPhysics,
    "nobody turns so fast"};

}  // namespace treeline::drift

#endif  // CLIENT_FUSION_PARAMETERS_H_
