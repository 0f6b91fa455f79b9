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
#include "evaluation/suites/suite_robot.h"
#include "simulation/runs/plan_picture.h"

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
  bool has_rear_laser = true;
  behavior::NavigatorOptions navigator;
};

struct Mission {
  simulator::RobotPlacement start;
  simulator::RobotPlacement goal;
  // The shortest way of a round robot (m).
  double way_m = 0;
  Surprise surprise = Surprise::kNone;
  double surprise_share = 0.4;
  int passers = 0;
};

struct MissionRun {
  std::string world;
  uint64_t seed = 0;
  std::string scene;
  MissionOutcome outcome = MissionOutcome::kFailed;
  core::NavigationCause cause = core::NavigationCause::kNone;
  std::string why;
  Mission mission;
  std::string surprise;
  double simulated_s = 0;
  double driven_m = 0;
  int collisions_of_robot = 0;
  int collisions = 0;
  int stair_entries = 0;
  int edge_entries = 0;
  // At the end, of its estimate, and of where it stands to where it should.
  suites::PoseMiss estimate_error;
  suites::PoseMiss goal_error;
  int replans = 0;
  int recoveries = 0;
  // How often it declared itself lost although it was not kidnapped.
  int false_losses = 0;
  suites::StepTimes times;
  // For the picture and the log of a run that failed.
  runs::SimulationResult record;
  std::vector<behavior::NavigatorEvent> events;
  runs::PlanMarks marks;

  // Arrived, and nothing happened that must not.
  bool IsGood() const {
    return outcome == MissionOutcome::kArrived && collisions_of_robot == 0 &&
           stair_entries == 0 && edge_entries == 0;
  }
};

// The thesis's own, all in the cafe: "slope" (up to the terrace), "blocked"
// (a crate on the way), "person" (steps in front).
std::vector<std::string> MissionScenes();

// What a seed stands for: start and goal anywhere on ground that can be
// reached, min_way_m apart; every third seed's are at different heights where a
// world has some. NOT_FOUND: no such scene; FAILED_PRECONDITION: the world is
// too small.
absl::StatusOr<Mission> MakeMission(const suites::SuitePlace& place,
                                    const MissionOptions& options);

// Deterministic by place and options, times apart. CANCELLED if `stop` is
// requested.
absl::StatusOr<MissionRun> RunMission(const suites::SuitePlace& place,
                                      const MissionOptions& options,
                                      const std::stop_token& stop);

// Counts of what happened in a simulation.
int StairEntries(const runs::SimulationResult& record);
int EdgeEntries(const runs::SimulationResult& record);
// What the robot planned and believes, in the world.
runs::PlanMarks MarksOf(const suites::SuitePlace& place,
                        const behavior::NavigatorSnapshot& snapshot,
                        const simulator::RobotPlacement& goal);

}  // namespace treeline::missions

#endif  // EVALUATION_MISSIONS_MISSION_SUITE_H_
