// The tuned constants of sampling, of line segments and of FastSift. What a
// caller may choose stands in the functions' options. Constants of file formats
// and of trained models stay where they are used: other values need other
// models.
#ifndef SERVER_CORE_FEATURES_PARAMETERS_H_
#define SERVER_CORE_FEATURES_PARAMETERS_H_

#include <cstddef>
#include <vector>

#include "common/base/parameter.h"

namespace treeline::features {

// Depth.
inline constexpr base::Parameter<double> kMinDepth_m{
    .name = "min_depth",
    .value = 0.2,
    .unit = "m",
    .origin = base::ParameterOrigin::kPhysics,
    .why = "nearer than any structured-light camera measures"};
inline constexpr base::Parameter<double> kMaxDepth_m{
    .name = "max_depth",
    .value = 10,
    .unit = "m",
    .origin = base::ParameterOrigin::kPhysics,
    .why = "the noise of a structured-light camera is 0.2 m there"};
inline constexpr base::Parameter<int> kMaxDrawsPerSample{
    .name = "max_draws_per_sample",
    .value = 8,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "a frame with less depth than one pixel in so many gives "
        "fewer samples"};

// Line segments.
inline constexpr base::Parameter<double> kLsdScale{
    .name = "lsd_scale",
    .value = 0.8,
    .unit = "",
    .origin = base::ParameterOrigin::kPhysics,
    .why =
        "LSD's usual downscaling, against the staircase of edges "
        "(IPOL 2012)"};
inline constexpr base::Parameter<int> kMinLsdSide_px{
    .name = "min_lsd_side",
    .value = 8,
    .unit = "px",
    .origin = base::ParameterOrigin::kPhysics,
    .why = "LSD's regions need a few pixels"};
inline constexpr base::Parameter<int> kDepthRadius_px{
    .name = "depth_radius",
    .value = 2,
    .unit = "px",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "depth at an edge is looked up in a window of this radius, "
        "..."};
inline constexpr base::Parameter<double> kMaxSurfaceGap{
    .name = "max_surface_gap",
    .value = 0.03,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "... and of what is measured there, what lies within this "
        "share behind the nearest belongs to its surface"};
inline constexpr base::Parameter<double> kFirstDepth_m{
    .name = "first_depth",
    .value = 2,
    .unit = "m",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "where the search for the depth pixel that a colour pixel "
        "sees starts"};
inline constexpr base::Parameter<int> kDepthLookups{
    .name = "depth_lookups",
    .value = 5,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "its iterations"};
inline constexpr base::Parameter<double> kMaxDepthMiss_px{
    .name = "max_depth_miss",
    .value = 2,
    .unit = "px",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "a depth pixel is the right one if its point is seen this "
        "close"};
inline constexpr base::Parameter<int> kLineHypotheses{
    .name = "line_hypotheses",
    .value = 24,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "pairs of points that a line is tried through"};
inline constexpr base::Parameter<double> kMaxLineDeviation{
    .name = "max_line_deviation",
    .value = 3,
    .unit = "",
    .origin = base::ParameterOrigin::kGeometry,
    .why =
        "points lie on a line within so many standard deviations of "
        "their depth"};
inline constexpr base::Parameter<int> kLineFitRounds{
    .name = "line_fit_rounds",
    .value = 2,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "rounds of least squares on the points that lie on it"};

// Features of FastSift. What was tuned was so on pictures of training frames,
// changed in light, noise, blur, turn and size.
inline constexpr base::Parameter<int> kMaxPixels{
    .name = "max_pixels",
    .value = 120000,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "pictures are reduced until they have no more: 640 x 480 to a half"};
inline constexpr base::Parameter<int> kMinOctaveSide_px{
    .name = "min_octave_side",
    .value = 24,
    .unit = "px",
    .origin = base::ParameterOrigin::kGeometry,
    .why = "in a smaller octave no patch has room"};
inline constexpr base::Parameter<float> kBaseBlur_px{
    .name = "base_blur",
    .value = 0.8F,
    .unit = "px",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "of the finest level: with less, sampling moves features; with more, "
        "there are fewer, ..."};
inline constexpr base::Parameter<float> kPictureBlur_px{
    .name = "picture_blur",
    .value = 0.4F,
    .unit = "px",
    .origin = base::ParameterOrigin::kTuned,
    .why = "... and what a reduced picture has of itself"};
inline constexpr base::Parameter<float> kKernelReach{
    .name = "kernel_reach",
    .value = 3,
    .unit = "",
    .origin = base::ParameterOrigin::kGeometry,
    .why = "standard deviations at which a Gaussian is cut off"};
inline constexpr base::Parameter<int> kExtremumBorder_px{
    .name = "extremum_border",
    .value = 5,
    .unit = "px",
    .origin = base::ParameterOrigin::kGeometry,
    .why = "extrema keep so far from the border of an octave"};
inline constexpr base::Parameter<float> kMoveBeyond_px{
    .name = "move_beyond",
    .value = 0.6F,
    .unit = "px",
    .origin = base::ParameterOrigin::kGeometry,
    .why =
        "an extremum this far from its pixel is sought from the next one; "
        "with a half, it may go back and forth"};
inline constexpr base::Parameter<int> kMaxMoves{
    .name = "max_moves",
    .value = 5,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "pixels that the search for an extremum may move on (Lowe 2004)"};
inline constexpr base::Parameter<float> kMaxCurvatureRatio{
    .name = "max_curvature_ratio",
    .value = 20,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "more is an edge; Lowe has 10, which leaves too few"};
inline constexpr base::Parameter<float> kMinContrast{
    .name = "min_contrast",
    .value = 0.1F,
    .unit = "grey level",
    .origin = base::ParameterOrigin::kPhysics,
    .why = "the rounding of a picture to bytes makes such differences"};
inline constexpr base::Parameter<float> kRelativeContrast{
    .name = "relative_contrast",
    .value = 0.1F,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "of the mean difference of the finest level: weaker extrema are noise"};
inline constexpr base::Parameter<int> kGridCell_px{
    .name = "grid_cell",
    .value = 32,
    .unit = "px",
    .origin = base::ParameterOrigin::kTuned,
    .why = "features compete with those in their cell of a grid, ..."};
inline constexpr base::Parameter<float> kCrowding{
    .name = "crowding",
    .value = 0.25F,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "... where the contrast of the n-th counts n to the minus this"};
inline constexpr base::Parameter<float> kAngleWindow{
    .name = "angle_window",
    .value = 2,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "blurs of a feature: standard deviation of the window in which its "
        "angle is sought; Lowe has 1.5"};
inline constexpr base::Parameter<float> kAngleWindowReach{
    .name = "angle_window_reach",
    .value = 2.5F,
    .unit = "",
    .origin = base::ParameterOrigin::kGeometry,
    .why = "standard deviations at which that window is cut off"};
inline constexpr base::Parameter<float> kAngleSmoothing_rad{
    .name = "angle_smoothing",
    .value = 0.3F,
    .unit = "rad",
    .origin = base::ParameterOrigin::kTuned,
    .why = "of the histogram of angles"};
inline constexpr base::Parameter<float> kSecondAngle{
    .name = "second_angle",
    .value = 0.8F,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "share of the highest peak that makes a second angle (Lowe 2004)"};
inline constexpr base::Parameter<float> kCellSize{
    .name = "cell_size",
    .value = 4,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "blurs of a feature: side of a cell of its descriptor; Lowe has 3"};
inline constexpr base::Parameter<float> kPatchCells{
    .name = "patch_cells",
    .value = 5,
    .unit = "",
    .origin = base::ParameterOrigin::kGeometry,
    .why = "cells across a patch: four, and half of one on either side"};
inline constexpr base::Parameter<float> kPatchWindow{
    .name = "patch_window",
    .value = 2,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "cells: standard deviation of the window of a descriptor (Lowe 2004)"};
inline constexpr base::Parameter<float> kLargestShare{
    .name = "largest_share",
    .value = 0.2F,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "of a normalised histogram in one direction of one cell (Lowe 2004)"};

// All of them, in this order.
std::vector<base::ParameterRow> FeatureParameters();

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_PARAMETERS_H_
