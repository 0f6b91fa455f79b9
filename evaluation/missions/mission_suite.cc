#include "evaluation/missions/mission_suite.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"

namespace treeline::missions {
namespace {

// A mission takes as long as this at most.
constexpr double kPatience_s = 60;
constexpr double kPatience_spm = 8;
constexpr double kMorePatience_s = 60;
constexpr double kFinalSettle_s = 0.5;
constexpr int kPassers = 2;
// Obstacles do not need 640 x 480 pixels, which take 0.1 s to render.
constexpr double kCameraScale = 0.25;

struct NamedMission {
  const char* name;
  // Places of the cafe (cafe.yaml) and where between them.
  simulator::RobotPlacement start;
  simulator::RobotPlacement goal;
  Surprise surprise;
};

// The slope rises from (2.9, 0.8) to the terrace at (8, 0.8), 0.51 m higher.
const std::vector<NamedMission>& NamedMissions() {
  static const auto* const kMissions = new std::vector<NamedMission>{
      {.name = "slope",
       .start = {.position = {1.6, 7.9}, .yaw_rad = 0, .height_m = 0},
       .goal = {.position = {10.4, 1.4}, .yaw_rad = 3.14, .height_m = 0.51},
       .surprise = Surprise::kNone},
      {.name = "blocked",
       .start = {.position = {1.6, 3.8}, .yaw_rad = 0, .height_m = 0},
       .goal = {.position = {8.8, 5.4}, .yaw_rad = 1.57, .height_m = 0},
       .surprise = Surprise::kCrate},
      {.name = "person",
       .start = {.position = {1.6, 7.9}, .yaw_rad = 0, .height_m = 0},
       .goal = {.position = {9.2, 7.9}, .yaw_rad = 0, .height_m = 0},
       .surprise = Surprise::kPerson}};
  return *kMissions;
}

absl::StatusOr<Mission> MakeNamed(const suites::SuitePlace& place,
                                  const std::string& scene) {
  for (const NamedMission& named : NamedMissions()) {
    if (named.name != scene) continue;
    Mission mission = {.route = {.start = named.start, .goal = named.goal},
                       .surprise = named.surprise,
                       .surprise_share = 0.3};
    const auto way_m = place.PathLength_m(named.start, named.goal);
    if (!way_m.has_value()) {
      return absl::FailedPreconditionError(absl::StrCat(
          "scene ", scene, " is of the cafe; in ", place.world().name,
          " there is no way from its start to its goal"));
    }
    mission.route.way_m = *way_m;
    return mission;
  }
  return absl::NotFoundError(
      absl::StrCat("no scene is called '", scene, "'; there are ",
                   absl::StrJoin(MissionScenes(), ", ")));
}

Surprise SurpriseOf(base::Random& random) {
  const double draw = random.NextUnit();
  if (draw < 0.5) return Surprise::kCrate;
  return draw < 0.75 ? Surprise::kDoor : Surprise::kPerson;
}

MissionOutcome OutcomeOf(const MissionRun& run,
                         const std::optional<behavior::GoalStatus>& goal) {
  if (run.record.final_state.is_fallen || run.stair_entries > 0 ||
      run.edge_entries > 0) {
    return MissionOutcome::kFell;
  }
  if (!goal.has_value() || !suites::IsOver(*goal))
    return MissionOutcome::kTimeout;
  if (goal->state != behavior::GoalState::kSucceeded)
    return MissionOutcome::kFailed;
  return run.goal_error.IsRight() ? MissionOutcome::kArrived
                                  : MissionOutcome::kWrongPlace;
}

void Summarize(const suites::SuiteRobot& robot,
               const core::LevelPose& goal_in_map, MissionRun& run) {
  suites::Summarize(robot, run.mission.route.goal, run);
  run.false_losses = static_cast<int>(std::ranges::count(
      run.events, std::string("lost"), &behavior::NavigatorEvent::kind));
  run.estimate_error = robot.EstimateError().value_or(
      suites::PoseMiss{.distance_m = -1, .turn_deg = -1, .height_m = -1});
  run.goal_error = robot.place().ErrorOf(
      goal_in_map, run.record.final_state.world_from_base);
  const std::optional<behavior::GoalStatus> goal = robot.navigator().goal();
  if (goal.has_value()) {
    run.replans = goal->replans;
    run.recoveries = goal->recoveries;
    if (suites::IsOver(*goal)) {
      run.cause = goal->cause;
      run.why = goal->why;
    }
  }
  run.outcome = OutcomeOf(run, goal);
}

}  // namespace

const char* MissionOutcomeName(MissionOutcome outcome) {
  switch (outcome) {
    case MissionOutcome::kArrived:
      return "arrived";
    case MissionOutcome::kWrongPlace:
      return "wrong_place";
    case MissionOutcome::kFailed:
      return "failed";
    case MissionOutcome::kTimeout:
      return "timeout";
    case MissionOutcome::kFell:
      return "fell";
  }
  return "unknown";
}

std::vector<std::string> MissionScenes() {
  std::vector<std::string> names;
  for (const NamedMission& named : NamedMissions()) {
    names.emplace_back(named.name);
  }
  return names;
}

absl::StatusOr<Mission> MakeMission(const suites::SuitePlace& place,
                                    const MissionOptions& options) {
  if (!options.scene.empty()) return MakeNamed(place, options.scene);
  base::Random random(options.seed, suites::kRouteStream);
  Mission mission;
  TL_ASSIGN_OR_RETURN(
      mission.route,
      suites::DrawRoute(place, options.seed, options.min_way_m, random));
  if (options.people) {
    mission.passers = kPassers;
    mission.surprise = SurpriseOf(random);
    mission.surprise_share = random.NextUniform(0.15, 0.6);
  }
  return mission;
}

absl::StatusOr<MissionRun> RunMission(const suites::SuitePlace& place,
                                      const MissionOptions& options,
                                      const std::stop_token& stop) {
  MissionRun run;
  run.scene = options.scene;
  TL_ASSIGN_OR_RETURN(run.mission, MakeMission(place, options));
  const Mission& mission = run.mission;
  const suites::Route& route = mission.route;
  TL_ASSIGN_OR_RETURN(const core::LevelPose start, place.InMap(route.start));
  TL_ASSIGN_OR_RETURN(const core::LevelPose goal, place.InMap(route.goal));
  worlds::World world = place.world();
  AddPassers(place, route, mission.passers, options.seed, world);
  TL_ASSIGN_OR_RETURN(
      const std::unique_ptr<suites::SuiteRobot> robot,
      suites::SuiteRobot::Create(place, std::move(world),
                                 {.start = route.start,
                                  .seed = options.seed,
                                  .robot = options.robot,
                                  .camera_hz = options.camera_hz,
                                  .has_rear_laser = options.has_rear_laser,
                                  .camera_scale = kCameraScale,
                                  .camera_is_lit = false,
                                  .navigator = options.navigator}));
  MissionDisturbance trouble({.surprise = mission.surprise,
                              .at_share = mission.surprise_share,
                              .way_m = route.way_m,
                              .goal = route.goal,
                              .seed = options.seed});
  TL_RETURN_IF_ERROR(robot->Tell(start));
  TL_RETURN_IF_ERROR(robot->navigator().SetGoal({.poses = {goal}}).status());
  const bool is_hard =
      mission.passers > 0 || mission.surprise != Surprise::kNone;
  const double until_s = kPatience_s + kPatience_spm * route.way_m +
                         (is_hard ? kMorePatience_s : 0);
  while (robot->now_s() < until_s) {
    if (stop.stop_requested()) return absl::CancelledError("interrupted");
    robot->Step();
    trouble.Step(*robot);
    if (robot->record().final_state.is_fallen) break;
    const std::optional<behavior::GoalStatus> status =
        robot->navigator().goal();
    if (status.has_value() && suites::IsOver(*status)) break;
  }
  // Until it stands.
  for (const double end_s = robot->now_s() + kFinalSettle_s;
       robot->now_s() < end_s;) {
    robot->Step();
  }
  Summarize(*robot, goal, run);
  run.surprise = trouble.what();
  return run;
}

}  // namespace treeline::missions
