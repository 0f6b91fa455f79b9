// The tuned constants of sampling and of line segments. What a caller may
// choose stands in the functions' options. Constants of file formats and of
// trained models stay where they are used: other values need other models.
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
    .why = "LSD's regions need a few pixels; OpenCV's fails on less"};
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

// All of them, in this order.
std::vector<base::ParameterRow> FeatureParameters();

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_PARAMETERS_H_
