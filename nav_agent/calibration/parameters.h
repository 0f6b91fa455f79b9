// Tuned and measured constants of the calibration.
#ifndef NAV_AGENT_CALIBRATION_PARAMETERS_H_
#define NAV_AGENT_CALIBRATION_PARAMETERS_H_

#include <vector>

#include "common/base/parameter.h"

namespace treeline::calibration {

// ---- What is read ----

inline constexpr base::Parameter<double> kScanSpacing_s{
    "scan_spacing", 0.08, "s", base::ParameterOrigin::kGeometry,
    "scans nearer to each other are left out: they show the same"};
inline constexpr base::Parameter<double> kClockJump_s{
    "clock_jump", 1.0, "s", base::ParameterOrigin::kMeasured,
    "stamps that go back by more are of a clock that jumped"};
inline constexpr base::Parameter<double> kLongestGap_s{
    "longest_gap", 1.0, "s", base::ParameterOrigin::kTuned,
    "no motion is measured over a longer silence of scans or wheels"};
inline constexpr base::Parameter<double> kUsualGaps{
    "usual_gaps", 4, "", base::ParameterOrigin::kTuned,
    "of recordings with scans seconds apart: a gap is so many of the usual"};
inline constexpr base::Parameter<double> kLongestWait_s{
    "longest_wait", 15, "s", base::ParameterOrigin::kTuned,
    "but in no recording is a gap allowed to be longer"};
inline constexpr base::Parameter<double> kDelayInterval_s{
    "delay_interval", 0.5, "s", base::ParameterOrigin::kTuned,
    "readings farther apart do not tell when wheels turned"};

// ---- Motions ----

inline constexpr base::Parameter<double> kWindowWay_m{
    "window_way", 0.5, "m", base::ParameterOrigin::kTuned,
    "of one measured motion: long beside what matching errs, and both scans "
    "still see the same"};
inline constexpr base::Parameter<double> kWindowTurn_rad{
    "window_turn", 0.35, "rad", base::ParameterOrigin::kTuned,
    "the same for turns"};
inline constexpr base::Parameter<double> kStillWay_m{
    "still_way", 0.01, "m", base::ParameterOrigin::kMeasured,
    "less is standing still"};
inline constexpr base::Parameter<double> kStillTurn_rad{
    "still_turn", 0.01, "rad", base::ParameterOrigin::kMeasured,
    "less is standing still"};
inline constexpr base::Parameter<double> kLongestWindow_s{
    "longest_window", 5, "s", base::ParameterOrigin::kTuned,
    "slower motions are mostly standing"};
inline constexpr base::Parameter<double> kSearchWay_m{
    "search_way", 0.6, "m", base::ParameterOrigin::kTuned,
    "more than a motion: a laser that looks anywhere is found"};
inline constexpr base::Parameter<double> kSearchTurn_rad{
    "search_turn", 0.3, "rad", base::ParameterOrigin::kTuned,
    "as far as turns by wheels and by scans may differ"};
inline constexpr base::Parameter<double> kMatchRange_m{
    "match_range", 15, "m", base::ParameterOrigin::kTuned,
    "farther returns depend on how level the robot stands"};
inline constexpr base::Parameter<double> kMinResponse{
    "min_response", 0.5, "", base::ParameterOrigin::kTuned,
    "scans that respond less do not show the same place"};
inline constexpr base::Parameter<double> kAgree_m{
    "agree", 0.06, "m", base::ParameterOrigin::kTuned,
    "matched there and back must agree"};
inline constexpr base::Parameter<double> kAgree_rad{
    "agree_turn", 0.03, "rad", base::ParameterOrigin::kTuned,
    "the same for turns"};
inline constexpr base::Parameter<double> kMatchNoise_m{
    "match_noise", 0.004, "m", base::ParameterOrigin::kMeasured,
    "no match is better, whatever it says"};
inline constexpr base::Parameter<double> kMatchNoise_rad{
    "match_noise_turn", 0.0015, "rad", base::ParameterOrigin::kMeasured,
    "the same for turns"};
inline constexpr base::Parameter<double> kMatchBias_m{
    "match_bias", 0.001, "m", base::ParameterOrigin::kMeasured,
    "what all matches may err alike, in simulated drives 0.9 mm"};
inline constexpr base::Parameter<double> kMatchBias_rad{
    "match_bias_turn", 0.0005, "rad", base::ParameterOrigin::kMeasured,
    "the same for turns"};
inline constexpr base::Parameter<double> kCameraBias_m{
    "camera_bias", 0.003, "m", base::ParameterOrigin::kMeasured,
    "what all motions by pictures may err alike: depth that is 0.6 % off"};
inline constexpr base::Parameter<double> kDepthShare{
    "depth_share", 0.006, "", base::ParameterOrigin::kMeasured,
    "what depth cameras are off, as a share of the distance"};
inline constexpr base::Parameter<double> kDelayBias_s{
    "delay_bias", 0.0005, "s", base::ParameterOrigin::kMeasured,
    "from taking that wheels turn evenly between two readings"};
inline constexpr base::Parameter<int> kMinMotions{
    "min_motions", 12, "", base::ParameterOrigin::kTuned,
    "fewer say nothing about seven numbers"};
inline constexpr base::Parameter<int> kMaxMotions{
    "max_motions", 800, "", base::ParameterOrigin::kTuned,
    "of longer drives every n-th is matched: more takes long and adds little"};

// ---- What is known beforehand: one standard deviation ----

inline constexpr base::Parameter<double> kPriorScale{
    "prior_scale", 0.2, "", base::ParameterOrigin::kPhysics,
    "tyres are not farther off, nor is the track as a share of itself"};
inline constexpr base::Parameter<double> kPriorMount_m{
    "prior_mount", 0.5, "m", base::ParameterOrigin::kGeometry,
    "a laser is on the robot"};
inline constexpr base::Parameter<double> kPriorYaw_rad{
    "prior_yaw", 1.0, "rad", base::ParameterOrigin::kGeometry,
    "about where the first look at the motions has it"};
inline constexpr base::Parameter<double> kPriorDelay_s{
    "prior_delay", 0.2, "s", base::ParameterOrigin::kMeasured,
    "drivers are not later"};

// ---- What counts as known afterwards: one standard deviation ----

inline constexpr base::Parameter<double> kKnownScale{
    "known_scale", 0.01, "", base::ParameterOrigin::kTuned,
    "of wheels: what nominal tyres are off anyway"};
inline constexpr base::Parameter<double> kKnownTrack{
    "known_track", 0.02, "", base::ParameterOrigin::kTuned,
    "as a share of the track"};
inline constexpr base::Parameter<double> kKnownMount_m{
    "known_mount", 0.03, "m", base::ParameterOrigin::kTuned,
    "a tape measures better"};
inline constexpr base::Parameter<double> kKnownYaw_rad{
    "known_yaw", 0.01, "rad", base::ParameterOrigin::kTuned,
    "as straight as a laser is screwed on"};
inline constexpr base::Parameter<double> kKnownDelay_s{
    "known_delay", 0.02, "s", base::ParameterOrigin::kTuned,
    "half a scan of a fast laser"};

// ---- Whether a calibration still fits: less does not matter ----

inline constexpr base::Parameter<double> kFitsScale{
    "fits_scale", 0.005, "", base::ParameterOrigin::kTuned,
    "of wheels and track: air in the tyres"};
inline constexpr base::Parameter<double> kFitsMount_m{
    "fits_mount", 0.01, "m", base::ParameterOrigin::kTuned,
    "less is not seen in a map"};
inline constexpr base::Parameter<double> kFitsYaw_rad{
    "fits_yaw", 0.005, "rad", base::ParameterOrigin::kTuned,
    "less is not seen in a map"};
inline constexpr base::Parameter<double> kFitsDelay_s{
    "fits_delay", 0.01, "s", base::ParameterOrigin::kTuned,
    "less is not seen in a map"};
inline constexpr base::Parameter<double> kFitsNoise{
    "fits_noise", 2, "", base::ParameterOrigin::kTuned,
    "times the noise as measured: scans match worse in other rooms, and what "
    "uses it has a margin"};
inline constexpr base::Parameter<double> kFitsSigmas{
    "fits_sigmas", 3, "", base::ParameterOrigin::kTuned,
    "standard deviations that a value may be off"};

// ---- Robustness ----

inline constexpr base::Parameter<double> kCauchySigmas{
    "cauchy_sigmas", 2.5, "", base::ParameterOrigin::kTuned,
    "motions farther off than that count less"};
inline constexpr base::Parameter<double> kOutlierSigmas{
    "outlier_sigmas", 5, "", base::ParameterOrigin::kTuned,
    "motions farther off are wheels that slipped, or wrong matches"};
inline constexpr base::Parameter<int> kBlocks{
    "blocks", 12, "", base::ParameterOrigin::kTuned,
    "of the drive: errors within one may depend on each other"};
inline constexpr base::Parameter<double> kNoiseFloor{
    "noise_floor", 0.005, "", base::ParameterOrigin::kTuned,
    "no odometry is believed to be better, a metre or a radian"};

// All of the above, for --print-config and docs/reference.
std::vector<base::ParameterRow> CalibrationParameters();

}  // namespace treeline::calibration

#endif  // NAV_AGENT_CALIBRATION_PARAMETERS_H_
