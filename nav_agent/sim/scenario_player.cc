#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "nav_agent/sim/scenario.h"

namespace treeline {
namespace {

constexpr SimTime kSteering = std::chrono::milliseconds(50);

template <typename... Visitors>
struct Overloaded : Visitors... {
  using Visitors::operator()...;
};
template <typename... Visitors>
Overloaded(Visitors...) -> Overloaded<Visitors...>;

}  // namespace

absl::StatusOr<RobotPlacement> StartOf(const Scenario& scenario,
                                       const World& world) {
  if (scenario.start.has_value()) return *scenario.start;
  std::vector<std::string> known;
  for (const NamedPlace& place : world.places) {
    known.push_back(place.name);
    if (place.name != scenario.start_place) continue;
    const Float3 at = place.placement.origin;
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
  const Float3 from = world.tour[0];
  const Float3 way = world.tour[1] - from;
  return RobotPlacement{.position = {from.x, from.y},
                        .yaw_rad = std::atan2(way.y, way.x),
                        .height_m = from.z};
}

ScenarioPlayer::ScenarioPlayer(const Scenario& scenario, Simulator& simulator)
    : simulator_(&simulator), actions_(scenario.actions) {
  std::ranges::stable_sort(actions_, {}, &ScenarioAction::at);
}

void ScenarioPlayer::DriveTour(const TourAction& tour) {
  std::vector<Vec3> corners = tour.corners;
  if (corners.empty()) {
    for (const Float3& corner : simulator_->world().tour) {
      corners.push_back({corner.x, corner.y, corner.z});
    }
    // The world's tour is closed.
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

void ScenarioPlayer::Steer() {
  if (tour_ != nullptr) {
    const VelocityCommand command =
        tour_->CommandAt(simulator_->state().world_from_base);
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

}  // namespace treeline
