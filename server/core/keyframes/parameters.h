// The tuned constants of keyframes: which are chosen, how poses are aligned
// with them, and how features are matched. Where the origin is "tuned", it was
// on held-out blocks of training frames.
#ifndef SERVER_CORE_KEYFRAMES_PARAMETERS_H_
#define SERVER_CORE_KEYFRAMES_PARAMETERS_H_

#include <cstddef>
#include <vector>

#include "common/base/parameter.h"

namespace treeline::keyframes {

// Choosing keyframes.
inline constexpr base::Parameter<double> kViewDistance_m{
    .name = "view_distance",
    .value = 1.5,
    .unit = "m",
    .origin = base::ParameterOrigin::kGeometry,
    .why =
        "roughly how far away what a camera sees is: a turn by one "
        "radian moves it as much as a step of this length"};
inline constexpr base::Parameter<size_t> kCoarsePoints{
    .name = "coarse_points",
    .value = 64,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "points of a keyframe that decide whether it is chosen"};
inline constexpr base::Parameter<double> kSameView_m{
    .name = "same_view",
    .value = 0.25,
    .unit = "m",
    .origin = base::ParameterOrigin::kTuned,
    .why = "from this far away, turns included, a keyframe counts half"};

// Alignment.
inline constexpr base::Parameter<double> kMinPointDepth_m{
    .name = "min_point_depth",
    .value = 0.05,
    .unit = "m",
    .origin = base::ParameterOrigin::kGeometry,
    .why = "points nearer than this are not in front of the camera"};
inline constexpr base::Parameter<float> kMinFacing{
    .name = "min_facing",
    .value = 0.15F,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "cosine of the angle of view to a normal: surfaces seen "
        "more grazingly hide what lies behind"};
inline constexpr base::Parameter<int> kMinVisible{
    .name = "min_visible",
    .value = 60,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "with fewer visible points there is no alignment"};
inline constexpr base::Parameter<double> kMinBrightnessNoise{
    .name = "min_brightness_noise",
    .value = 3,
    .unit = "grey level",
    .origin = base::ParameterOrigin::kTuned,
    .why = "noise of the brightness is taken to be no less"};
inline constexpr base::Parameter<double> kMaxBrightnessNoise{
    .name = "max_brightness_noise",
    .value = 25,
    .unit = "grey level",
    .origin = base::ParameterOrigin::kTuned,
    .why = "... and no more; what alignment starts with"};
inline constexpr base::Parameter<float> kAgreeingBrightness{
    .name = "agreeing_brightness",
    .value = 15,
    .unit = "grey level",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "points whose brightness differs by no more agree with the "
        "frame"};
inline constexpr base::Parameter<int> kExposureCells{
    .name = "exposure_cells",
    .value = 4,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "parts of a picture's width and height that the exposure is first "
        "fitted to: something in front covers some of them"};
inline constexpr base::Parameter<float> kMinExposurePoints{
    .name = "min_exposure_points",
    .value = 8,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "keyframe points that such a part needs"};
inline constexpr base::Parameter<float> kMinExposureCorrelation{
    .name = "min_exposure_correlation",
    .value = 0.5F,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "... of their brightness with the picture's"};
inline constexpr base::Parameter<float> kMinUnevenness{
    .name = "min_unevenness",
    .value = 0.15F,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "of light that is evened, its logarithm's standard deviation over "
        "the picture; a lamp of one stop on one side has 0.2 to 0.4"};
inline constexpr base::Parameter<int> kCellColumns{
    .name = "cell_columns",
    .value = 8,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "cells of a picture's width in which it may look like something else"};
inline constexpr base::Parameter<int> kCellRows{
    .name = "cell_rows",
    .value = 6,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "... and of its height"};
inline constexpr base::Parameter<float> kMinCellPoints{
    .name = "min_cell_points",
    .value = 8,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "keyframe points that such a cell needs"};
inline constexpr base::Parameter<float> kMinCellAgreement{
    .name = "min_cell_agreement",
    .value = 0.5F,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "it looks like something else if fewer of them agree"};
inline constexpr base::Parameter<float> kMinCellCorrelation{
    .name = "min_cell_correlation",
    .value = 0.3F,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "... and their brightness goes less with what is expected; another "
        "light changes how many agree alone"};
inline constexpr base::Parameter<float> kMaxGain{
    .name = "max_gain",
    .value = 5,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "a frame is at most so many times as bright as a keyframe, or "
        "as dim"};
inline constexpr base::Parameter<double> kCorrelatedPoints{
    .name = "correlated_points",
    .value = 64,
    .unit = "",
    .origin = base::ParameterOrigin::kMeasured,
    .why =
        "neighbouring points' errors go together: the covariance is "
        "widened by this, to the size of errors on frames held out "
        "of training"};
inline constexpr base::Parameter<double> kSurfaceNoise_m{
    .name = "surface_noise",
    .value = 0.01,
    .unit = "m",
    .origin = base::ParameterOrigin::kTuned,
    .why = "noise of a measured surface beside the sensor's own"};
inline constexpr base::Parameter<float> kMaxSurfaceDistance_m{
    .name = "max_surface_distance",
    .value = 0.15F,
    .unit = "m",
    .origin = base::ParameterOrigin::kTuned,
    .why = "further away is no longer the same surface"};
inline constexpr base::Parameter<int> kSurfaceLevel{
    .name = "surface_level",
    .value = 1,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "pyramid levels from this one down use measured surfaces"};

// The scale of depth.
inline constexpr base::Parameter<int> kMinScalePoints{
    .name = "min_scale_points",
    .value = 40,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "of fewer measured points nothing is said of the scale of depth"};
inline constexpr base::Parameter<double> kMinScaleFacing{
    .name = "min_scale_facing",
    .value = 0.2,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "surfaces at a flatter angle to the line of sight (its cosine) say "
        "more of the pixel than of the depth"};
inline constexpr base::Parameter<double> kMaxLogDepthScale{
    .name = "max_log_depth_scale",
    .value = 0.12,
    .unit = "",
    .origin = base::ParameterOrigin::kGeometry,
    .why =
        "sensors are off by up to 5 %, and with twice that a unit is another "
        "one"};
inline constexpr base::Parameter<int> kScaleIterations{
    .name = "scale_iterations",
    .value = 8,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "Gauss-Newton steps over pose and scale of depth"};
inline constexpr base::Parameter<double> kInitialScaleWidth{
    .name = "initial_scale_width",
    .value = 4,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "times the robust loss's scale at the first of them, which the "
        "middle of all ratios begins"};
inline constexpr base::Parameter<double> kScaleAgreement{
    .name = "scale_agreement",
    .value = 3,
    .unit = "",
    .origin = base::ParameterOrigin::kGeometry,
    .why =
        "scaled points within so many standard deviations lie on their "
        "surfaces"};

// Features.
inline constexpr base::Parameter<int> kHalvedSide_px{
    .name = "halved_side",
    .value = 512,
    .unit = "px",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "images of this side or more are searched for features in "
        "half their size"};
inline constexpr base::Parameter<double> kSiftContrast{
    .name = "sift_contrast",
    .value = 0.02,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "least contrast of Lowe's features, as SiftOptions has it"};
inline constexpr base::Parameter<int> kMaxFastFeatures{
    .name = "max_fast_features",
    .value = 800,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "features that FastSift keeps of an image"};
inline constexpr base::Parameter<size_t> kCoarseFrameFeatures{
    .name = "coarse_frame_features",
    .value = 120,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "features of a frame that are matched with all keyframes, "
        "..."};
inline constexpr base::Parameter<size_t> kCoarseKeyframeFeatures{
    .name = "coarse_keyframe_features",
    .value = 150,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "... of which so many of each are looked at"};
inline constexpr base::Parameter<size_t> kShortlist{
    .name = "shortlist",
    .value = 32,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "keyframes with most matches that are compared more closely"};
inline constexpr base::Parameter<size_t> kFrameFeatures{
    .name = "frame_features",
    .value = 300,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "features of a frame that are matched with those, ..."};
inline constexpr base::Parameter<int> kMaxKeyframeFeatures{
    .name = "max_keyframe_features",
    .value = 500,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "... of which so many of each are looked at: all that a "
        "model keeps"};
inline constexpr base::Parameter<size_t> kMinSharedFeatures{
    .name = "min_shared_features",
    .value = 6,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "keyframes are alike from so many matches on"};

// The index of keyframes.
inline constexpr base::Parameter<size_t> kIndexedFeatures{
    .name = "indexed_features",
    .value = 300,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "features of a keyframe that vote for it"};
inline constexpr base::Parameter<size_t> kIndexQueries{
    .name = "index_queries",
    .value = 200,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "features of a frame that ask for votes"};
inline constexpr base::Parameter<double> kElsewhere_m{
    .name = "elsewhere",
    .value = 1.5,
    .unit = "m",
    .origin = base::ParameterOrigin::kTuned,
    .why = "features further apart are of other things"};
inline constexpr base::Parameter<double> kMaxDistinctRatio{
    .name = "max_distinct_ratio",
    .value = 0.8,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "a match is distinct if what is most like it elsewhere is further by "
        "more than this ratio (Lowe 2004)"};
inline constexpr base::Parameter<double> kFeaturesPerWord{
    .name = "features_per_word",
    .value = 40,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "about as many features of keyframes have the same word, ..."};
inline constexpr base::Parameter<size_t> kMaxKinds{
    .name = "max_kinds",
    .value = 32,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "... as long as that makes no more kinds than this, each of as many "
        "words"};
inline constexpr base::Parameter<size_t> kWordSamples{
    .name = "word_samples",
    .value = 8192,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "features that words are learnt from"};
inline constexpr base::Parameter<int> kWordRounds{
    .name = "word_rounds",
    .value = 5,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "of k-means"};
inline constexpr base::Parameter<int> kMaxDifferentBits{
    .name = "max_different_bits",
    .value = 20,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "features of a word whose signatures differ in more of 64 bits are not "
        "alike"};
inline constexpr base::Parameter<float> kDifferentBits{
    .name = "different_bits",
    .value = 12,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "bits that take a vote to 1 / e"};

// Predicted coverage. Origin "tuned": on training frames of Red Kitchen, a room
// and a cafe that were not trained on (docs/research/coverage.md).
inline constexpr base::Parameter<size_t> kSupportPoints{
    .name = "support_points",
    .value = 64,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "points of a keyframe that a prediction looks at: 200 predict no "
        "better"};
inline constexpr base::Parameter<size_t> kSupportRows{
    .name = "support_rows",
    .value = 24,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "directions of a panorama from up to down, and twice as many around: "
        "5 to 10 degrees predict alike"};
inline constexpr base::Parameter<float> kSupportAngle_rad{
    .name = "support_angle",
    .value = 0.35F,
    .unit = "rad",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "standard deviation of the angle from which a keyframe's point still "
        "supports a camera: 15 to 30 degrees predict alike"};
inline constexpr base::Parameter<float> kSupportRatio{
    .name = "support_ratio",
    .value = 3,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "so many times nearer or further is one standard deviation: 2 "
        "predicts a little worse, 7 alike"};
inline constexpr base::Parameter<float> kFullSupport{
    .name = "full_support",
    .value = 2,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "points, from the same place, that are enough for a direction"};
inline constexpr base::Parameter<float> kHiddenBehind{
    .name = "hidden_behind",
    .value = 0.2F,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "what is this much further away than the nearest point of its "
        "direction is hidden, ..."};
inline constexpr base::Parameter<float> kHiddenBehind_m{
    .name = "hidden_behind_distance",
    .value = 0.1F,
    .unit = "m",
    .origin = base::ParameterOrigin::kTuned,
    .why = "... and this much beside; without both, cafe is predicted worse"};
inline constexpr base::Parameter<double> kGoodSupport{
    .name = "good_support",
    .value = 0.35,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "from this mean over a picture on, more than 9 of 10 queries were "
        "answered right"};
inline constexpr base::Parameter<double> kWeakSupport{
    .name = "weak_support",
    .value = 0.1,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "below this one, 1 of 20"};
inline constexpr base::Parameter<double> kPlaceHeight_m{
    .name = "place_height",
    .value = 0.5,
    .unit = "m",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "lines of sight at most this much above or below a place show that "
        "it is open"};
inline constexpr base::Parameter<size_t> kSightLines{
    .name = "sight_lines",
    .value = 300,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "of a keyframe, that are looked at"};
inline constexpr base::Parameter<int> kMinSightLines{
    .name = "min_sight_lines",
    .value = 5,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "... if there are so many"};
inline constexpr base::Parameter<double> kCameraReach_m{
    .name = "camera_reach",
    .value = 1,
    .unit = "m",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "places this near to a training camera are open, too: it was carried, "
        "and nobody looks behind it"};
inline constexpr base::Parameter<double> kSurfaceMargin_m{
    .name = "surface_margin",
    .value = 0.2,
    .unit = "m",
    .origin = base::ParameterOrigin::kGeometry,
    .why = "a camera is no nearer to what a line of sight ends at"};
inline constexpr base::Parameter<double> kOutlinePart{
    .name = "outline_part",
    .value = 0.005,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "of the points, on each side, that may lie outside the plan"};
inline constexpr base::Parameter<double> kGroundPart{
    .name = "ground_part",
    .value = 0.02,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "of the points, that lie below the ground by error"};

// Which way is up.
inline constexpr base::Parameter<double> kMaxUpError_rad{
    .name = "max_up_error",
    .value = 0.6,
    .unit = "rad",
    .origin = base::ParameterOrigin::kGeometry,
    .why = "by how much cameras that look down may lean all the same way"};
inline constexpr base::Parameter<double> kMinUpError_rad{
    .name = "min_up_error",
    .value = 0.1,
    .unit = "rad",
    .origin = base::ParameterOrigin::kMeasured,
    .why = "scatter of keyframes' normals on a floor"};
inline constexpr base::Parameter<double> kAxisError_rad{
    .name = "axis_error",
    .value = 0.05,
    .unit = "rad",
    .origin = base::ParameterOrigin::kTuned,
    .why = "an axis of the world this close to up is up"};
inline constexpr base::Parameter<double> kMinWallNormal{
    .name = "min_wall_normal",
    .value = 0.95,
    .unit = "",
    .origin = base::ParameterOrigin::kGeometry,
    .why = "level part of a wall's normal"};

// All of them, in this order.
std::vector<base::ParameterRow> KeyframeParameters();

}  // namespace treeline::keyframes

#endif  // SERVER_CORE_KEYFRAMES_PARAMETERS_H_
