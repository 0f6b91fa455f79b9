#include "simulation/simulator/simulator.h"

#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/base/status_macros.h"
#include "simulation/simulator/imager.h"

namespace treeline::simulator {
namespace {

constexpr SimTime kStep = std::chrono::milliseconds(5);
static_assert(kStep.count() ==
              static_cast<int64_t>(DifferentialDrive::kStep_s * 1e9));

}  // namespace

Simulator::Simulator(std::unique_ptr<const worlds::World> world,
                     renderer::RayCaster caster,
                     const SimulatorOptions& options)
    : world_(std::move(world)),
      options_(options),
      caster_(std::move(caster)),
      terrain_(*world_),
      base_(clock_),
      stage_(*world_),
      body_(terrain_, stage_, options.robot, options.errors, options.seed) {}

absl::StatusOr<std::unique_ptr<Simulator>> Simulator::Create(
    worlds::World world, const SimulatorOptions& options) {
  TL_RETURN_IF_ERROR(options.robot.Validate());
  TL_RETURN_IF_ERROR(options.errors.Validate());
  TL_RETURN_IF_ERROR(options.sensors.Validate());
  auto owned = std::make_unique<const worlds::World>(std::move(world));
  TL_ASSIGN_OR_RETURN(renderer::RayCaster caster,
                      renderer::RayCaster::Create(*owned));
  std::shared_ptr<const Imager> imager;
  if (options.sensors.camera_hz > 0) {
    TL_ASSIGN_OR_RETURN(
        imager, MakeImager(*owned, options.seed, options.sensors.camera_scale,
                           options.sensors.camera_is_lit, options.threads));
  }
  std::unique_ptr<Simulator> simulator(
      new Simulator(std::move(owned), std::move(caster), options));
  TL_ASSIGN_OR_RETURN(
      simulator->sensors_,
      SensorSuite::Create(simulator->world(), simulator->caster_, options.robot,
                          options.errors, options.sensors, options.seed,
                          simulator->clock_, std::move(imager)));
  const absl::MutexLock lock(&simulator->mutex_);
  const RobotPlacement& start = options.start;
  TL_RETURN_IF_ERROR(
      base::Annotate(simulator->body_.PutDown(start.position, start.yaw_rad,
                                              start.height_m, SimTime(0)),
                     "start"));
  simulator->sensors_->Restart(simulator->body_, SimTime(0));
  return simulator;
}

void Simulator::Step(SimTime duration) {
  const SimTime until = clock_.now() + duration;
  while (true) {
    const absl::MutexLock lock(&mutex_);
    const SimTime end = (steps_ + 1) * kStep;
    if (end > until) break;
    StepOnce();
    clock_.Set(end);
  }
  clock_.Set(until);
}

void Simulator::StepOnce() {
  const SimTime from = steps_ * kStep;
  const SimTime until = from + kStep;
  RecordFaults(from, until);
  base_.SetLost(faults_.Has(FaultTarget::kBase, FaultKind::kSilent, from));
  body_.Step(base_.CommandAt(from), faults_.WheelsAt(from), steps_, until,
             events_);
  sensors_->Step(body_, stage_, faults_, until);
  ++steps_;
}

void Simulator::Record(SimEventKind kind, absl::string_view what) {
  const geometry::Rigid3 world_from_base = body_.stance().WorldFromBase();
  events_.push_back({.kind = kind,
                     .time = clock_.now(),
                     .point_in_world = world_from_base.translation,
                     .world_from_base = world_from_base,
                     .what = std::string(what)});
}

void Simulator::RecordFaults(SimTime from, SimTime until) {
  for (const Fault& fault : faults_.Began(from, until)) {
    Record(SimEventKind::kFaultBegan, fault.Name());
    events_.back().time = fault.start;
  }
  for (const Fault& fault : faults_.Ended(from, until)) {
    Record(SimEventKind::kFaultEnded, fault.Name());
    events_.back().time = fault.start + fault.duration;
  }
}

TrueState Simulator::state() const {
  const absl::MutexLock lock(&mutex_);
  return {.time = steps_ * kStep,
          .world_from_base = body_.stance().WorldFromBase(),
          .forward_mps = body_.forward_mps(),
          .yaw_rate_radps = body_.yaw_rate_radps(),
          .is_fallen = body_.is_fallen(),
          .is_blocked = body_.is_blocked(),
          .distance_m = body_.distance_m(),
          .turned_rad = body_.turned_rad()};
}

geometry::Rigid3 Simulator::WorldFromBaseAt(SimTime time) const {
  const absl::MutexLock lock(&mutex_);
  return sensors_->history().At(time);
}

std::vector<worlds::BodyInstance> Simulator::bodies() const {
  const absl::MutexLock lock(&mutex_);
  return stage_.InstancesAt(Seconds(clock_.now()));
}

std::vector<SimEvent> Simulator::TakeEvents() {
  const absl::MutexLock lock(&mutex_);
  return std::exchange(events_, {});
}

absl::Status Simulator::Kidnap(const RobotPlacement& placement) {
  const absl::MutexLock lock(&mutex_);
  TL_RETURN_IF_ERROR(body_.PutDown(placement.position, placement.yaw_rad,
                                   placement.height_m, clock_.now()));
  sensors_->Restart(body_, clock_.now());
  Record(SimEventKind::kPlaced, "robot");
  return absl::OkStatus();
}

absl::Status Simulator::KidnapTo(absl::string_view place) {
  std::vector<std::string> known;
  for (const worlds::NamedPlace& named : world_->places) {
    if (named.name == place) {
      const worlds::Float3 at = named.placement.origin;
      return Kidnap({.position = {at.x, at.y},
                     .yaw_rad = named.placement.yaw_rad,
                     .height_m = at.z});
    }
    known.push_back(named.name);
  }
  return absl::NotFoundError(
      absl::StrCat("the world has no place called '", place, "'; it has ",
                   known.empty() ? "none" : absl::StrJoin(known, ", ")));
}

absl::Status Simulator::Inject(Fault fault) {
  const absl::MutexLock lock(&mutex_);
  const bool at_once = fault.start == SimTime(0);
  fault.start += clock_.now();
  TL_RETURN_IF_ERROR(faults_.Add(fault));
  // Those that begin later are seen when they do.
  if (at_once && fault.start <= steps_ * kStep) {
    Record(SimEventKind::kFaultBegan, fault.Name());
  }
  return absl::OkStatus();
}

void Simulator::Repair(FaultTarget target) {
  const absl::MutexLock lock(&mutex_);
  faults_.End(target, clock_.now());
}

bool Simulator::IsServerDead() const {
  const absl::MutexLock lock(&mutex_);
  return faults_.Has(FaultTarget::kServer, FaultKind::kSilent, clock_.now());
}

void Simulator::ResetOdometry() {
  const absl::MutexLock lock(&mutex_);
  body_.drive().ResetCounters();
  Record(SimEventKind::kOdometryReset, "wheel counters");
}

absl::StatusOr<worlds::Placement> Simulator::OnGround(
    const RobotPlacement& placement) const {
  const Footing footing(terrain_, options_.robot);
  const auto height_m =
      footing.NearestGround_m(placement.position, placement.height_m);
  if (!height_m.has_value()) {
    return absl::NotFoundError(absl::StrCat(
        "no ground at ", placement.position.x, ", ", placement.position.y));
  }
  return worlds::Placement{.origin = {static_cast<float>(placement.position.x),
                                      static_cast<float>(placement.position.y),
                                      static_cast<float>(*height_m)},
                           .yaw_rad = static_cast<float>(placement.yaw_rad)};
}

absl::Status Simulator::ChangeStage(
    const std::string& what,
    const std::function<absl::Status(Stage& stage)>& change) {
  const absl::MutexLock lock(&mutex_);
  TL_RETURN_IF_ERROR(change(stage_));
  Record(SimEventKind::kObstacle, what);
  return absl::OkStatus();
}

absl::Status Simulator::AddObstacle(absl::string_view name,
                                    absl::string_view body,
                                    const RobotPlacement& placement,
                                    worlds::Float3 scale) {
  TL_ASSIGN_OR_RETURN(const worlds::Placement world_from_body,
                      OnGround(placement));
  return ChangeStage(absl::StrCat(name, " added"), [&](Stage& stage) {
    return stage.AddObstacle(name, body, world_from_body, scale);
  });
}

absl::Status Simulator::RemoveObstacle(absl::string_view name) {
  return ChangeStage(absl::StrCat(name, " removed"),
                     [&](Stage& stage) { return stage.RemoveObstacle(name); });
}

absl::Status Simulator::MoveBody(absl::string_view name,
                                 const RobotPlacement& placement) {
  TL_ASSIGN_OR_RETURN(const worlds::Placement world_from_body,
                      OnGround(placement));
  return ChangeStage(absl::StrCat(name, " moved"), [&](Stage& stage) {
    return stage.Move(name, world_from_body);
  });
}

absl::Status Simulator::TurnDoor(absl::string_view name, double angle_rad) {
  return ChangeStage(absl::StrCat(name, " turned"), [&](Stage& stage) {
    return stage.TurnDoor(name, angle_rad);
  });
}

absl::Status Simulator::ReleaseBody(absl::string_view name) {
  return ChangeStage(absl::StrCat(name, " released"),
                     [&](Stage& stage) { return stage.Release(name); });
}

void Simulator::ReportScenario(const std::string& why) {
  const absl::MutexLock lock(&mutex_);
  Record(SimEventKind::kScenario, why);
}

}  // namespace treeline::simulator
