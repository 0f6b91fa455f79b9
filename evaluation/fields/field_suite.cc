#include "evaluation/fields/field_suite.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/processor_time.h"
#include "common/base/status_macros.h"
#include "common/geometry/planar_pose.h"
#include "simulation/building/gazebo_plan.h"
#include "simulation/worlds/world.h"

namespace treeline::fields {
namespace {

constexpr int kWarmUpSteps = 8;
// The clock starts when it has moved so far.
constexpr double kBegun_m = 0.1;
// A robot that does not even set off.
constexpr double kNeverBegun_s = 30;
// Of what moves, pictures show the way of the last seconds.
constexpr double kShownBefore_s = 2;
// Of worlds of Gazebo, which are mostly empty ground, they show what is so
// near.
constexpr double kShownAround_m = 6;

absl::StatusOr<geometry::Rigid2> PlaceOf(const worlds::World& world,
                                         const std::string& name) {
  for (const worlds::NamedPlace& place : world.places) {
    if (place.name != name) continue;
    const worlds::Float3 at = place.placement.origin;
    return geometry::Rigid2{
        {static_cast<double>(at.x), static_cast<double>(at.y)},
        static_cast<double>(place.placement.yaw_rad)};
  }
  return absl::NotFoundError(
      absl::StrCat("the world '", world.name, "' has no place '", name, "'"));
}

// Both in the simulator's frame.
struct Ends {
  geometry::Rigid2 start;
  geometry::Rigid2 goal;
  BestWay best_way;
};

absl::StatusOr<Ends> EndsOf(const worlds::World& world,
                            const FieldOptions& options) {
  Ends ends;
  const bool is_gazebo = worlds::IsGazeboWorld(options.world);
  if (!is_gazebo && !options.ends.has_value()) {
    TL_ASSIGN_OR_RETURN(ends.start, PlaceOf(world, "start"));
    TL_ASSIGN_OR_RETURN(ends.goal, PlaceOf(world, "goal"));
    TL_ASSIGN_OR_RETURN(ends.best_way,
                        FindBestWay(options.world, ends.start.translation,
                                    ends.goal.translation));
    return ends;
  }
  const FieldEnds given = options.ends.value_or(kBarnEnds);
  TL_ASSIGN_OR_RETURN(
      ends.best_way,
      FindBestWay(options.world, given.start.translation, given.goal));
  geometry::Rigid2 world_from_file;
  if (is_gazebo) {
    TL_ASSIGN_OR_RETURN(world_from_file,
                        PlaceOf(world, std::string(building::kGazeboOrigin)));
  }
  ends.start = world_from_file * given.start;
  ends.goal = {.translation = world_from_file * given.goal,
               .yaw_rad = ends.start.yaw_rad};
  for (const geometry::Vec2 end :
       {ends.start.translation, ends.goal.translation}) {
    if (!(end.x >= 0 && end.y >= 0 &&
          end.x <= static_cast<double>(world.size_m.x) &&
          end.y <= static_cast<double>(world.size_m.y))) {
      return absl::InvalidArgumentError(absl::StrCat(
          "start or goal is outside of the world '", world.name, "'"));
    }
  }
  return ends;
}

// One run, as it goes on.
class FieldDrive {
 public:
  static absl::StatusOr<std::unique_ptr<FieldDrive>> Begin(
      const FieldOptions& options) {
    auto drive = std::make_unique<FieldDrive>();
    TL_ASSIGN_OR_RETURN(
        worlds::World world,
        worlds::MakeWorld(options.world, {.with_people = options.with_movers,
                                          .threads = 1,
                                          .paint = false}));
    TL_ASSIGN_OR_RETURN(const Ends ends, EndsOf(world, options));
    const geometry::Rigid2 start = ends.start;
    drive->start_ = start;
    drive->goal_ = ends.goal;
    drive->run_.best_way = ends.best_way;
    simulator::SimulatorOptions simulation;
    simulation.robot = options.robot.model;
    simulation.seed = options.seed;
    simulation.start = {.position = start.translation,
                        .yaw_rad = start.yaw_rad};
    simulation.sensors.UseLasers(options.robot.lasers);
    if (options.robot.noise.has_value()) {
      simulation.errors.UseNoise(*options.robot.noise,
                                 options.robot.model.wheel_track_m);
    }
    TL_ASSIGN_OR_RETURN(drive->simulator_, simulator::Simulator::Create(
                                               std::move(world), simulation));
    simulator::Simulator& simulator = *drive->simulator_;
    simulator.Step(kWarmUpSteps * suites::kSuiteStep);
    TL_ASSIGN_OR_RETURN(
        drive->navigator_,
        mapless::MakeMaplessNavigator(options.robot.model,
                                      {.laser = simulator.laser(),
                                       .odometry = simulator.odometry(),
                                       .base = simulator.base(),
                                       .rear_laser = simulator.rear_laser()},
                                      options.navigator, simulator.clock()));
    drive->run_.record.world = simulator.world().name;
    drive->run_.record.track.emplace_back();
    drive->navigator_->Step();
    // The map begins where the robot stands.
    TL_RETURN_IF_ERROR(
        drive->navigator_
            ->SetGoal(
                {.poses = {{.map_from_base = start.Inverse() * drive->goal_,
                            .place = {}}}})
            .status());
    return drive;
  }

  // False: it is over.
  bool Step() {
    simulator_->Step(suites::kSuiteStep);
    const double before_ms = base::ThreadProcessorTime_ms();
    navigator_->Step();
    run_.times.Add(base::ThreadProcessorTime_ms() - before_ms);
    const simulator::TrueState state = simulator_->state();
    const geometry::Vec3 at = state.world_from_base.translation;
    run_.record.track.back().push_back(at);
    for (simulator::SimEvent& event : simulator_->TakeEvents()) {
      run_.record.events.push_back(std::move(event));
    }
    for (behavior::NavigatorEvent& event : navigator_->TakeEvents()) {
      run_.events.push_back(std::move(event));
    }
    const geometry::Vec2 position = {at.x, at.y};
    const double now_s = simulator::Seconds(state.time);
    if (!begun_s_.has_value() &&
        geometry::Norm(position - start_.translation) > kBegun_m) {
      begun_s_ = now_s;
    }
    run_.time_s = begun_s_.has_value() ? now_s - *begun_s_ : 0;
    run_.goal_off_m = geometry::Norm(position - goal_.translation);
    if (run_.record.CollisionsOfRobot() > 0) {
      run_.outcome = FieldOutcome::kTouched;
    } else if (run_.record.Count(simulator::SimEventKind::kCollision) > 0) {
      run_.outcome = FieldOutcome::kStruck;
    } else if (run_.goal_off_m <= kReached_m) {
      run_.outcome = FieldOutcome::kReached;
    } else if (run_.time_s >= kLongest_s ||
               (!begun_s_.has_value() && now_s > kNeverBegun_s)) {
      run_.outcome = FieldOutcome::kTimeout;
    } else {
      return !suites::IsOver(*navigator_->goal());
    }
    return false;
  }

  FieldRun Finish(const FieldOptions& options) {
    run_.record.seed = options.seed;
    run_.record.final_state = simulator_->state();
    run_.record.simulated_s = simulator::Seconds(simulator_->now());
    run_.world = run_.record.world;
    run_.seed = options.seed;
    run_.simulated_s = run_.record.simulated_s;
    run_.driven_m = run_.record.final_state.distance_m;
    run_.collisions = run_.record.Count(simulator::SimEventKind::kCollision);
    run_.collisions_of_robot = run_.record.CollisionsOfRobot();
    const behavior::GoalStatus goal = *navigator_->goal();
    run_.cause = goal.cause;
    run_.why = goal.why;
    run_.way_changes = goal.replans;
    run_.recoveries = goal.recoveries;
    run_.marks.goal = goal_;
    if (worlds::IsGazeboWorld(options.world)) {
      run_.marks.within_m = kShownAround_m;
    }
    const behavior::NavigatorSnapshot snapshot = navigator_->Snapshot();
    for (const core::LevelPose& pose : snapshot.path) {
      const geometry::Vec2 at = start_ * pose.map_from_base.translation;
      run_.marks.path.push_back({at.x, at.y, 0});
    }
    if (snapshot.pose.has_value()) {
      run_.marks.estimate = start_ * snapshot.pose->pose.map_from_base;
    }
    run_.marks.truth =
        geometry::PlanarPose(run_.record.final_state.world_from_base);
    run_.marks.movers = runs::WaysOfMovers(
        simulator_->world(), run_.record.simulated_s, kShownBefore_s);
    return std::move(run_);
  }

 private:
  std::unique_ptr<simulator::Simulator> simulator_;
  std::unique_ptr<behavior::Navigator> navigator_;
  geometry::Rigid2 start_;
  geometry::Rigid2 goal_;
  std::optional<double> begun_s_;
  FieldRun run_;
};

}  // namespace

const char* FieldOutcomeName(FieldOutcome outcome) {
  switch (outcome) {
    case FieldOutcome::kReached:
      return "reached";
    case FieldOutcome::kTouched:
      return "touched";
    case FieldOutcome::kStruck:
      return "struck";
    case FieldOutcome::kFailed:
      return "failed";
    case FieldOutcome::kTimeout:
      return "timeout";
  }
  return "unknown";
}

double FieldRun::Score() const {
  if (!IsGood()) return 0;
  const double optimal_s = best_way.length_m / kOptimal_mps;
  return optimal_s / std::clamp(time_s, 2 * optimal_s, 8 * optimal_s);
}

absl::StatusOr<FieldRun> RunField(const FieldOptions& options,
                                  const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<FieldDrive> drive,
                      FieldDrive::Begin(options));
  while (drive->Step()) {
    if (stop.stop_requested()) return absl::CancelledError("interrupted");
  }
  return drive->Finish(options);
}

}  // namespace treeline::fields
