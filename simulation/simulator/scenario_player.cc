#include "simulation/simulator/scenario_player.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/base/status_macros.h"

namespace treeline::simulator {
namespace {

// How near something beside the robot may be that it drives past.
constexpr double kPassing_m = 0.15;

constexpr SimTime kSteering = std::chrono::milliseconds(50);

template <typename... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};
template <typename... Visitors>
Overloaded(Visitors...) -> Overloaded<Visitors...>;

// Whether a body ever leaves its place: people and carts do, doors do not.
bool Travels(const worlds::Body& body) {
  if (!body.motion.has_value()) return false;
  const std::vector<worlds::Motion::Key>& keys = body.motion->keys;
  return std::ranges::any_of(keys, [&keys](const worlds::Motion::Key& key) {
    return key.world_from_body.origin != keys[0].world_from_body.origin;
  });
}

// The first corner of the tour where nobody stands as the simulation begins.
size_t FirstFreeCorner(const worlds::World& world) {
  constexpr float kRoom_m = 0.6f;
  constexpr float kStorey_m = 1.5f;
  const std::vector<worlds::BodyInstance> bodies = world.InstancesAt(0);
  for (size_t i = 0; i < world.tour.size(); ++i) {
    bool is_free = true;
    for (const worlds::BodyInstance& body : bodies) {
      const worlds::Float3 away = body.world_from_body.origin - world.tour[i];
      const float radius_m =
          world.bodies[static_cast<size_t>(body.body)].radius_m;
      is_free &= std::abs(away.z) > kStorey_m ||
                 std::hypot(away.x, away.y) > radius_m + kRoom_m;
    }
    if (is_free) return i;
  }
  return 0;
}

}  // namespace

absl::StatusOr<RobotPlacement> StartOf(const Scenario& scenario,
                                       const worlds::World& world) {
  if (scenario.start.has_value()) return *scenario.start;
  std::vector<std::string> known;
  for (const worlds::NamedPlace& place : world.places) {
    known.push_back(place.name);
    if (place.name != scenario.start_place) continue;
    const worlds::Float3 at = place.placement.origin;
    return RobotPlacement{.position = {at.x, at.y},
                          .yaw_rad = place.placement.yaw_rad,
                          .height_m = at.z};
  }
  if (!scenario.start_place.empty()) {
    return absl::NotFoundError(absl::StrCat(
        "world '", world.name, "' has no place called '", scenario.start_place,
        "'; it has ", known.empty() ? "none" : absl::StrJoin(known, ", ")));
  }
  if (world.tour.size() < 2) {
    return absl::FailedPreconditionError(
        absl::StrCat("world '", world.name,
                     "' has no tour to start at; say where to start"));
  }
  const size_t corner = FirstFreeCorner(world);
  const worlds::Float3 from = world.tour[corner];
  const worlds::Float3 way =
      world.tour[(corner + 1) % world.tour.size()] - from;
  return RobotPlacement{.position = {from.x, from.y},
                        .yaw_rad = std::atan2(way.y, way.x),
                        .height_m = from.z};
}

absl::StatusOr<worlds::World> MakeWorldOf(Scenario& scenario) {
  TL_ASSIGN_OR_RETURN(
      worlds::World world,
      worlds::MakeWorld(scenario.world, scenario.world_options));
  TL_ASSIGN_OR_RETURN(scenario.options.start, StartOf(scenario, world));
  return world;
}

ScenarioPlayer::ScenarioPlayer(const Scenario& scenario, Simulator& simulator)
    : simulator_(&simulator), actions_(scenario.actions) {
  std::ranges::stable_sort(actions_, {}, &ScenarioAction::at);
}

void ScenarioPlayer::DriveTour(const TourAction& tour) {
  std::vector<geometry::Vec3> corners = tour.corners;
  if (corners.empty()) {
    for (const worlds::Float3& corner : simulator_->world().tour) {
      corners.push_back({corner.x, corner.y, corner.z});
    }
    // The world's tour is closed: it begins wherever the robot is.
    const geometry::Vec3 here = simulator_->state().world_from_base.translation;
    const auto nearest = std::ranges::min_element(
        corners, {},
        [&here](geometry::Vec3 corner) { return Norm(corner - here); });
    std::rotate(corners.begin(), nearest, corners.end());
    if (!corners.empty()) corners.push_back(corners.front());
  }
  if (corners.empty()) {
    simulator_->ReportScenario("the world has no tour to drive along");
    return;
  }
  command_.reset();
  tour_ = std::make_unique<TourDriver>(std::move(corners), tour.options);
}

absl::Status ScenarioPlayer::DoKidnap(const KidnapAction& kidnap) {
  const absl::Status done = kidnap.placement.has_value()
                                ? simulator_->Kidnap(*kidnap.placement)
                                : simulator_->KidnapTo(kidnap.place);
  if (done.ok() && tour_ != nullptr) {
    tour_->JoinNearest(simulator_->state().world_from_base.translation);
  }
  return done;
}

void ScenarioPlayer::Do(const ScenarioAction& action) {
  Simulator& sim = *simulator_;
  const absl::Status done = std::visit(
      Overloaded{
          [&](const DriveAction& drive) {
            tour_ = nullptr;
            command_ = drive.command;
            command_end_ = action.at + drive.duration;
            return absl::OkStatus();
          },
          [&](const TourAction& tour) {
            DriveTour(tour);
            return absl::OkStatus();
          },
          [&](const StopAction&) {
            tour_ = nullptr;
            command_.reset();
            sim.base().Stop();
            return absl::OkStatus();
          },
          [&](const KidnapAction& kidnap) { return DoKidnap(kidnap); },
          [&](const FaultAction& fault) { return sim.Inject(fault.fault); },
          [&](const ResetOdometryAction&) {
            sim.ResetOdometry();
            return absl::OkStatus();
          },
          [&](const AddObstacleAction& add) {
            return sim.AddObstacle(add.name, add.body, add.placement,
                                   add.scale);
          },
          [&](const RemoveObstacleAction& remove) {
            return sim.RemoveObstacle(remove.name);
          },
          [&](const MoveBodyAction& move) {
            return sim.MoveBody(move.name, move.placement);
          },
          [&](const DoorAction& door) {
            return sim.TurnDoor(door.name, door.angle_rad);
          },
          [&](const ReleaseAction& release) {
            return sim.ReleaseBody(release.name);
          }},
      action.what);
  if (done.ok()) return;
  const std::string line =
      action.line > 0 ? absl::StrCat("line ", action.line, ": ") : "";
  sim.ReportScenario(absl::StrCat(line, done.message()));
}

bool ScenarioPlayer::IsWayTaken() const {
  const double reach_m = tour_->options().give_way_m;
  if (reach_m <= 0) return false;
  const core::RobotModel& robot = simulator_->options().robot;
  const geometry::Rigid3 base_from_world =
      simulator_->state().world_from_base.Inverse();
  for (const worlds::BodyInstance& instance : simulator_->bodies()) {
    const worlds::Body& body =
        simulator_->world().bodies[static_cast<size_t>(instance.body)];
    if (!Travels(body)) continue;
    const worlds::Float3 origin = instance.world_from_body.origin;
    const geometry::Vec3 at =
        base_from_world * geometry::Vec3{origin.x, origin.y, origin.z};
    const double radius_m =
        body.radius_m * std::max(instance.scale.x, instance.scale.y);
    if (at.z < robot.height_m && at.z + body.height_m > 0 && at.x > 0 &&
        at.x < robot.front_m + radius_m + reach_m &&
        std::abs(at.y) < robot.half_width_m + radius_m + kPassing_m) {
      return true;
    }
  }
  return false;
}

void ScenarioPlayer::Steer() {
  if (tour_ != nullptr) {
    const core::VelocityCommand command =
        IsWayTaken() ? core::VelocityCommand()
                     : tour_->CommandAt(simulator_->state().world_from_base);
    // Refused while the base is lost; then it stands.
    simulator_->base().SetVelocity(command).IgnoreError();
  } else if (command_.has_value() && simulator_->now() < command_end_) {
    simulator_->base().SetVelocity(*command_).IgnoreError();
  } else if (command_.has_value()) {
    command_.reset();
    simulator_->base().Stop();
  }
}

void ScenarioPlayer::Step(SimTime duration) {
  const SimTime until = simulator_->now() + duration;
  while (true) {
    const SimTime now = simulator_->now();
    while (next_action_ < actions_.size() && actions_[next_action_].at <= now) {
      Do(actions_[next_action_++]);
      next_steering_ = now;
    }
    if (now >= next_steering_) {
      Steer();
      next_steering_ = now + kSteering;
    }
    if (now >= until) return;
    SimTime next = std::min(until, next_steering_);
    if (next_action_ < actions_.size()) {
      next = std::min(next, actions_[next_action_].at);
    }
    simulator_->Step(next - now);
  }
}

}  // namespace treeline::simulator
