// Whether a server's answer can be where the robot is, judged by
// judging_particles that have nothing to do with how the server found it:
// gravity, the map, the laser. Pure functions; fix_checker.h gathers the
// judging_particles.
#ifndef NAV_AGENT_BEHAVIOR_FIX_GATE_H_
#define NAV_AGENT_BEHAVIOR_FIX_GATE_H_

#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "nav_agent/behavior/relocalization_parameters.h"
#include "nav_agent/core/level_pose.h"
#include "nav_agent/core/relocalization.h"
#include "nav_agent/core/robot_model.h"
#include "nav_agent/localization/robot_tracker.h"
#include "nav_agent/localization/scan_fit.h"

namespace treeline::behavior {

struct FixGateOptions {
  // The server's own probability: below the first it is refused, below the
  // second, or below the scene's own threshold, it is weak.
  double min_confidence = kMinFixConfidence;
  double sure_confidence = kSureFixConfidence;
  // The camera's tilt and what the inertial sensor says of it (rad).
  double max_tilt_rad = kMaxTiltError_rad;
  // The base stands on ground within this of where it is, up or down (m), and
  // not nearer to an obstacle than its front is, less what the fix may be off
  // (m).
  double max_height_error_m = kMaxFixHeight_m;
  double min_clearance_m = core::RobotModel().front_m - kFixSearch_m;
  // Of the newest scan at the fix: least share that the map explains and most
  // that passes through it, to be taken at all; and to be sure.
  double min_explained = kMinFixExplained;
  double max_contradicted = kMaxFixContradicted;
  double sure_explained = kSureExplained;
  double sure_contradicted = kSureContradicted;
  // Fewer judged beams say nothing: the fix is weak.
  int min_judged_beams = kMinJudgedBeams;
  // The fix may be this much off: places around it are tried for the best fit
  // (m, rad; and how finely).
  double search_m = kFixSearch_m;
  double search_rad = kFixSearch_rad;
  // Of two fixes: how far they may differ from what the wheels say between them
  // (m, rad); more if the server says that they are not well known.
  double pair_m = kPairDistance_m;
  double pair_rad = kPairAngle_rad;

  absl::Status Validate() const;
};

enum class FixVerdict : uint8_t {
  kSure = 0,  // may be taken
  kWeak = 1,  // a second view must agree
  kNotLocalized = 2,
  kBroken = 3,  // numbers that are none
  kLowConfidence = 4,
  kAgainstGravity = 5,
  kNotOnGround = 6,  // in a wall, in the air, outside of the map
  kAgainstScan = 7
};
const char* FixVerdictName(FixVerdict verdict);
constexpr bool IsRefused(FixVerdict verdict) {
  return verdict != FixVerdict::kSure && verdict != FixVerdict::kWeak;
}

// What the map says of a fix.
struct GroundWitness {
  // The base, by the fix, in the map's frame (m).
  geometry::Vec3 base_in_map;
  // The height (m) of the ground below or above it with room for the robot, the
  // nearest of all levels; nullopt: there is none.
  std::optional<double> ground_m;
  // There is none but for obstacles of the map that the newest scan sees
  // through. The laser must vouch for such a fix, and it is weak.
  bool is_seen_through = false;
};

// What the laser says of a fix.
struct ScanWitness {
  // The newest scan at the best place near the fix; nullopt: there is no scan.
  std::optional<localization::ScanFit> at_fix;
  // The same scan where the robot thought it was; nullopt: it had no idea, or
  // that is the same place.
  std::optional<localization::ScanFit> at_belief;
};

// A witness that is absent was not asked, and speaks neither for nor against.
struct FixWitnesses {
  // The angle between the fix's idea of "up" and the inertial sensor's (rad).
  std::optional<double> tilt_error_rad;
  std::optional<GroundWitness> ground;
  std::optional<ScanWitness> scan;
};

struct FixJudgement {
  FixVerdict verdict = FixVerdict::kNotLocalized;
  // "explained 0.41 of 87 beams": for people.
  std::string why;
};

// The judging_particles in their order; the first that refuses decides. Without
// a scan a fix is weak at best.
FixJudgement JudgeFix(const core::RelocalizationAnswer& answer,
                      const FixWitnesses& judging_particles,
                      const FixGateOptions& options);

// For FixWitnesses; rotations of the base, in the map's frame by the fix and in
// a level one by the inertial sensor.
double TiltError_rad(const geometry::Rotation3& map_from_base,
                     const geometry::Rotation3& level_from_base);
// The server is sure: sure_confidence and the scene's threshold are reached.
bool IsServerSure(const core::RelocalizationAnswer& answer,
                  const FixGateOptions& options);
// ln(p / (1 - p)) of a confidence p, which is taken as 0.01 to 0.99.
double LogOddsOf(double confidence);
// Of the base on the map, from the server's (Rigid3's order): variances only,
// within what a fix can be known to.
localization::PoseCovariance2 FixCovariance(
    const geometry::PoseCovariance& covariance);

// A fix and what the gate has to say about it.
struct GatedFix {
  FixVerdict verdict = FixVerdict::kNotLocalized;
  std::string why;
  // Meaningful unless refused; of the moment of the frame.
  core::LevelPose pose;
  localization::PoseCovariance2 covariance{};
  double confidence = 0;
  bool is_server_sure = false;
  // Of views that agree, their sum.
  double log_odds = 0;
  std::optional<localization::ScanFit> fit;
  // The wheels' of that moment.
  localization::TrackedMotion motion;
};

// The verdict and why: for people.
std::string FixText(const GatedFix& fix);

// Whether two fixes are related as the wheels' motion between them says.
bool FixesAgree(const GatedFix& first, const GatedFix& second,
                const FixGateOptions& options);
// The later of two fixes that agree, with what both say of its odds: views of
// different things add up, loose_search views of the same thing err together.
GatedFix CombinedFix(const GatedFix& earlier, GatedFix later);
// The server was sure of one of the views, or all together are sure.
bool AreViewsSure(const GatedFix& combined);

}  // namespace treeline::behavior

#endif  // NAV_AGENT_BEHAVIOR_FIX_GATE_H_
