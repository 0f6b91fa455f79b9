// What is tuned of seeing obstacles and of keeping away from them.
#ifndef NAV_AGENT_CONTROL_OBSTACLE_PARAMETERS_H_
#define NAV_AGENT_CONTROL_OBSTACLE_PARAMETERS_H_

#include <array>
#include <cstdint>

#include "common/base/parameter.h"
#include "nav_agent/control/setting_parameters.h"

namespace treeline::control {

// ---- the window ----
inline constexpr base::Parameter<double> kCellStep{
    "cell_step", 0.7, "cells", base::ParameterOrigin::kGeometry,
    "samples this far apart miss no cell that is more than cut at a corner"};
// ---- the ground ----
inline constexpr base::Parameter<double> kStepVoxels{
    "step_voxels", 1.5, "voxels", base::ParameterOrigin::kGeometry,
    "slopes are stairs of one voxel; two voxels are a kerb"};
inline constexpr base::Parameter<double> kClimbVoxels{
    "climb_voxels", 0.4, "voxels", base::ParameterOrigin::kGeometry,
    "the ground is spread anew before the robot is half a voxel off"};
inline constexpr base::Parameter<std::array<double, 7>> kSeedHeights_m{
    "seed_heights",
    {{0.0, 0.05, -0.05, 0.12, -0.12, 0.2, -0.2}},
    "m",
    base::ParameterOrigin::kTuned,
    "errors of a pose's height that are tried: a voxel, more on slopes"};
inline constexpr base::Parameter<double> kGroundPerRange{
    "ground_per_range", 0.01, "m/m", base::ParameterOrigin::kTuned,
    "and by this share of the range: a tilt that is 0.6 degrees off"};
// ---- zones ----
inline constexpr base::Parameter<double> kZoneFootprintStep_m{
    "zone_footprint_step", 0.05, "m", base::ParameterOrigin::kGeometry,
    "points of the footprint that are looked at for what it is kept out of: "
    "one in each cell"};
inline constexpr base::Parameter<double> kZoneSlack_m{
    "zone_slack", 0.1, "m", base::ParameterOrigin::kGeometry,
    "so much further in than it stands a robot that is let out may come: two "
    "cells, as it sways along its way out"};
// ---- what is seen ----
inline constexpr base::Parameter<int> kHitsToMark{
    "hits_to_mark", 3, "looks", base::ParameterOrigin::kTuned,
    "one or two may be echoes from edges"};
inline constexpr base::Parameter<int> kMissWeight{
    "miss_weight", 2, "looks", base::ParameterOrigin::kTuned,
    "clearing is faster than marking: who walks leaves no trail"};
inline constexpr base::Parameter<double> kNeighbourGap_m{
    "neighbour_gap", 0.15, "m", base::ParameterOrigin::kTuned,
    "one beam alone is an echo: neighbours end within this"};
inline constexpr base::Parameter<double> kBodyWidening_m{
    "body_widening", 0.15, "m", base::ParameterOrigin::kGeometry,
    "people and carts are so much wider above and below a laser's plane"};
inline constexpr base::Parameter<double> kLegReach_m{
    "leg_reach", 0.5, "m", base::ParameterOrigin::kGeometry,
    "what is so near to a leg that walks is of the same body or cart"};
inline constexpr base::Parameter<double> kPointReach_m{
    "point_reach", 2.0, "m", base::ParameterOrigin::kGeometry,
    "points kept for the guard: it stops within less from its highest speed"};
inline constexpr base::Parameter<double> kLookHeight_m{
    "look_height", 0.6, "m", base::ParameterOrigin::kGeometry,
    "a beam higher above the ground does not see what stands there"};
inline constexpr base::Parameter<double> kDepthRange_m{
    "depth_range", 3.0, "m", base::ParameterOrigin::kPhysics,
    "an RGB-D camera's noise grows with the square of depth"};
// ---- what is gone ----
inline constexpr base::Parameter<double> kThingDepth_m{
    "thing_depth", 0.1, "m", base::ParameterOrigin::kGeometry,
    "what is measured so near to a cell, a cell's diagonal and a sensor's "
    "noise, may be what stands in it"};
inline constexpr base::Parameter<double> kFloorScatter_m{
    "floor_scatter", 0.05, "m", base::ParameterOrigin::kGeometry,
    "what differs from the ground by less, a voxel, is ground: less than the "
    "lowest step that the map has"};
inline constexpr base::Parameter<double> kDepthHoles_m{
    "depth_holes", 3.5, "m", base::ParameterOrigin::kPhysics,
    "what is further may lack in a depth picture: an Xtion's data sheet"};
inline constexpr base::Parameter<double> kPoseJump_m{
    "pose_jump", 0.15, "m", base::ParameterOrigin::kGeometry,
    "no robot moves so far in a cycle: its pose was wrong, by three cells"};
// ---- for how long ----
inline constexpr base::Parameter<double> kRecently_s{
    "recently", 3.0, "s", base::ParameterOrigin::kTuned,
    "for so long what was free, moved, or came in the way may be as it was"};
inline constexpr base::Parameter<double> kStandingAfter_s{
    "standing_after", 1.0, "s", base::ParameterOrigin::kTuned,
    "what has stood for less moves, if it came to where nothing was"};
inline constexpr base::Parameter<double> kStandingMemory_s{
    "standing_memory", 60.0, "s", base::ParameterOrigin::kTuned,
    "unseen, what stood is forgotten after this"};
// ---- who moves ----
inline constexpr base::Parameter<double> kLegsApart_m{
    "legs_apart", 0.4, "m", base::ParameterOrigin::kGeometry,
    "legs of one person in a stride, to their middle"};
inline constexpr base::Parameter<int> kFittedScans{
    "fitted_scans", 14, "scans", base::ParameterOrigin::kTuned,
    "place and speed are those of a straight line through so many"};
inline constexpr base::Parameter<int> kScansToBegin{
    "scans_to_begin", 4, "scans", base::ParameterOrigin::kTuned,
    "seen so often, somebody is there"};
inline constexpr base::Parameter<int> kScansToEnd{
    "scans_to_end", 6, "scans", base::ParameterOrigin::kTuned,
    "in a row where somebody should be seen: he is not there"};
inline constexpr base::Parameter<double> kPositionUncertainty_mps{
    "position_uncertainty", 0.35, "m/s", base::ParameterOrigin::kTuned,
    "out of sight, somebody may be so much further off every second"};
inline constexpr base::Parameter<double> kMaxWalkingSpeed_mps{
    "max_walking_speed", 2.0, "m/s", base::ParameterOrigin::kPhysics,
    "who walks is not faster"};
// ---- the collision guard ----
inline constexpr base::Parameter<double> kPointMargin_m{
    "point_margin", 0.04, "m", base::ParameterOrigin::kMeasured,
    "with 1 cm of laser noise a turning robot crept into a bench at 0.03 m"};
inline constexpr base::Parameter<double> kLaserNoise_m{
    "laser_noise", 0.01, "m", base::ParameterOrigin::kMeasured,
    "standard deviation of a range up to 10 m: the data sheet of a UTM-30LX"};
inline constexpr base::Parameter<double> kCellMargin_m{
    "cell_margin", 0.045, "m", base::ParameterOrigin::kGeometry,
    "the middle of a cell of the map is half a cell off its edge"};
inline constexpr base::Parameter<double> kReaction_s{
    "reaction", 0.08, "s", base::ParameterOrigin::kPhysics,
    "from a command until the base obeys it: three cycles"};
inline constexpr base::Parameter<double> kBrakingShare{
    "braking_share", 0.75, "", base::ParameterOrigin::kPhysics,
    "of the robot's deceleration that is counted on: slopes take the rest"};
inline constexpr base::Parameter<double> kYawBrakingShare{
    "yaw_braking_share", 0.9, "", base::ParameterOrigin::kPhysics,
    "the same of turning, which slopes hardly hinder"};
inline constexpr base::Parameter<double> kApproachSpeed_mps{
    "approach_speed", 0.9, "m/s", base::ParameterOrigin::kPhysics,
    "people who walk towards the robot"};
inline constexpr base::Parameter<double> kBodyMargin_m{
    "body_margin", 0.25, "m", base::ParameterOrigin::kGeometry,
    "half of somebody of whom a leg is seen"};
inline constexpr base::Parameter<double> kLostMargin_m{
    "lost_margin", 0.35, "m", base::ParameterOrigin::kGeometry,
    "from the middle of somebody who is out of sight"};
inline constexpr base::Parameter<double> kOutwardSpeed_mps{
    "outward_speed", 0.005, "m/s", base::ParameterOrigin::kTuned,
    "an edge beside somebody does not move outwards, but for rounding; turns "
    "that are rounded do not either"};
inline constexpr base::Parameter<std::array<double, 7>> kGuardShares{
    "guard_shares",
    {{1.0, 0.8, 0.6, 0.4, 0.25, 0.12, 0.06}},
    "",
    base::ParameterOrigin::kTuned,
    "parts of a command that are tried: finer ones cost time alone"};
inline constexpr base::Parameter<double> kSweepStep_m{
    "sweep_step", 0.02, "m", base::ParameterOrigin::kGeometry,
    "less than the half of a cell: a sweep looks at the footprint so often"};
inline constexpr base::Parameter<double> kGuardSlack_m{
    "guard_slack", 2e-4, "m", base::ParameterOrigin::kPhysics,
    "rounding: what is too near already is not nearer for that"};

// ---- what follows ----
// One look more than marks a cell clears it, however often it was hit.
inline constexpr int kMaxHits = kMissWeight * (kHitsToMark + 1);
// Of a picture that is a radian wide, as an Xtion's, two a cell where it is
// coarsest.
inline constexpr auto kDepthColumns =
    static_cast<int>(2 * kDepthRange_m / kCostmapResolution_m);
// Scans and poses are each a cycle old at most: what more is kept for each m/s
// (s).
inline constexpr double kMarginPerSpeed_s = 2 * kCycle_s;
// What reaches further than the window may be a wall, or glass (m).
inline constexpr double kLooseSize_m = kCostmapSize_m;
// A robot not quite on free ground stands on what its corners reach (m).
inline constexpr double kSeedReach_m = kCorner_m;
// A laser cannot tell less from nothing: a footprint with less room touches,
// and points that are nearer to each other say the same (m).
inline constexpr double kFreeRoom_m = kLaserNoise_m;
inline constexpr double kSameBeam_m = kLaserNoise_m;
// What is too near already may come nearer by what a laser does not see (m).
inline constexpr double kMaxApproach_m = kLaserNoise_m / 2;
// Room beside the footprint that a turn, a search and a bubble want: what the
// guard keeps, and a step of its sweep (m).
inline constexpr double kManoeuvreRoom_m = kPointMargin_m + kSweepStep_m;
// What ends lower above the ground is ground: two voxels (m).
inline constexpr double kGroundTolerance_m = 2 * kCostmapResolution_m;
// Ground is spread anew before what is at the window's edge, half its width
// away, is half a cell off (m/m).
inline constexpr double kNewRise = kCostmapResolution_m / kCostmapSize_m;
// Longer ago is not this moment: six scans (s).
inline constexpr double kSeenNow_s = 6 * kCycle_s;
// The slowest sensor, the camera, has shown it again by then (s).
inline constexpr double kLately_s = 1.5 / kDepthRate_hz;
// Two frames of the camera may be lost (s).
inline constexpr double kDepthLifetime_s = 2.5 / kDepthRate_hz;
// Half a person: nearer to the edge of the view, his middle is not seen; and to
// what moves if it is no more than what is seen, for a lost robot (m).
inline constexpr double kCutAtEdge_m = kLegsApart_m / 2;
inline constexpr double kMovingMargin_m = kLegsApart_m / 2;
// A beam that ends so much nearer than a body ends on somebody else (m).
inline constexpr double kInFront_m = kBodyMargin_m;

// What is seen this near to what the map has already is the map's (m).
inline constexpr double kMapBand_m = 1.5 * kCostmapResolution_m;
// Only what is seen further from the map's obstacles is new, or so far if its
// place was seen free before: nearer, it may be the map's, seen from a pose
// that is off (m).
inline constexpr double kNewFrom_m = 4 * kCostmapResolution_m;
inline constexpr double kCameFrom_m = 2.5 * kCostmapResolution_m;

constexpr int64_t Milliseconds(double seconds) {
  return static_cast<int64_t>(1000 * seconds);
}

}  // namespace treeline::control

#endif  // NAV_AGENT_CONTROL_OBSTACLE_PARAMETERS_H_
