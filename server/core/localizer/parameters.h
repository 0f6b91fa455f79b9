// The tuned constants of the pipeline. Where the origin is "tuned", it was on
// held-out blocks of training frames. What a caller may choose stands in
// QueryOptions.
#ifndef SERVER_CORE_LOCALIZER_PARAMETERS_H_
#define SERVER_CORE_LOCALIZER_PARAMETERS_H_

#include <numbers>
#include <vector>

#include "common/base/parameter.h"
#include "server/core/localizer/calibration_parameters.h"

namespace treeline::localizer {

// Forests on pixel differences.
inline constexpr base::Parameter<double> kPriorSigma_m{
    .name = "prior_sigma",
    .value = 0.02,
    .unit = "m",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "spread that leaves of few samples, which say little of "
        "their own, are averaged with"};
inline constexpr base::Parameter<double> kPriorSamples{
    .name = "prior_samples",
    .value = 4,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "... as if it came from so many samples"};
inline constexpr base::Parameter<int> kMinForestSamples{
    .name = "min_forest_samples",
    .value = 30,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "with fewer samples nothing can be said"};
inline constexpr base::Parameter<double> kForestRansacInlier_px{
    .name = "forest_ransac_inlier",
    .value = 12,
    .unit = "px",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "leaves of a forest are some centimetres wide: 12 px are 5 "
        "cm at 2 m"};
inline constexpr base::Parameter<double> kForestRobustScale_px{
    .name = "forest_robust_scale",
    .value = 6,
    .unit = "px",
    .origin = base::ParameterOrigin::kTuned,
    .why = "the last scale of the robust loss"};
inline constexpr base::Parameter<double> kForestInlier_px{
    .name = "forest_inlier",
    .value = 10,
    .unit = "px",
    .origin = base::ParameterOrigin::kTuned,
    .why = "predictions that reproject within it support a pose"};
inline constexpr base::Parameter<double> kPointLineModelSigma_m{
    .name = "point_line_model_sigma",
    .value = 0.005,
    .unit = "m",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "points on lines stand on edges, and are nearer to what "
        "leaves say of them than others"};
inline constexpr base::Parameter<int> kPointLineHypothesisIterations{
    .name = "point_line_hypothesis_iterations",
    .value = 2,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "steps of Levenberg-Marquardt for a hypothesis of RANSAC"};

// Features of keyframes.
inline constexpr base::Parameter<int> kMatchedKeyframes{
    .name = "matched_keyframes",
    .value = 3,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "keyframes that a frame is matched with by method hybrid"};
inline constexpr base::Parameter<int> kMatchedLikeKeyframes{
    .name = "matched_like_keyframes",
    .value = 4,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "... and by method universal: far views share little with each"};
inline constexpr base::Parameter<int> kMaxQueryFeatures{
    .name = "max_query_features",
    .value = 1000,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "Lowe's features taken from a frame for it, the largest"};
inline constexpr base::Parameter<int> kMaxFastQueryFeatures{
    .name = "max_fast_query_features",
    .value = 500,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "FastSift's: twice as many find no more far views, in twice the time"};
inline constexpr base::Parameter<double> kMaxKeyframeRatio{
    .name = "max_keyframe_ratio",
    .value = 0.85,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "Lowe's ratio, for matches that are each other's nearest"};
inline constexpr base::Parameter<double> kMaxPriorKeyframeDistance_m{
    .name = "max_prior_keyframe_distance",
    .value = 1,
    .unit = "m",
    .origin = base::ParameterOrigin::kGeometry,
    .why =
        "keyframes so near to where the camera is expected see what it sees: "
        "half of what is 2 m away"};
inline constexpr base::Parameter<int> kMinKeyframeMatches{
    .name = "min_keyframe_matches",
    .value = 8,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "with fewer matches there is nothing to say"};
inline constexpr base::Parameter<int> kMinKeyframeInliers{
    .name = "min_keyframe_inliers",
    .value = 10,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "a pose that fewer matches support is not proposed: of pictures of "
        "other places up to 7 agree by chance, of mirrored ones up to 14"};
inline constexpr base::Parameter<double> kKeypointSigma_px{
    .name = "keypoint_sigma",
    .value = 1,
    .unit = "px",
    .origin = base::ParameterOrigin::kTuned,
    .why = "of a SIFT keypoint in the frame"};
inline constexpr base::Parameter<double> kKeyframePointSigma_m{
    .name = "keyframe_point_sigma",
    .value = 0.01,
    .unit = "m",
    .origin = base::ParameterOrigin::kTuned,
    .why = "of a keyframe's point: its pose and its depth"};
inline constexpr base::Parameter<double> kKeyframeRansacInlier_px{
    .name = "keyframe_ransac_inlier",
    .value = 8,
    .unit = "px",
    .origin = base::ParameterOrigin::kTuned,
    .why = "keyframes' points are exact to about a centimetre"};
inline constexpr base::Parameter<size_t> kDistinctMatches{
    .name = "distinct_matches",
    .value = 96,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "of so many of the features that support a pose it is asked whether "
        "they are found elsewhere: their share is known to a twentieth"};
inline constexpr base::Parameter<double> kKeyframeRobustScale_px{
    .name = "keyframe_robust_scale",
    .value = 3,
    .unit = "px",
    .origin = base::ParameterOrigin::kTuned,
    .why = "the last scale of the robust loss"};
inline constexpr base::Parameter<double> kKeyframeInlier_px{
    .name = "keyframe_inlier",
    .value = 6,
    .unit = "px",
    .origin = base::ParameterOrigin::kTuned,
    .why = "points that reproject within it support a pose"};

// Forests on SIFT descriptors.
inline constexpr base::Parameter<double> kMaxSiftRatio{
    .name = "max_sift_ratio",
    .value = 0.85,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "Lowe's ratio, against the best mode elsewhere in the scene"};
inline constexpr base::Parameter<double> kSameSiftPlace{
    .name = "same_sift_place",
    .value = 0.02,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "elsewhere is further than so many viewing distances"};
inline constexpr base::Parameter<int> kMinSiftMatches{
    .name = "min_sift_matches",
    .value = 8,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "with fewer matches there is nothing to say"};
inline constexpr base::Parameter<size_t> kFirstSiftShare{
    .name = "first_sift_share",
    .value = 4,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "the forest is asked about one feature in so many first"};
inline constexpr base::Parameter<int> kFirstSiftLeaves{
    .name = "first_sift_leaves",
    .value = 2,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "... which visits so many leaves of each tree"};
inline constexpr base::Parameter<int> kCertainSiftInliers{
    .name = "certain_sift_inliers",
    .value = 30,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "of those: their pose guides the others; wrong ones have up to 11"};
inline constexpr base::Parameter<int> kSiftGuides{
    .name = "sift_guides",
    .value = 2,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "times that the others are looked for by the pose so far; a third "
        "time finds the same"};
inline constexpr base::Parameter<int> kMaxGuidedSiftDistance{
    .name = "max_guided_sift_distance",
    .value = 200,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "between the descriptors of a feature and of a place that a pose "
        "shows there; 99.6 % of those that the forest finds are nearer"};
inline constexpr base::Parameter<double> kSiftRansacInlier_px{
    .name = "sift_ransac_inlier",
    .value = 6,
    .unit = "px",
    .origin = base::ParameterOrigin::kTuned,
    .why = "points of a structure from motion are exact"};
inline constexpr base::Parameter<double> kSiftRobustScale_px{
    .name = "sift_robust_scale",
    .value = 4,
    .unit = "px",
    .origin = base::ParameterOrigin::kTuned,
    .why = "the last scale of the robust loss"};
inline constexpr base::Parameter<double> kSiftInlier_px{
    .name = "sift_inlier",
    .value = 4,
    .unit = "px",
    .origin = base::ParameterOrigin::kTuned,
    .why = "points that reproject within it support a pose"};

// Verification.
inline constexpr base::Parameter<double> kSufficientConfidence{
    .name = "sufficient_confidence",
    .value = 0.97,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "a pose as sure as this needs no dearer generator; at 0.9 the forest "
        "of a building with patterned walls was believed a pattern away"};
inline constexpr base::Parameter<double> kSufficientSigma_m{
    .name = "sufficient_sigma",
    .value = 0.0075,
    .unit = "m",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "... if it is as well determined; 6.6 mm at most of whole pictures "
        "with "
        "depth, 10 to 23 of narrow ones that were wrong"};
inline constexpr base::Parameter<double> kMinEvenedAgreement{
    .name = "min_evened_agreement",
    .value = 1.25,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "so many times as much of the picture agrees once its light is "
        "evened: 1.5 to 2.5 by a lamp of one stop, at most 1.2 otherwise"};
inline constexpr base::Parameter<int> kSufficientMatches{
    .name = "sufficient_matches",
    .value = 25,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "... and, of features, supported by so many: of those with fewer 3 of "
        "37 were wrong, 2 grossly. As many may doubt a focal length that is "
        "no guess"};
inline constexpr base::Parameter<double> kMaxFirmSigma_m{
    .name = "max_firm_sigma",
    .value = 0.02,
    .unit = "m",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "as many features that determine a position so well are right where "
        "alignment takes it elsewhere; from 0.0125 to 0.03 as good"};
inline constexpr base::Parameter<double> kDrawnAwaySigmas{
    .name = "drawn_away_sigmas",
    .value = 3,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "... by so many standard deviations: of 150 such answers 6 were wrong, "
        "of the features' own poses 1; 2 to 4 are as good"};
inline constexpr base::Parameter<int> kMinAnswerInliers{
    .name = "min_answer_inliers",
    .value = 15,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "fewer of a forest's samples are no answer, whatever else speaks for "
        "it"};
inline constexpr base::Parameter<double> kMinKeyframeOverlap{
    .name = "min_keyframe_overlap",
    .value = 0.1,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "with less overlap with keyframes the forest knows the pose "
        "better"};
inline constexpr base::Parameter<int> kMinMeasuredPoints{
    .name = "min_measured_points",
    .value = 20,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "fewer keyframe points with depth refute no pose"};
inline constexpr base::Parameter<double> kMinDepthAgreement{
    .name = "min_depth_agreement",
    .value = 0.25,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "if depth agrees with fewer of the points whose brightness does, it "
        "refutes the pose: 3 of 775 right poses, 272 of 292 with another "
        "frame's depth (six scenes)"};
inline constexpr base::Parameter<double> kSharedErrors{
    .name = "shared_errors",
    .value = std::numbers::sqrt2,
    .unit = "",
    .origin = base::ParameterOrigin::kGeometry,
    .why =
        "a pose fused of a candidate and its alignment is off by so many times "
        "what two that know nothing of each other say: they have the map's "
        "errors in common, and two that have all in common know no more than "
        "one"};
inline constexpr base::Parameter<double> kForestErrors{
    .name = "forest_errors",
    .value = 2,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "... and by so many times more where the candidate is a forest's: "
        "samples that stand together err together"};
inline constexpr base::Parameter<double> kApart_m{
    .name = "apart",
    .value = 0.05,
    .unit = "m",
    .origin = base::ParameterOrigin::kGeometry,
    .why =
        "of two poses further from each other at most one is right, by the "
        "bounds that confidence is about, ..."};
inline constexpr base::Parameter<double> kApart_rad{
    .name = "apart_angle",
    .value = 0.0873,
    .unit = "rad",
    .origin = base::ParameterOrigin::kGeometry,
    .why = "... or of two that are turned against each other by more"};
inline constexpr base::Parameter<int> kMaxAlignedKeyframes{
    .name = "max_aligned_keyframes",
    .value = 5,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "three are aligned with, and of narrower views than the scene's camera "
        "has as many more as they are narrower; 6 and 10 do no more for a "
        "quarter of the picture"};
inline constexpr base::Parameter<double> kMaxPositionSigma_m{
    .name = "max_position_sigma",
    .value = 0.05,
    .unit = "m",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "the inliers determine the position as well as an answer "
        "must be"};
inline constexpr base::Parameter<int> kMinSiftInliers{
    .name = "min_sift_inliers",
    .value = 12,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "an answer of method sift needs them at so many places"};
inline constexpr base::Parameter<double> kSameSiftPixel{
    .name = "same_sift_pixel",
    .value = 0.008,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "features less than so many longer sides of the picture apart see one "
        "place: right or wrong, they are so together"};
inline constexpr base::Parameter<int> kEnoughSiftPlaces{
    .name = "enough_sift_places",
    .value = 100,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "more are not counted: confidence is the same"};
inline constexpr base::Parameter<int> kFewMatches{
    .name = "few_matches",
    .value = 30,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "added to the matches that a share of inliers is taken of: "
        "a share of few means little"};
inline constexpr base::Parameter<double> kMaxRelativePositionSigma{
    .name = "max_relative_position_sigma",
    .value = 0.05,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "as max_position_sigma, in viewing distances"};

// Turned pictures.
inline constexpr base::Parameter<double> kOtherTurnOdds{
    .name = "other_turn_odds",
    .value = 10,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "few pictures are turned without a word, and each has three chances "
        "more; there wrong poses of held-out training frames and of foreign "
        "ones had odds of up to 2 in 235 trials, right ones from 260 on"};

// All of them, in this order.
std::vector<base::ParameterRow> LocalizerParameters();

}  // namespace treeline::localizer

#endif  // SERVER_CORE_LOCALIZER_PARAMETERS_H_
