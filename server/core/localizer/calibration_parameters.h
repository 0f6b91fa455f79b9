// The tuned constants of the pipeline, see parameters.h, that have to do with
// cameras that are not as they are stated.
#ifndef SERVER_CORE_LOCALIZER_CALIBRATION_PARAMETERS_H_
#define SERVER_CORE_LOCALIZER_CALIBRATION_PARAMETERS_H_

#include "common/base/parameter.h"

namespace treeline::localizer {

// Focal lengths that do not fit.
inline constexpr base::Parameter<double> kMinFocalError{
    .name = "min_focal_error",
    .value = 0.015,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "a stated focal length that is off by less is not corrected"};
inline constexpr base::Parameter<double> kMinFocalSigmas{
    .name = "min_focal_sigmas",
    .value = 4,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "... nor one that may be right, by what the features say: right ones "
        "were up to 1.8 off in near views, 2.5 in 98 of 100 far ones"};
inline constexpr base::Parameter<double> kSureFocalSigmas{
    .name = "sure_focal_sigmas",
    .value = 6,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "that many, or min_focal_sigmas times what the scene is known to state "
        "too much, correct by clear_focal_odds: of 535 held-out views with "
        "right focal lengths 12 were corrected by 4.1 to 5.8, 4 of them "
        "grossly"};
inline constexpr base::Parameter<double> kUnsureFocalOdds{
    .name = "unsure_focal_odds",
    .value = 2,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "fewer correct if the answer's odds become so many times as large: "
        "those of the 12 at most 1.9. Of 161 corrections of one 5 % off (red "
        "kitchen) 151 stay, and all 179 of one 10 % off"};
inline constexpr base::Parameter<double> kDoubtfulPointFocalSigmas{
    .name = "doubtful_point_focal_sigmas",
    .value = 2.5,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "where measured points want another focal length by so many of their "
        "standard deviations, features are looked at, too"};
inline constexpr base::Parameter<double> kMinFusedFocalSigmas{
    .name = "min_fused_focal_sigmas",
    .value = 3,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "as min_focal_sigmas, where features and measured points say so "
        "together; from clear_focal_sigmas on clear_focal_odds do: of 550 "
        "held-out views with right focal lengths 6 were corrected, of which "
        "2 covered ones became wrong, by 6 and 7 cm"};
inline constexpr base::Parameter<double> kMinGuessedFocalSigmas{
    .name = "min_guessed_focal_sigmas",
    .value = 1.5,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "... where another camera than the scene's is stated"};
inline constexpr base::Parameter<double> kClearFocalSigmas{
    .name = "clear_focal_sigmas",
    .value = 5,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "... and where that many want another one, the answer with it may even "
        "be a little worse: an inexact map often fits a wrong focal length"};
inline constexpr base::Parameter<double> kClearFocalOdds{
    .name = "clear_focal_odds",
    .value = 0.4,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "... of so many times the odds: with focal lengths 10 % too short to "
        "15 % too long in halves of fr1/rpy 358 of 450 are right in place of "
        "322, and one that is right loses nothing"};
inline constexpr base::Parameter<double> kSameFocal{
    .name = "same_focal",
    .value = 0.02,
    .unit = "",
    .origin = base::ParameterOrigin::kGeometry,
    .why =
        "a stated focal length that differs by more from that of the camera "
        "that learnt the scene may be a guess, and is looked at with matched "
        "features, too"};
inline constexpr base::Parameter<double> kMaxGuessedOffset{
    .name = "max_guessed_offset",
    .value = 0.05,
    .unit = "",
    .origin = base::ParameterOrigin::kGeometry,
    .why =
        "... unless its principal point is further from the middle, in longer "
        "sides: lenses are mounted within 2 %, guesses are in the middle"};
inline constexpr base::Parameter<int> kMinReducedSide_px{
    .name = "min_reduced_side",
    .value = 90,
    .unit = "px",
    .origin = base::ParameterOrigin::kTuned,
    .why = "a picture is not reduced further for features of the scene's size"};
inline constexpr base::Parameter<int> kMaxFocalRounds{
    .name = "max_focal_rounds",
    .value = 3,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "with a better focal length more features fit, and say it better"};

// Cameras that nobody states, or that are guesses.
inline constexpr base::Parameter<double> kMaxAssumedFocalSigma{
    .name = "max_assumed_focal_sigma",
    .value = 0.0125,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "a camera that nobody stated is answered for if its focal length is "
        "known as well: of 838 held-out views whose camera was assumed 0.7 to "
        "1.4 times as long 750 are, none wrongly; with 0.015 5 of 808"};
inline constexpr base::Parameter<double> kMaxAssumedSigmaScale{
    .name = "max_assumed_sigma_scale",
    .value = 1.5,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "... and in scenes whose features understate that by no more: where "
        "they do 2.2 times, 5 of 34 were wrong; mostly it is 1.0"};
inline constexpr base::Parameter<double> kUsualOffset{
    .name = "usual_lens_offset",
    .value = 0.01,
    .unit = "",
    .origin = base::ParameterOrigin::kPhysics,
    .why =
        "standard deviation of a lens's principal point from the middle of its "
        "whole picture, in longer sides"};
inline constexpr base::Parameter<double> kUsualRadial{
    .name = "usual_lens_radial",
    .value = 0.02,
    .unit = "",
    .origin = base::ParameterOrigin::kPhysics,
    .why = "the same of k1: phones straighten their pictures"};
inline constexpr base::Parameter<double> kAnyOffset{
    .name = "any_lens_offset",
    .value = 0.15,
    .unit = "",
    .origin = base::ParameterOrigin::kGeometry,
    .why =
        "the same of pictures that somebody has cut from larger ones: half of "
        "one side was cut off of half of them"};
inline constexpr base::Parameter<double> kAnyRadial{
    .name = "any_lens_radial",
    .value = 0.15,
    .unit = "",
    .origin = base::ParameterOrigin::kPhysics,
    .why = "the same of webcams' k1"};
inline constexpr base::Parameter<double> kUsualLensOdds{
    .name = "usual_lens_odds",
    .value = 10,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "of ten pictures without a camera one is a part of another, or bent"};
inline constexpr base::Parameter<double> kMinUsualLensOdds{
    .name = "min_usual_lens_odds",
    .value = 30,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "a usual lens on a whole picture needs them"};
inline constexpr base::Parameter<double> kMinGuessedLensOdds{
    .name = "min_guessed_lens_odds",
    .value = 10,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "... and one that may be a guess these, the odds before anything was "
        "seen: features do not speak against it"};
inline constexpr base::Parameter<int> kMaxLensRounds{
    .name = "max_lens_rounds",
    .value = 2,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "with the lens that was found more features agree"};
inline constexpr base::Parameter<double> kMaxLensSigma{
    .name = "max_lens_sigma",
    .value = 0.5,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "such pictures are answered for if their position is known to this "
        "part of max_position_sigma, the camera's doubt included"};

// Depth of another scale.
inline constexpr base::Parameter<double> kSuspectDepthScale{
    .name = "suspect_depth_scale",
    .value = 0.005,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "if an aligned pose wants depth scaled by more, the scale is measured: "
        "0.004 at most where it was right (420 views that were held out), "
        "0.006 to 0.013 where it was 2 % off"};
inline constexpr base::Parameter<double> kSureDepthAgreement{
    .name = "sure_depth_agreement",
    .value = 0.94,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "... or if less of its depth agrees: 0.94 and more in 418 of the 420, "
        "0.77 to 0.91 where a wrong pose explained depth that was 7 % off"};
inline constexpr base::Parameter<double> kSureAgreement{
    .name = "sure_agreement",
    .value = 0.68,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "... and less of its brightness: 0.59 to 0.67 there; of a noisy "
        "sensor only depth disagrees"};
inline constexpr base::Parameter<double> kMinDepthScaleError{
    .name = "min_depth_scale_error",
    .value = 0.0075,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "a scale that is off by less is not corrected: right ones were 0.012 "
        "off at most"};
inline constexpr base::Parameter<double> kMinDepthScaleSigmas{
    .name = "min_depth_scale_sigmas",
    .value = 1.5,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "... nor one that may be right, by how well it is known"};
inline constexpr base::Parameter<double> kMinScaleAgreement{
    .name = "min_scale_agreement",
    .value = 0.7,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "one scale must put this share of the measured points on the scene's "
        "surfaces: 0.83 and more where the pose was right"};
inline constexpr base::Parameter<double> kMaxKnownFocalSigma{
    .name = "max_known_focal_sigma",
    .value = 0.01,
    .unit = "",
    .origin = base::ParameterOrigin::kGeometry,
    .why =
        "a focal length that may be a guess has to be known as well before "
        "depth is doubted: errors of either look alike"};
inline constexpr base::Parameter<int> kMaxDepthRounds{
    .name = "max_depth_rounds",
    .value = 3,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "a pose that is nearer says the scale better"};

// Cameras that turn while their rows are read.
inline constexpr base::Parameter<size_t> kTurnKeyframes{
    .name = "turn_keyframes",
    .value = 4,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "matched to see how the camera turned, as many as for a pose"};
inline constexpr base::Parameter<double> kTurnInlier_px{
    .name = "turn_inlier",
    .value = 8,
    .unit = "px",
    .origin = base::ParameterOrigin::kTuned,
    .why = "points that reproject within it, row by row, support a turn"};
inline constexpr base::Parameter<double> kTurnPriorSigma_rad_s{
    .name = "turn_prior_sigma",
    .value = 0.7,
    .unit = "rad/s",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "of each axis; half of what a camera does that is swung to and fro, as "
        "turns are poorly told from moves"};
inline constexpr base::Parameter<int> kMinTurnMatches{
    .name = "min_turn_matches",
    .value = 25,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "with fewer matches that agree a turn explains anything"};
inline constexpr base::Parameter<double> kMinTurnSigmas{
    .name = "min_turn_sigmas",
    .value = 3,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "a turn so far from none, over its three axes, is undone"};
inline constexpr base::Parameter<double> kMinTurnedRows_px{
    .name = "min_turned_rows",
    .value = 1,
    .unit = "px",
    .origin = base::ParameterOrigin::kTuned,
    .why = "a turn that moves the first and last row by less stays"};

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_CALIBRATION_PARAMETERS_H_
