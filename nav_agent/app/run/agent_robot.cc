#include "nav_agent/app/run/agent_robot.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "common/geometry/planar_pose.h"
#include "nav_agent/app/run/clear_start.h"
#include "simulation/runs/localize_world.h"
#include "simulation/runs/lost_suite_world.h"
#include "simulation/simulator/scenario.h"
#include "simulation/simulator/scenario_player.h"
#include "simulation/simulator/simulated_battery.h"
#include "simulation/simulator/simulator.h"
#include "simulation/worlds/crate.h"

namespace treeline::run_app {
namespace {

// So far in each direction.
constexpr double kBlank_m = 30;
constexpr double kBlankCell_m = 0.1;

class RealRobot final : public AgentRobot {
 public:
  static absl::StatusOr<std::unique_ptr<AgentRobot>> Open(
      const hardware::HardwareConfig& config) {
    auto robot = std::make_unique<RealRobot>();
    robot->model_ = config.robot;
    robot->correction_ = config.correction;
    robot->noise_ = config.noise;
    robot->contacts_ = config.contacts;
    TL_ASSIGN_OR_RETURN(robot->hardware_,
                        hardware::RobotHardware::Open(config, robot->clock_));
    return robot;
  }

  behavior::NavigatorDevices Devices() override {
    return {.laser = hardware_->laser(),
            .odometry = hardware_->base(),
            .base = hardware_->base(),
            .rear_laser = hardware_->rear_laser(),
            .camera = hardware_->camera()};
  }
  const base::Clock& clock() const override { return clock_; }
  const core::RobotModel& model() const override { return model_; }
  core::SensorCorrection correction() const override { return correction_; }
  std::optional<core::MeasuredOdometryNoise> noise() const override {
    return noise_;
  }
  core::ContactEnd contacts() const override { return contacts_; }
  void Advance(std::chrono::nanoseconds /*duration*/) override {}

 private:
  base::SteadyClock clock_;
  core::RobotModel model_;
  core::SensorCorrection correction_;
  std::optional<core::MeasuredOdometryNoise> noise_;
  core::ContactEnd contacts_ = core::ContactEnd::kUnsaid;
  std::unique_ptr<hardware::RobotHardware> hardware_;
};

// A camera that a slow machine may fall behind of: it leaves pictures out, and
// what it gives is never old.
class NewestPictures final : public core::RgbdCamera {
 public:
  explicit NewestPictures(simulator::SimulatedCamera& camera)
      : camera_(camera) {}

  camera::RgbdCalibration Calibration() const override {
    return camera_.Calibration();
  }
  std::vector<core::RgbdFrame> TakeFrames() override {
    return camera_.TakeNewest();
  }
  core::DeviceHealth Health() const override { return camera_.Health(); }

 private:
  simulator::SimulatedCamera& camera_;
};

constexpr int kKidnapTries = 500;
// Between a robot that begins and people who walk past (m).
constexpr double kStartRoom_m = 0.3;
// A charger's body, narrow so that a laser that looks past it still knows the
// place, and the room between it and a docked robot (m).
constexpr double kChargerDepth_m = 0.2;
constexpr double kChargerWidth_m = 0.2;
constexpr double kChargerGap_m = 0.02;
// A slower robot does not drive.
constexpr double kStandingSpeed_mps = 0.02;

// From its middle, whichever way it stands.
double StartRoom_m(const core::RobotModel& robot) {
  return std::hypot(std::max(robot.front_m, robot.rear_m), robot.half_width_m) +
         kStartRoom_m;
}

class SimulatedAgentRobot final : public AgentRobot,
                                  public agent_service::SimulationControl {
 public:
  SimulatedAgentRobot(std::string world,
                      std::unique_ptr<simulator::Simulator> simulator,
                      runs::SuiteWorld places,
                      const geometry::Rigid3& map_from_world,
                      const SimulatedRobotOptions& options)
      : world_(std::move(world)),
        simulator_(std::move(simulator)),
        camera_(simulator_->camera()),
        places_(std::move(places)),
        map_from_world_(map_from_world),
        noise_(options.robot.noise),
        contacts_(options.robot.contacts),
        random_(options.seed, kKidnapStream),
        battery_(options.battery) {}

  behavior::NavigatorDevices Devices() override {
    return {.laser = simulator_->laser(),
            .odometry = simulator_->odometry(),
            .base = simulator_->base(),
            .rear_laser = simulator_->rear_laser(),
            .camera = simulator_->options().sensors.camera_hz > 0 ? &camera_
                                                                  : nullptr};
  }
  const base::Clock& clock() const override { return simulator_->clock(); }
  const core::RobotModel& model() const override {
    return simulator_->options().robot;
  }
  std::optional<core::MeasuredOdometryNoise> noise() const override {
    return noise_;
  }
  core::ContactEnd contacts() const override { return contacts_; }
  void Advance(std::chrono::nanoseconds duration) override {
    const geometry::Vec3 before = MapFromBase().translation;
    simulator_->Step(duration);
    const double seconds = std::chrono::duration<double>(duration).count();
    battery_.SetCharging(chargers_.Touch(MapFromBase()));
    if (battery_.is_charging()) {
      battery_.Charge(seconds);
    } else {
      battery_.Drain(seconds,
                     geometry::Norm(MapFromBase().translation - before) >
                         kStandingSpeed_mps * seconds);
    }
  }
  void SetChargers(const std::vector<PlacedDock>& docks) override;
  std::optional<core::Battery> Battery() const override {
    return core::Battery{.voltage_v = battery_.voltage_v(),
                         .charge = battery_.charge(),
                         .charging = battery_.is_charging()
                                         ? core::Charging::kYes
                                         : core::Charging::kNo};
  }

  agent_service::SimulationControl* simulation() override { return this; }
  std::string world() const override { return world_; }
  std::vector<std::string> places() const override {
    std::vector<std::string> names;
    for (const worlds::NamedPlace& place : simulator_->world().places) {
      names.push_back(place.name);
    }
    return names;
  }
  std::optional<geometry::Rigid3> TrueMapFromBase() const override {
    return MapFromBase();
  }
  std::vector<agent_service::ObstacleReport> Obstacles() const override {
    std::vector<agent_service::ObstacleReport> reports;
    for (const auto& [name, center] : obstacles_) {
      reports.push_back({name, center});
    }
    return reports;
  }
  std::vector<std::string> TakeIncidents() override {
    std::vector<std::string> incidents;
    for (const simulator::SimEvent& event : simulator_->TakeEvents()) {
      incidents.push_back(absl::StrCat(simulator::SimEventName(event.kind),
                                       event.what.empty() ? "" : ": ",
                                       event.what));
    }
    return incidents;
  }

  absl::StatusOr<geometry::Rigid3> Kidnap(
      const core::LevelPose& pose) override {
    TL_RETURN_IF_ERROR(simulator_->Kidnap(InWorld(pose)));
    return MapFromBase();
  }
  absl::StatusOr<geometry::Rigid3> KidnapTo(const std::string& place) override {
    TL_RETURN_IF_ERROR(simulator_->KidnapTo(place));
    return MapFromBase();
  }
  absl::StatusOr<geometry::Rigid3> KidnapAnywhere() override {
    absl::Status status =
        absl::FailedPreconditionError("there is no room anywhere");
    for (int i = 0; i < kKidnapTries; ++i) {
      status = simulator_->Kidnap(places_.AnyPlace(random_));
      if (status.ok()) return MapFromBase();
    }
    return status;
  }
  absl::StatusOr<std::string> AddObstacle(const core::LevelPose& pose,
                                          double size_m) override;
  absl::Status RemoveObstacle(const std::string& name) override {
    TL_RETURN_IF_ERROR(simulator_->RemoveObstacle(name));
    obstacles_.erase(name);
    return absl::OkStatus();
  }
  absl::Status InjectFault(const agent_service::RequestedFault& wish) override {
    simulator::Fault fault;
    TL_ASSIGN_OR_RETURN(fault.target, simulator::ParseFaultTarget(wish.target));
    TL_ASSIGN_OR_RETURN(fault.kind, simulator::ParseFaultKind(wish.kind));
    if (wish.duration_s > 0)
      fault.duration = simulator::FromSeconds(wish.duration_s);
    fault.amount = wish.amount;
    return simulator_->Inject(fault);
  }

 private:
  static constexpr uint64_t kKidnapStream = 0x51;

  geometry::Rigid3 MapFromBase() const {
    return map_from_world_ * simulator_->state().world_from_base;
  }
  simulator::RobotPlacement InWorld(const core::LevelPose& pose) const {
    const geometry::Rigid2& map_from_base = pose.map_from_base;
    const geometry::Rigid3 world_from_base =
        map_from_world_.Inverse() *
        geometry::Rigid3{
            .rotation = geometry::Rotation3::FromAxisAngle(
                {0, 0, map_from_base.yaw_rad}),
            .translation = {map_from_base.translation.x,
                            map_from_base.translation.y, pose.place.height_m}};
    const geometry::Rigid2 planar = geometry::PlanarPose(world_from_base);
    return {.position = planar.translation,
            .yaw_rad = planar.yaw_rad,
            .height_m = world_from_base.translation.z};
  }

  const std::string world_;
  const std::unique_ptr<simulator::Simulator> simulator_;
  NewestPictures camera_;
  const runs::SuiteWorld places_;
  const geometry::Rigid3 map_from_world_;
  const std::optional<core::MeasuredOdometryNoise> noise_;
  const core::ContactEnd contacts_;
  base::Random random_;
  simulator::SimulatedBattery battery_;
  simulator::Chargers chargers_;
  std::vector<std::string> charger_bodies_;
  int next_obstacle_ = 1;
  std::map<std::string, geometry::Vec2> obstacles_;
};

// Each has a body just beyond the robot's edge.
void SimulatedAgentRobot::SetChargers(const std::vector<PlacedDock>& docks) {
  for (const std::string& name : charger_bodies_) {
    simulator_->RemoveObstacle(name).IgnoreError();
  }
  charger_bodies_.clear();
  std::vector<simulator::Charger> chargers;
  for (const auto& [dock, height_m] : docks) {
    const geometry::Rigid2& docked = dock.map_from_docked;
    chargers.push_back({.map_from_docked = docked, .height_m = height_m});
    const double away_m = kChargerGap_m + 0.5 * kChargerDepth_m;
    const double ahead_m =
        dock.is_backward ? -model().rear_m - away_m : model().front_m + away_m;
    const std::string name = absl::StrCat("charger ", dock.name);
    const absl::Status stands = simulator_->AddObstacle(
        name, worlds::kCrate,
        InWorld({.map_from_base = docked * geometry::Rigid2{{ahead_m, 0}, 0},
                 .place = {dock.level, height_m}}),
        worlds::CrateScale(simulator_->world(), kChargerDepth_m,
                           kChargerWidth_m));
    // Where it does not, the dock still charges: a wall may be its body.
    if (stands.ok()) charger_bodies_.push_back(name);
  }
  chargers_ = simulator::Chargers(std::move(chargers));
}

absl::StatusOr<std::string> SimulatedAgentRobot::AddObstacle(
    const core::LevelPose& pose, double size_m) {
  const std::string name = absl::StrCat("obstacle-", next_obstacle_);
  const geometry::Vec2 center = pose.map_from_base.translation;
  TL_RETURN_IF_ERROR(simulator_->AddObstacle(
      name, worlds::kCrate, InWorld(pose),
      worlds::CrateScale(simulator_->world(), size_m, size_m)));
  ++next_obstacle_;
  obstacles_[name] = center;
  return name;
}

}  // namespace

absl::StatusOr<std::unique_ptr<AgentRobot>> MakeRealRobot(
    const hardware::HardwareConfig& config) {
  return RealRobot::Open(config);
}

absl::StatusOr<std::unique_ptr<AgentRobot>> MakeSimulatedRobot(
    const SimulatedRobotOptions& options) {
  simulator::Scenario scenario;
  scenario.world = options.world;
  scenario.world_options = options.world_options;
  scenario.world_options.paint = options.camera_hz > 0;
  scenario.options.seed = options.seed;
  scenario.options.sensors.camera_hz = options.camera_hz;
  scenario.options.robot = options.robot.model;
  scenario.options.sensors.UseLasers(options.robot.lasers);
  if (options.robot.noise.has_value()) {
    scenario.options.errors.UseNoise(*options.robot.noise,
                                     options.robot.model.wheel_track_m);
  }
  if (!options.has_rear_laser) scenario.options.sensors.has_rear_laser = false;
  TL_ASSIGN_OR_RETURN(worlds::World world, simulator::MakeWorldOf(scenario));
  TL_ASSIGN_OR_RETURN(
      runs::SuiteWorld places,
      runs::SuiteWorld::Create(
          world, scenario.options.robot.base_from_laser.translation.z));
  const simulator::RobotPlacement start = scenario.options.start;
  const double room_m = StartRoom_m(options.robot.model);
  KeepOffStart(start.position, room_m, world);
  if (options.start_at.has_value()) {
    const geometry::Rigid2 world_from_map =
        options.map_begins_at_start
            ? geometry::Rigid2{start.position, start.yaw_rad}
            : geometry::Rigid2{};
    KeepOffStart(world_from_map * *options.start_at, room_m, world);
  }
  TL_ASSIGN_OR_RETURN(
      std::unique_ptr<simulator::Simulator> simulator,
      simulator::Simulator::Create(std::move(world), scenario.options));
  geometry::Rigid3 map_from_world;
  if (options.map_begins_at_start) {
    // The map's frame is level, whatever the ground is like at the start.
    map_from_world =
        geometry::Rigid3{
            .rotation =
                geometry::Rotation3::FromAxisAngle({0, 0, start.yaw_rad}),
            .translation = simulator->state().world_from_base.translation}
            .Inverse();
  }
  return std::make_unique<SimulatedAgentRobot>(
      options.world, std::move(simulator), std::move(places), map_from_world,
      options);
}

absl::StatusOr<behavior::NavigatorMap> MapOfWorld(const std::string& name) {
  TL_ASSIGN_OR_RETURN(
      const worlds::World world,
      worlds::MakeWorld(name, {.with_people = false, .paint = false}));
  constexpr double kResolution_m = 0.05;
  behavior::NavigatorMap map;
  TL_ASSIGN_OR_RETURN(map.voxels, runs::VoxelsOfWorld(world, kResolution_m));
  TL_ASSIGN_OR_RETURN(map.levels,
                      traversability::ExtractTraversableMap(map.voxels));
  return map;
}

behavior::NavigatorMap BlankMap() {
  const int side = static_cast<int>(2 * kBlank_m / kBlankCell_m);
  traversability::TraversableLevel level;
  level.grid = core::OccupancyGrid::Filled(side, side, kBlankCell_m,
                                           {{-kBlank_m, -kBlank_m}, 0},
                                           core::Occupancy::kFree);
  level.height_m.assign(level.grid.cells.size(), 0);
  level.slope_rad.assign(level.grid.cells.size(), 0);
  level.clearance_m.assign(level.grid.cells.size(), 3);
  behavior::NavigatorMap map;
  map.levels.levels.push_back(std::move(level));
  return map;
}

}  // namespace treeline::run_app
