// The tuned constants of the pose solvers. What a caller may choose stands in
// the solvers' options.
#ifndef SERVER_CORE_POSE_PARAMETERS_H_
#define SERVER_CORE_POSE_PARAMETERS_H_

#include <vector>

#include "common/base/parameter.h"

namespace treeline::pose {

// Refinement.
inline constexpr base::Parameter<double> kInitialRobustScale{
    .name = "initial_robust_scale",
    .value = 3,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "the robust loss starts so many times as wide as it ends: "
        "draws in hypotheses that are some inlier distances off"};
inline constexpr base::Parameter<double> kRobustReach{
    .name = "robust_reach",
    .value = 3,
    .unit = "",
    .origin = base::ParameterOrigin::kGeometry,
    .why =
        "residuals beyond so many robust scales, whose weight is below "
        "one in a hundred, are left out"};
inline constexpr base::Parameter<double> kMinRobustWeights{
    .name = "min_robust_weights",
    .value = 3,
    .unit = "",
    .origin = base::ParameterOrigin::kGeometry,
    .why = "fewer than three samples determine no pose"};
inline constexpr base::Parameter<double> kMinPointRcond{
    .name = "min_point_rcond",
    .value = 1e-12,
    .unit = "",
    .origin = base::ParameterOrigin::kPhysics,
    .why =
        "equations of points are singular below it, a few thousand "
        "rounding errors of a double"};
inline constexpr base::Parameter<double> kMinRayRcond{
    .name = "min_ray_rcond",
    .value = 1e-14,
    .unit = "",
    .origin = base::ParameterOrigin::kPhysics,
    .why =
        "as for points; translations and rotations of rays are scaled "
        "worse to each other"};
inline constexpr base::Parameter<double> kMinDamping{
    .name = "min_damping",
    .value = 1e-4,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "Levenberg-Marquardt starts here, and is Gauss-Newton below it"};
inline constexpr base::Parameter<double> kDampingFactor{
    .name = "damping_factor",
    .value = 10,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "Marquardt's own: damping grows and shrinks by it"};
inline constexpr base::Parameter<int> kMaxDampedSteps{
    .name = "max_damped_steps",
    .value = 5,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "a step that is damped so often is nearly none"};

// Points and lines in RANSAC.
inline constexpr base::Parameter<int> kFinalRefits{
    .name = "final_refits",
    .value = 3,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "refits of the winner to its inliers among all points"};
inline constexpr base::Parameter<double> kMaxScoredSlide_m{
    .name = "max_scored_slide",
    .value = 0.2,
    .unit = "m",
    .origin = base::ParameterOrigin::kTuned,
    .why = "a prediction on a line is free along it up to this distance"};
inline constexpr base::Parameter<int> kMaxRefinedPointLinePoses{
    .name = "max_refined_point_line_poses",
    .value = 4,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "so few survivors are fitted to lines too, which costs many "
        "times Kabsch's fit to points"};

// Rays in RANSAC.
inline constexpr base::Parameter<double> kMinRaySide{
    .name = "min_ray_side",
    .value = 3,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "rays of a sample that are nearer, in inlier distances, make a "
        "badly conditioned triangle"};
inline constexpr base::Parameter<int> kMaxRefinedRayPoses{
    .name = "max_refined_ray_poses",
    .value = 16,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "so few survivors are refined locally between prunings"};
inline constexpr base::Parameter<int> kLocalRayIterations{
    .name = "local_ray_iterations",
    .value = 3,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "steps of a survivor's local refinement"};

// Focal length from matched features, and from measured points.
inline constexpr base::Parameter<int> kFocalIterations{
    .name = "focal_iterations",
    .value = 12,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why = "Gauss-Newton steps over pose and focal length"};
inline constexpr base::Parameter<double> kInitialFocalRobustScale{
    .name = "initial_focal_robust_scale",
    .value = 8,
    .unit = "",
    .origin = base::ParameterOrigin::kGeometry,
    .why =
        "times the robust loss's scale at the first of them: at the edge of a "
        "picture a focal length that is off by 15 % is off by some 20 px"};
inline constexpr base::Parameter<int> kPointFocalIterations{
    .name = "point_focal_iterations",
    .value = 5,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "the same of measured points: from the pose that they gave; 3 find "
        "a third of an error of 10 % less than 5, 8 no more"};
inline constexpr base::Parameter<double> kInitialPointFocalRobustScale{
    .name = "initial_point_focal_robust_scale",
    .value = 2,
    .unit = "",
    .origin = base::ParameterOrigin::kGeometry,
    .why =
        "of these: a focal length that is off by 10 % moves points 3 m away by "
        "some 8 cm"};
inline constexpr base::Parameter<double> kPointFocalBias{
    .name = "point_focal_bias",
    .value = 0.01,
    .unit = "",
    .origin = base::ParameterOrigin::kTuned,
    .why =
        "of the logarithm of what they find, beside its noise: right focal "
        "lengths are found 0 to 2 % too long by a whole map alike"};
inline constexpr base::Parameter<double> kDepthScaleSigma{
    .name = "depth_scale_sigma",
    .value = 0.01,
    .unit = "",
    .origin = base::ParameterOrigin::kPhysics,
    .why =
        "standard deviation of the logarithm of a depth camera's scale, as "
        "they are sold"};
inline constexpr base::Parameter<double> kMaxLogFocalScale{
    .name = "max_log_focal_scale",
    .value = 0.7,
    .unit = "",
    .origin = base::ParameterOrigin::kGeometry,
    .why = "nobody states half or twice the true focal length"};

// All of them, in this order.
std::vector<base::ParameterRow> PoseParameters();

}  // namespace treeline::pose

#endif  // SERVER_CORE_POSE_PARAMETERS_H_
