// The tuned constants of localization and of lost detection.
#ifndef NAV_AGENT_LOCALIZATION_PARAMETERS_H_
#define NAV_AGENT_LOCALIZATION_PARAMETERS_H_

#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "common/base/parameter.h"

namespace treeline::localization {

inline constexpr base::Parameter<double> kHeadingLever_m{
    "heading_lever", 2, "m", base::ParameterOrigin::kGeometry,
    "an error of the heading counts as one of the place of what is this far"};

// ---- AMCL ----

inline constexpr base::Parameter<int> kMinParticles{
    "min_particles", 500, "", base::ParameterOrigin::kTuned, "Nav2's default"};
inline constexpr base::Parameter<int> kMaxParticles{
    "max_particles", 2000, "", base::ParameterOrigin::kTuned, "Nav2's default"};
inline constexpr base::Parameter<int> kMaxGlobalParticles{
    "max_global_particles", 30000, "", base::ParameterOrigin::kTuned,
    "while the robot is looked for everywhere"};
inline constexpr base::Parameter<double> kKldError{
    "kld_error", 0.05, "", base::ParameterOrigin::kTuned,
    "of KLD sampling (Fox 2003); Nav2's default"};
inline constexpr base::Parameter<double> kKldQuantile{
    "kld_quantile", 2.3263478740408408, "", base::ParameterOrigin::kPhysics,
    "of the normal distribution at 0.99"};
inline constexpr base::Parameter<double> kBin_m{
    "bin_size", 0.5, "m", base::ParameterOrigin::kTuned,
    "of KLD sampling and of clusters"};
inline constexpr base::Parameter<double> kBin_rad{
    "bin_angle", 0.17453292519943295, "rad", base::ParameterOrigin::kTuned,
    "10 degrees"};
// Half a bin, so that a cloud of particles is looked at before it has left its
// own; Nav2's default.
inline constexpr double kUpdateDistance_m = kBin_m / 2;
inline constexpr base::Parameter<double> kUpdateTurn_rad{
    "update_turn", 0.2, "rad", base::ParameterOrigin::kTuned, "Nav2's default"};
inline constexpr base::Parameter<int> kScanBeams{
    "scan_beams", 60, "", base::ParameterOrigin::kTuned,
    "Nav2's default; more tell nearly the same"};
inline constexpr base::Parameter<double> kMinCountingShare{
    "min_counting_share", 0.05, "", base::ParameterOrigin::kTuned,
    "of particles that one scan may leave with weight (tempering)"};
inline constexpr base::Parameter<double> kSearchingShare{
    "searching_share", 0.3, "", base::ParameterOrigin::kTuned,
    "of a scan's weight while particles are few for the room"};
inline constexpr base::Parameter<double> kFoundShare{
    "found_share", 0.95, "", base::ParameterOrigin::kTuned,
    "of the weight in one cluster: the place is found; and the probability "
    "that a robot which is called lost is lost"};
inline constexpr base::Parameter<double> kBeamSkipThreshold{
    "skip_below_share", 0.3, "", base::ParameterOrigin::kTuned,
    "of the particles that explain a beam: else a person, a moved chair"};
inline constexpr base::Parameter<double> kBeamSkipDistance_m{
    "skip_distance", 0.5, "m", base::ParameterOrigin::kTuned,
    "from an obstacle: explained"};
inline constexpr base::Parameter<double> kAlphaSlow{
    "slow_share", 0.001, "", base::ParameterOrigin::kTuned,
    "of the long-term average (Nav2's)"};
inline constexpr base::Parameter<double> kAlphaFast{
    "fast_share", 0.1, "", base::ParameterOrigin::kTuned,
    "of the short-term average (Nav2's)"};
inline constexpr base::Parameter<double> kInjectRatio{
    "inject_ratio", 1.5, "", base::ParameterOrigin::kTuned,
    "Gutmann and Fox, 2002"};
inline constexpr base::Parameter<double> kInjectedShare{
    "injected_share", 0.5, "", base::ParameterOrigin::kTuned,
    "of the weight, for particles drawn anew"};
inline constexpr base::Parameter<double> kOffGroundShare{
    "off_ground_share", 0.5, "", base::ParameterOrigin::kTuned,
    "of the beams, for a particle that stands on nothing"};
inline constexpr base::Parameter<double> kBeamGroundShare{
    "beam_ground_share", 0.01, "", base::ParameterOrigin::kTuned,
    "of a beam's length, for the error of the tilt"};
inline constexpr base::Parameter<double> kResampleBelow{
    "resample_below", 0.5, "", base::ParameterOrigin::kTuned,
    "of the particles count"};

// ---- The likelihood field and its layers ----

inline constexpr base::Parameter<double> kHitStd_m{
    "hit_std", 0.2, "m", base::ParameterOrigin::kTuned,
    "of a beam's end (Nav2's): voxels, and the estimate's error"};
inline constexpr base::Parameter<double> kBeamHitShare{
    "beam_hit_share", 0.9, "", base::ParameterOrigin::kTuned,
    "of beams that the map explains"};
inline constexpr base::Parameter<double> kLayer_m{
    "layer", 0.1, "m", base::ParameterOrigin::kGeometry,
    "two voxels; beams that end so near to the ground may end on it"};
inline constexpr base::Parameter<int64_t> kMaxFieldBytes{
    "max_field_bytes", 536870912, "", base::ParameterOrigin::kPhysics,
    "memory of one field"};
inline constexpr base::Parameter<double> kMaxRise_m{
    "max_rise", 0.3, "m", base::ParameterOrigin::kTuned,
    "between grounds that the robot goes over; a fix is of the ground that is "
    "this near"};
inline constexpr base::Parameter<double> kSameHeight_m{
    "same_height", 0.0001, "m", base::ParameterOrigin::kPhysics, "rounding"};

// ---- Odometry noise (Probabilistic Robotics, table 5.6) ----

inline constexpr base::Parameter<double> kTurnFromTurn{
    "turn_from_turn", 0.1, "", base::ParameterOrigin::kTuned,
    "rad per rad, and m per m; a differential drive on firm ground"};
inline constexpr base::Parameter<double> kTurnFromDrive{
    "turn_from_drive", 0.05, "", base::ParameterOrigin::kTuned, "rad per m"};
inline constexpr base::Parameter<double> kDriveFromTurn{
    "drive_from_turn", 0.02, "", base::ParameterOrigin::kTuned, "m per rad"};
inline constexpr base::Parameter<double> kNoiseMargin{
    "noise_margin", 6, "", base::ParameterOrigin::kTuned,
    "times what was measured of a robot: 1 is worse than the default, 4 to 6 "
    "are best for odometry that errs by 5 and 15 %"};
inline constexpr base::Parameter<double> kMinCourse_m{
    "min_course", 0.01, "m", base::ParameterOrigin::kMeasured,
    "the direction of a shorter way means nothing"};

// ---- Where the laser sees the map ----

inline constexpr base::Parameter<double> kViewPlace_m{
    "view_place", 0.5, "m", base::ParameterOrigin::kTuned,
    "between places that rays are cast from"};
inline constexpr base::Parameter<double> kViewRange_m{
    "view_range", 25, "m", base::ParameterOrigin::kGeometry, "of a UTM-30LX"};
inline constexpr base::Parameter<double> kViewHitShare{
    "view_hit_share", 0.25, "", base::ParameterOrigin::kTuned,
    "of the rays that get there: occupied"};

// ---- The check of one scan ----

inline constexpr base::Parameter<double> kRangeToleranceShare{
    "range_tolerance_share", 0.02, "", base::ParameterOrigin::kTuned,
    "of a range, for the heading's error"};
inline constexpr base::Parameter<double> kMinCheckRange_m{
    "min_check_range", 0.3, "m", base::ParameterOrigin::kGeometry,
    "nearer is the robot itself"};
inline constexpr base::Parameter<double> kMaxBeamRange_m{
    "max_beam_range", 100, "m", base::ParameterOrigin::kPhysics,
    "bounds what a broken range costs"};
inline constexpr base::Parameter<double> kMinLevelShare{
    "min_level_share", 0.1, "", base::ParameterOrigin::kPhysics,
    "beams steeper than this go up or down"};

// ---- Lost detection ----

inline constexpr base::Parameter<double> kEvidenceInterval_s{
    "evidence_interval", 0.5, "s", base::ParameterOrigin::kTuned,
    "scans of a robot that stands tell the same; a jump is against what was "
    "seen so long ago"};
inline constexpr base::Parameter<double> kMaxEvidenceFor{
    "max_evidence_for", 4, "", base::ParameterOrigin::kTuned,
    "of one scan, log of the odds"};
inline constexpr base::Parameter<double> kSlopeEvidence{
    "slope_evidence", 0.4, "", base::ParameterOrigin::kTuned,
    "part of it on a slope"};
inline constexpr base::Parameter<double> kLossRate_hz{
    "loss_rate", 0.0001, "1/s", base::ParameterOrigin::kTuned,
    "robots that get lost without anything to be seen"};
inline constexpr base::Parameter<double> kJumpFrom{
    "jump_from", 0.12, "", base::ParameterOrigin::kTuned,
    "LostFeatures::jump from which a scan may mean a kidnap"};
inline constexpr base::Parameter<double> kJumpTo{
    "jump_to", 0.35, "", base::ParameterOrigin::kTuned,
    "and from which it means one as surely as it can"};
inline constexpr base::Parameter<double> kKidnapChance{
    "kidnap_chance", 0.3, "", base::ParameterOrigin::kTuned,
    "of a full jump, and of a robot that is lifted"};
inline constexpr base::Parameter<double> kWithdrawLost{
    "withdraw_lost", 0.2, "", base::ParameterOrigin::kTuned,
    "probability; also the most that a place found by laser may have"};
inline constexpr base::Parameter<double> kNotableShare{
    "notable_share", 0.15, "", base::ParameterOrigin::kTuned,
    "of the beams: what a state is named after"};
inline constexpr base::Parameter<double> kLostReasonMemory_s{
    "lost_reason_memory", 5, "s", base::ParameterOrigin::kTuned,
    "a jump or a lift is named for so long"};
inline constexpr base::Parameter<double> kFewBeamsPrior{
    "few_beams_prior", 0.1, "", base::ParameterOrigin::kTuned,
    "of all beams: few beams say little"};
inline constexpr base::Parameter<double> kLifted_rad{
    "lifted", 0.35, "rad", base::ParameterOrigin::kGeometry,
    "a robot on its wheels does not tilt further"};
inline constexpr base::Parameter<double> kLifted_radps{
    "lifted", 1.2, "rad/s", base::ParameterOrigin::kTuned, "and not faster"};
inline constexpr base::Parameter<double> kSlide_m{
    "slide", 0.5, "m", base::ParameterOrigin::kTuned, "a slide of 1"};
inline constexpr base::Parameter<double> kSpread_m{
    "spread", 1.0, "m", base::ParameterOrigin::kTuned, "a spread of 1"};
inline constexpr base::Parameter<double> kFitHistory_s{
    "fit_history", 30, "s", base::ParameterOrigin::kTuned,
    "what scans are compared with"};
inline constexpr base::Parameter<double> kUsualExplained{
    "usual_explained", 0.85, "", base::ParameterOrigin::kTuned,
    "before there is a history"};
inline constexpr base::Parameter<double> kUsualResidual{
    "usual_residual", 0.2, "", base::ParameterOrigin::kTuned,
    "before there is a history"};
inline constexpr base::Parameter<double> kOnSlope_rad{
    "on_slope", 0.03, "rad", base::ParameterOrigin::kMeasured,
    "less is the sensor's error"};
inline constexpr base::Parameter<double> kSameRange_m{
    "same_range", 0.15, "m", base::ParameterOrigin::kTuned,
    "the same thing, seen again"};
inline constexpr base::Parameter<double> kSameRangeShare{
    "same_range_share", 0.03, "", base::ParameterOrigin::kTuned,
    "and of its range"};

// ---- The tracker ----

inline constexpr base::Parameter<double> kScanInterval_s{
    "scan_interval", 0.09, "s", base::ParameterOrigin::kTuned,
    "scans of 10 Hz and more; a younger one tells the same"};
inline constexpr base::Parameter<size_t> kMaxWaitingScans{
    "max_waiting_scans", 8, "", base::ParameterOrigin::kPhysics,
    "bounds the memory while the base is silent"};
inline constexpr base::Parameter<double> kWheelMemory_s{
    "wheel_memory", 2.5, "s", base::ParameterOrigin::kTuned, "of the wheels"};
inline constexpr base::Parameter<double> kTiltFilterShare{
    "tilt_filter_share", 0.2, "", base::ParameterOrigin::kTuned,
    "of one reading: its noise is not tilt"};

// ---- The search over the whole map ----

inline constexpr base::Parameter<double> kSearchGrid_m{
    "search_grid", 0.25, "m", base::ParameterOrigin::kTuned, "between places"};
inline constexpr base::Parameter<double> kOtherPlace_m{
    "other_place", 0.7, "m", base::ParameterOrigin::kTuned,
    "further away is another place"};
inline constexpr base::Parameter<double> kOtherPlace_rad{
    "other_place", 0.6, "rad", base::ParameterOrigin::kTuned,
    "the same, of the heading"};
inline constexpr base::Parameter<double> kOtherFloor_m{
    "other_floor", 1, "m", base::ParameterOrigin::kGeometry,
    "the same, of the height"};
inline constexpr base::Parameter<size_t> kSearchCandidates{
    "search_candidates", 12, "", base::ParameterOrigin::kTuned,
    "that are refined beam by beam"};
inline constexpr base::Parameter<size_t> kSearchSlice{
    "search_slice", 8000, "", base::ParameterOrigin::kTuned,
    "poses in a step: about 2 ms"};

// ---- places that explain what was seen ----

inline constexpr base::Parameter<double> kPlaceTolerance{
    "place_tolerance", 0.05, "", base::ParameterOrigin::kTuned,
    "of the mean log likelihood of a beam: what a map gets wrong"};
inline constexpr base::Parameter<size_t> kViewpoints{
    "viewpoints", 64, "", base::ParameterOrigin::kPhysics,
    "that are remembered: about 30 m"};
inline constexpr base::Parameter<size_t> kPlaceCandidates{
    "place_candidates", 1024, "", base::ParameterOrigin::kPhysics,
    "that are followed: bounds memory and time"};
inline constexpr base::Parameter<size_t> kOtherPlacesShown{
    "other_places_shown", 12, "", base::ParameterOrigin::kPhysics,
    "bounds what a message holds"};
inline constexpr base::Parameter<int> kSureSearches{
    "sure_searches", 2, "", base::ParameterOrigin::kTuned,
    "over the whole map, each with another scan"};

// ---- what follows from others ----

// The map's voxels (m).
inline constexpr double kVoxel_m = kLayer_m / 2;
// Some of the fewest particles are enough to tell whether a beam is explained.
inline constexpr size_t kWitnessParticles = kMinParticles / 2;
// Particles are spread by half of what a beam's end is off, which tells them
// apart (m).
inline constexpr double kRegularization_m = kHitStd_m / 2;
// A range may be off as a beam's end may be (m).
inline constexpr double kRangeTolerance_m = kHitStd_m;
// An end counts as explained up to a voxel further (m).
inline constexpr double kMaxResidual_m = kRangeTolerance_m + kVoxel_m;
// The distance field reaches as far as the longest range may be off (m).
inline constexpr double kFieldReach_m =
    kRangeTolerance_m + kRangeToleranceShare * kViewRange_m;
// Ends this low may be on the ground, which may be a voxel off itself (m).
inline constexpr double kGroundEnd_m = kLayer_m + kVoxel_m;
// The check looks at every beam that AMCL takes, and one between two.
inline constexpr int kCheckedBeams = 2 * kScanBeams;
inline constexpr double kDriveFromDrive = kTurnFromTurn;
// As sure as AMCL has found a place.
inline constexpr double kDeclareLost = kFoundShare;
// Neighbouring headings of the search move what is a lever away as far as
// neighbouring places do.
inline constexpr auto kSearchHeadings =
    static_cast<int>(2 * std::numbers::pi * kHeadingLever_m / kSearchGrid_m);
// Its result is refined by half of its grid, then by half of that (m).
inline constexpr double kRefineStep_m = kSearchGrid_m / 2;
// A search over the whole map takes as long as three scans (s).
inline constexpr double kSearchingInterval_s = 3 * kScanInterval_s;
// The wheels are heard of within half of the time between two scans (s).
inline constexpr double kMaxScanAhead_s = kScanInterval_s / 2;
// A jump is against what was seen one piece of evidence ago (s).
inline constexpr double kJumpAge_s = kEvidenceInterval_s;
// A ray for every half of a checked beam, and a sector for every one.
inline constexpr int kViewDirections = 2 * kCheckedBeams;
inline constexpr size_t kSectors = kCheckedBeams;
// What is not occupied for so many rays is opaque for the others.
inline constexpr double kViewOpaqueShare = 1 - kViewHitShare;
// Three neighbouring beams count as one that is independent.
inline constexpr double kIndependentBeams = kScanBeams / 3;
inline constexpr double kRegularization_rad =
    kRegularization_m / kHeadingLever_m;
inline constexpr double kRefineTurnPerStep = 1 / kHeadingLever_m;
// A search over the whole map takes three scans for one step.
inline constexpr size_t kParticlesAtOnce = kMaxGlobalParticles / 3;
// Grounds further apart in height than two rises are different floors (m).
inline constexpr double kFloorHeight_m = 2 * kMaxRise_m;
// Of what a tilted beam passes, as of its range (m).
inline constexpr double kHeightTolerance_m = kRangeTolerance_m;
// One scan says half as much against as for; two for one side can be undone.
inline constexpr double kMaxEvidenceAgainst = kMaxEvidenceFor / 2;
inline constexpr double kMaxLogOdds = 2 * kMaxEvidenceFor;
// What stands was there one piece of evidence before a jump (s).
inline constexpr double kIdentityAge_s = kJumpAge_s + kEvidenceInterval_s;
// Scans are kept for as long as the oldest that is compared with may be old,
// however rarely they come (s).
inline constexpr double kScanMemory_s = kIdentityAge_s + kSearchingInterval_s;
// Nothing younger than the scan before is compared with (s).
inline constexpr double kYoungestScan_s = kScanInterval_s;

// What says something new is two updates of AMCL further.
inline constexpr double kViewpoint_m = 2 * kUpdateDistance_m;
inline constexpr double kViewpoint_rad = 2 * kUpdateTurn_rad;
// A viewpoint says as much against a place as a scan against being lost. Twice
// what can be said of that must come together: neighbouring viewpoints see the
// same furniture that the map does not have.
inline constexpr double kViewpointEvidence = kMaxEvidenceAgainst;
inline constexpr double kExcludePlace = 2 * kMaxLogOdds;
// A search's grid is coarse, so what it hands over may be far from the best.
inline constexpr double kSearchWithin = 10 * kPlaceTolerance;
// A scan of fewer beams than a sixth of those looked at tells no places apart.
inline constexpr size_t kMinViewpointBeams = kScanBeams / 6;

// Beams that end nearer to the ground may end on it.
inline constexpr double kBeamGround_m = kLayer_m;

// All of the folder, in this order.
std::vector<base::ParameterRow> LocalizationParameters();

}  // namespace treeline::localization

#endif  // NAV_AGENT_LOCALIZATION_PARAMETERS_H_
