// Missions in simulated worlds: a robot is told where it is and where to go,
// and what becomes of it is counted. docs/reference/suites.md.
#ifndef EVALUATION_MISSIONS_MISSION_SUITE_H_
#define EVALUATION_MISSIONS_MISSION_SUITE_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "evaluation/missions/mission_trouble.h"
#include "evaluation/suites/suite_route.h"
#include "evaluation/suites/suite_run.h"

namespace treeline::missions {

enum class MissionOutcome : uint8_t {
  // It says that it has arrived, and it stands there.
  kArrived,
  // It says so, and stands elsewhere.
  kWrongPlace,
  // It gave up: cause and why.
  kFailed,
  // It was still on its way when its time was over.
  kTimeout,
  // It fell, tipped over or went down stairs.
  kFell
};
const char* MissionOutcomeName(MissionOutcome outcome);

struct MissionOptions {
  uint64_t seed = 0;
  // People walk about, and something gets in the way.
  bool people = false;
  // A named mission instead of a random one; empty: random. See MissionScenes.
  std::string scene;
  // From start to goal, at least (m).
  double min_way_m = 4;
  double camera_hz = 0;
  // nullopt: the default robot.
  std::optional<core::RobotDescription> robot = std::nullopt;
  bool has_rear_laser = true;
  behavior::NavigatorOptions navigator;
};

struct Mission {
  suites::Route route;
  Surprise surprise = Surprise::kNone;
  double surprise_share = 0.4;
  int passers = 0;
};

struct MissionRun : suites::SuiteRun {
  std::string scene;
  MissionOutcome outcome = MissionOutcome::kFailed;
  Mission mission;
  std::string surprise;
  // At the end, of its estimate, and of where it stands to where it should.
  suites::PoseMiss estimate_error;
  suites::PoseMiss goal_error;
  int replans = 0;
  int recoveries = 0;
  // How often it declared itself lost although it was not kidnapped.
  int false_losses = 0;

  // Arrived, and nothing happened that must not.
  bool IsGood() const {
    return outcome == MissionOutcome::kArrived && IsSafe();
  }
};

// The thesis's own, all in the cafe: "slope" (up to the terrace), "blocked"
// (a crate on the way), "person" (steps in front).
std::vector<std::string> MissionScenes();

// What a seed stands for: DrawRoute, and what gets in the way. NOT_FOUND: no
// such scene; errors of DrawRoute.
absl::StatusOr<Mission> MakeMission(const suites::SuitePlace& place,
                                    const MissionOptions& options);

// Deterministic by place and options, times apart. CANCELLED if `stop` is
// requested.
absl::StatusOr<MissionRun> RunMission(const suites::SuitePlace& place,
                                      const MissionOptions& options,
                                      const std::stop_token& stop);

}  // namespace treeline::missions

#endif  // EVALUATION_MISSIONS_MISSION_SUITE_H_
