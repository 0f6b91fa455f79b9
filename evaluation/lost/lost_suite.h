// How well the lost detector tells kidnapped robots from those that drive among
// people and moved furniture: simulated drives with AMCL.
#ifndef EVALUATION_LOST_LOST_SUITE_H_
#define EVALUATION_LOST_LOST_SUITE_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "nav_agent/localization/lost_detector.h"
#include "simulation/runs/lost_suite_world.h"
#include "simulation/simulator/fault.h"
#include "simulation/worlds/world.h"

namespace treeline::lost {

// A robot is lost while its estimate is further than one of these from the
// truth, or on another level.
inline constexpr double kLostBeyond_m = 0.5;
inline constexpr double kLostBeyond_deg = 20;
// Within this time after a kidnap it must have been said.
inline constexpr double kDeclareWithin_s = 3;

enum class KidnapStart : uint8_t {
  // Localization followed the robot, then it was carried away.
  kWarm,
  // It is told a wrong place as it begins.
  kCold,
  // It was told nothing and has not found its place.
  kAnywhere
};
const char* KidnapStartName(KidnapStart start);

struct LostRunOptions {
  std::string world;
  uint64_t seed = 0;
  // Of driving along the world's tour, and how many kidnaps follow.
  double drive_s = 360;
  int kidnaps = 10;
  // Pieces of furniture that stand where the map has none.
  int new_obstacles = 6;
  // What was moved since, beside what the world's file moves.
  worlds::Rearrangement rearranged{};
  localization::LostDetectorOptions detector;
  localization::AmclOptions amcl;
};

// One scan and what was made of it.
struct LostSample {
  float time_s = 0;
  // Natural logarithm of the odds that the robot is lost.
  float log_odds = 0;
  // How wrong localization is.
  float error_m = 0;
  float error_deg = 0;
  geometry::Vec3 position;
  bool is_lost = false;
  // The first scan after the robot or its estimate was put somewhere.
  bool is_first = false;
  localization::LostState state = localization::LostState::kLocalized;
  localization::LostFeatures features;
};

struct KidnapTrial {
  KidnapStart start = KidnapStart::kWarm;
  bool is_near = false;
  bool drives = false;
  // The kidnap, simulated, and how far it took the robot.
  double time_s = 0;
  double away_m = 0;
  double turned_deg = 0;
  // The highest log of the odds in the second before.
  double log_odds_before = 0;
  // From the kidnap on.
  std::vector<LostSample> samples;
};

struct LostRun {
  std::string world;
  uint64_t seed = 0;
  std::vector<LostSample> drive;
  std::vector<KidnapTrial> trials;
  // How often AMCL lost its place in the drive, and was told it again.
  int losses = 0;
  int obstacles = 0;
  // Processor time of a scan in the detector (us): mean, highest.
  double mean_us = 0;
  double highest_us = 0;
  double simulated_s = 0;
};

// `progress` is called with simulated seconds that have passed. CANCELLED if
// `stop` is requested. Deterministic by world, seed and options, times apart.
absl::StatusOr<LostRun> RunLostSuite(
    const runs::SuiteWorld& map, const LostRunOptions& options,
    const std::function<void(double seconds)>& progress,
    const std::stop_token& stop);

// Simulated seconds that a run takes, about.
double ExpectedSeconds(const LostRunOptions& options);

}  // namespace treeline::lost

#endif  // EVALUATION_LOST_LOST_SUITE_H_
