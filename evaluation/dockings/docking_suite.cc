#include "evaluation/dockings/docking_suite.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "common/geometry/planar_pose.h"
#include "evaluation/suites/suite_people.h"
#include "nav_agent/docking/dock_pilot.h"
#include "nav_agent/docking/parameters.h"
#include "simulation/simulator/simulated_battery.h"
#include "simulation/worlds/crate.h"

namespace treeline::dockings {
namespace {

constexpr uint64_t kDockStream = 210;
constexpr int kTries = 4000;
constexpr int kHeadings = 8;
constexpr double kMinWay_m = 3;
// Room about the robot that drives in, and turns at its staging pose (m).
constexpr double kBesideDock_m = 0.15;
// Behind a dock there is something at this distance (m), for most of the tries.
constexpr double kBehind_m = 0.5;
constexpr double kChargerDepth_m = 0.2;
constexpr double kChargerWidth_m = 0.2;
constexpr double kWideCharger_m = 0.62;
constexpr double kGap_m = 0.02;
constexpr double kNicheGap_m = 0.17;
constexpr double kNicheStaging_m = 1.2;
constexpr double kNicheWall_m = 0.1;
constexpr double kMoved_m = 0.05;
constexpr double kBlock_m = 0.3;
constexpr double kBlockedFor_s = 20;
// Until a robot has looked from its dock, and it must stay what it is (s).
constexpr double kMake_s = 0.3;
constexpr double kLook_s = 4;
constexpr double kStay_s = 20;
constexpr double kPatience_s = 120;
constexpr double kPatience_spm = 8;
constexpr double kOutPatience_s = 60;
constexpr double kSettle_s = 0.5;
// People walk across the robot's line as far before the docked pose, from this
// far beside it to the other side (m), this fast, and wait there (m/s, s).
constexpr double kPassersBefore_m[] = {0.5, 1.0};
constexpr double kPassersAside_m = 1.2;
constexpr double kPassersWalk_mps = 0.8;
constexpr double kPassersWait_s = 3;
// Somebody stands so far before where the robot's edge is when it is docked.
constexpr double kPersonBefore_m = 0.3;
constexpr char kName[] = "dock";

struct Scene {
  const char* name;
  bool is_backward = false;
  bool is_moved = false;
  bool is_wide = false;
  bool is_niche = false;
  bool is_blocked = false;
  // What blocks it is somebody; who stays; two walk across its way.
  bool has_person = false;
  bool stays = false;
  bool has_passers = false;
  // It is carried away while it charges, and charges there by a cable.
  bool is_carried = false;
  bool has_cable = false;

  bool HasPeople() const { return has_person || has_passers; }
};
constexpr Scene kScenes[] = {
    {.name = "plain"},
    {.name = "backward", .is_backward = true},
    {.name = "moved", .is_moved = true},
    {.name = "wide", .is_wide = true},
    {.name = "niche", .is_niche = true},
    {.name = "blocked", .is_blocked = true},
    {.name = "visitor", .is_blocked = true, .has_person = true},
    {.name = "occupied", .is_blocked = true, .has_person = true, .stays = true},
    {.name = "passers", .has_passers = true},
    {.name = "carried", .is_carried = true},
    {.name = "cable", .is_carried = true, .has_cable = true}};

absl::StatusOr<Scene> SceneOf(const std::string& name) {
  if (name.empty()) return kScenes[0];
  for (const Scene& scene : kScenes) {
    if (scene.name == name) return scene;
  }
  return absl::NotFoundError(
      absl::StrCat("no scene is called '", name, "'; there are ",
                   absl::StrJoin(DockingScenes(), ", ")));
}

simulator::RobotPlacement Ahead(const simulator::RobotPlacement& from,
                                double x_m, double y_m) {
  const geometry::Rigid2 at = geometry::Rigid2{from.position, from.yaw_rad} *
                              geometry::Rigid2{{x_m, y_m}, 0};
  return {.position = at.translation,
          .yaw_rad = at.yaw_rad,
          .height_m = from.height_m};
}

// A robot, its dock and all that stands there.
class DockYard {
 public:
  DockYard(const suites::SuitePlace& place, const DockingSuiteOptions& options,
           const Scene& scene)
      : place_(place), options_(options), scene_(scene) {}

  // Where the dock and the robot's way begin. FAILED_PRECONDITION: no room.
  absl::Status Draw();
  // The robot in its dock, told where it is.
  absl::Status Begin();
  // It looks from there, and is carried to where it starts.
  absl::Status LookAndLeave();
  // Started anew in its dock, and told nothing. It must know where it is.
  absl::Status WakeUp();
  // Charges in its dock, is carried to where it starts, and stands there.
  absl::Status CarryAway();
  absl::Status DriveIn(const std::stop_token& stop);
  absl::Status DriveOut(const std::stop_token& stop);
  void Summarize();
  DockingRun& run() { return run_; }

 private:
  bool HasRoom(const simulator::RobotPlacement& dock) const;
  double ClearanceAt_m(const simulator::RobotPlacement& at) const;
  absl::Status Make(const simulator::RobotPlacement& start);
  absl::Status PutThings();
  absl::Status PutBlock();
  absl::Status AddPassers(worlds::World& world) const;
  // Where who walks across the line goes to and fro.
  std::pair<simulator::RobotPlacement, simulator::RobotPlacement> WayAcross(
      const simulator::RobotPlacement& dock, double before_m) const;
  absl::Status PutCrate(const std::string& name,
                        const simulator::RobotPlacement& at, double length_m,
                        double width_m);
  void Step();
  void StepFor(double seconds);
  DockMiss MissNow() const;
  // Towards the dock.
  double Sign() const { return scene_.is_backward ? -1 : 1; }
  double Edge_m() const {
    return scene_.is_backward ? model_.rear_m : model_.front_m;
  }

  // Out of a niche it must come before it can turn.
  double Staging_m() const {
    return scene_.is_niche ? kNicheStaging_m
                           : docking::DefaultStaging_m(model_);
  }

  const suites::SuitePlace& place_;
  const DockingSuiteOptions& options_;
  const Scene scene_;
  const core::RobotModel model_;
  DockingRun run_;
  std::unique_ptr<suites::SuiteRobot> robot_;
  std::optional<docking::DockPilot> pilot_;
  docking::Dock dock_;
  // The true docked pose now.
  geometry::Rigid2 world_from_docked_;
  std::vector<behavior::NavigatorEvent> dock_events_;
  // It is plugged into something that is no dock.
  bool is_plugged_ = false;
};

double DockYard::ClearanceAt_m(const simulator::RobotPlacement& at) const {
  const absl::StatusOr<core::LevelPose> pose = place_.InMap(at);
  return pose.ok() ? place_.ClearanceInMap_m(*pose) : 0;
}

bool DockYard::HasRoom(const simulator::RobotPlacement& dock) const {
  const double staging_m = Staging_m();
  for (double back_m = 0; back_m <= staging_m; back_m += 0.1) {
    const bool turns = back_m > staging_m - 0.2;
    const double needed_m =
        (turns ? model_.Circumradius_m() : model_.half_width_m) + kBesideDock_m;
    if (ClearanceAt_m(Ahead(dock, -Sign() * back_m, 0)) < needed_m) {
      return false;
    }
  }
  return !scene_.has_passers ||
         std::ranges::all_of(kPassersBefore_m, [&](double before_m) {
           const auto [from, to] = WayAcross(dock, before_m);
           return place_.IsStraightWay(from, to);
         });
}

std::pair<simulator::RobotPlacement, simulator::RobotPlacement>
DockYard::WayAcross(const simulator::RobotPlacement& dock,
                    double before_m) const {
  const double along_m = -Sign() * (before_m + model_.rear_m);
  return {Ahead(dock, along_m, kPassersAside_m),
          Ahead(dock, along_m, -kPassersAside_m)};
}

absl::Status DockYard::AddPassers(worlds::World& world) const {
  const int person = suites::PersonOf(world);
  if (person < 0) {
    return absl::FailedPreconditionError(
        absl::StrCat("nobody is about in world ", world.name));
  }
  double wait_s = kPassersWait_s;
  for (const double before_m : kPassersBefore_m) {
    const auto [from, to] = WayAcross(run_.dock, before_m);
    worlds::Body passer = world.bodies[static_cast<size_t>(person)];
    passer.name = absl::StrCat("passer ", before_m);
    passer.motion = suites::ToAndFro(from, to, kPassersWalk_mps, wait_s);
    world.bodies.push_back(std::move(passer));
    // Not in step.
    wait_s += 1;
  }
  return absl::OkStatus();
}

absl::Status DockYard::Draw() {
  base::Random random(options_.seed, kDockStream);
  for (int i = 0; i < kTries; ++i) {
    simulator::RobotPlacement dock = place_.AnyPlace(random);
    dock.yaw_rad = 2 * std::numbers::pi * (i % kHeadings) / kHeadings;
    const bool is_before_wall =
        ClearanceAt_m(Ahead(dock, Sign() * (Edge_m() + kBehind_m), 0)) <= 0.05;
    if ((!is_before_wall && i < kTries / 2) || !HasRoom(dock)) continue;
    const simulator::RobotPlacement start = place_.AnyPlace(random);
    const auto way_m =
        place_.PathLength_m(start, Ahead(dock, -Sign() * Staging_m(), 0));
    if (!way_m.has_value() || *way_m < kMinWay_m) continue;
    run_.dock = dock;
    run_.start = start;
    world_from_docked_ = {dock.position, dock.yaw_rad};
    return absl::OkStatus();
  }
  return absl::FailedPreconditionError(
      absl::StrCat("world ", place_.world().name, " has no room for a dock"));
}

absl::Status DockYard::PutCrate(const std::string& name,
                                const simulator::RobotPlacement& at,
                                double length_m, double width_m) {
  return robot_->simulator().AddObstacle(
      name, worlds::kCrate, at,
      worlds::CrateScale(robot_->simulator().world(), length_m, width_m));
}

absl::Status DockYard::PutThings() {
  const simulator::RobotPlacement docked = {
      .position = world_from_docked_.translation,
      .yaw_rad = world_from_docked_.yaw_rad,
      .height_m = run_.dock.height_m};
  const double ahead_m = Edge_m() + kGap_m + 0.5 * kChargerDepth_m;
  TL_RETURN_IF_ERROR(
      PutCrate("charger", Ahead(docked, Sign() * ahead_m, 0), kChargerDepth_m,
               scene_.is_wide ? kWideCharger_m : kChargerWidth_m));
  if (!scene_.is_niche) return absl::OkStatus();
  const double aside_m = model_.half_width_m + kNicheGap_m + 0.5 * kNicheWall_m;
  for (const double side : {-1.0, 1.0}) {
    TL_RETURN_IF_ERROR(PutCrate(absl::StrCat("side", side),
                                Ahead(docked, 0, side * aside_m),
                                model_.front_m + model_.rear_m, kNicheWall_m));
  }
  return absl::OkStatus();
}

absl::Status DockYard::PutBlock() {
  if (!scene_.has_person) {
    return PutCrate("block",
                    Ahead(run_.dock, Sign() * (Edge_m() - 0.5 * kBlock_m), 0),
                    kBlock_m, kBlock_m);
  }
  const worlds::World& world = robot_->simulator().world();
  const int person = suites::PersonOf(world);
  if (person < 0) {
    return absl::FailedPreconditionError(
        absl::StrCat("nobody is about in world ", world.name));
  }
  return robot_->simulator().AddObstacle(
      "block", world.bodies[static_cast<size_t>(person)].name,
      Ahead(run_.dock, Sign() * (Edge_m() - kPersonBefore_m), 0), {1, 1, 1});
}

absl::Status DockYard::Make(const simulator::RobotPlacement& start) {
  worlds::World world = place_.world();
  if (scene_.has_passers) TL_RETURN_IF_ERROR(AddPassers(world));
  TL_ASSIGN_OR_RETURN(robot_, suites::SuiteRobot::Create(
                                  place_, std::move(world),
                                  {.start = start,
                                   .seed = options_.seed,
                                   .has_rear_laser = options_.has_rear_laser,
                                   .navigator = options_.navigator}));
  pilot_.emplace(model_);
  return PutThings();
}

absl::Status DockYard::Begin() {
  TL_RETURN_IF_ERROR(Make(run_.dock));
  TL_ASSIGN_OR_RETURN(const core::LevelPose pose, place_.InMap(run_.dock));
  TL_RETURN_IF_ERROR(robot_->Tell(pose));
  StepFor(kMake_s);
  // As somebody makes it who has driven the robot into it.
  const std::optional<localization::TrackedPose> here =
      robot_->navigator().Snapshot().pose;
  if (!here.has_value()) return absl::InternalError("no pose");
  dock_ = {.name = kName,
           .map_from_docked = here->pose.map_from_base,
           .level = here->pose.place.level,
           .is_backward = scene_.is_backward,
           .staging_m = Staging_m()};
  return absl::OkStatus();
}

absl::Status DockYard::LookAndLeave() {
  pilot_->SetDocks(
      std::make_shared<const std::vector<docking::Dock>>(1, dock_));
  StepFor(kLook_s);
  if (options_.by_sight) dock_ = pilot_->docks()->front();
  pilot_->SetDocks(
      std::make_shared<const std::vector<docking::Dock>>(1, dock_));
  if (scene_.is_moved) {
    const double side = options_.seed % 2 == 0 ? 1 : -1;
    world_from_docked_ =
        world_from_docked_ *
        geometry::Rigid2{options_.seed % 4 < 2
                             ? geometry::Vec2{side * kMoved_m, 0}
                             : geometry::Vec2{0, side * kMoved_m},
                         0};
    TL_RETURN_IF_ERROR(robot_->simulator().RemoveObstacle("charger"));
    TL_RETURN_IF_ERROR(PutThings());
  }
  TL_RETURN_IF_ERROR(robot_->simulator().Kidnap(run_.start));
  TL_ASSIGN_OR_RETURN(const core::LevelPose start, place_.InMap(run_.start));
  TL_RETURN_IF_ERROR(robot_->Tell(start));
  StepFor(1);
  return absl::OkStatus();
}

absl::Status DockYard::CarryAway() {
  is_plugged_ = true;
  pilot_->SetDocks(
      std::make_shared<const std::vector<docking::Dock>>(1, dock_));
  StepFor(kLook_s);
  dock_ = pilot_->docks()->front();
  TL_RETURN_IF_ERROR(robot_->simulator().Kidnap(run_.start));
  // From the first step on: batteries tell late that they do not charge.
  is_plugged_ = scene_.has_cable;
  const double carried_s = robot_->now_s();
  while (robot_->now_s() < carried_s + kStay_s) {
    const double before_s = robot_->now_s();
    Step();
    const behavior::NavigatorMode mode = robot_->navigator().mode();
    const bool is_lost = mode == behavior::NavigatorMode::kLost ||
                         mode == behavior::NavigatorMode::kRelocalizing ||
                         mode == behavior::NavigatorMode::kNeedHelp;
    const std::optional<suites::PoseMiss> error = robot_->EstimateError();
    if (!is_lost && error.has_value() && !error->IsRight()) {
      run_.believed_s += robot_->now_s() - before_s;
    }
  }
  // Now it can be sent.
  is_plugged_ = false;
  return absl::OkStatus();
}

absl::Status DockYard::WakeUp() {
  pilot_->SetDocks(
      std::make_shared<const std::vector<docking::Dock>>(1, dock_));
  StepFor(kLook_s);
  const docking::Docks docks = pilot_->docks();
  TL_RETURN_IF_ERROR(Make(run_.dock));
  pilot_->SetDocks(docks);
  StepFor(kStay_s);
  run_.miss = MissNow();
  run_.outcome =
      robot_->EstimateError().has_value() &&
              robot_->EstimateError()->distance_m <= docking::kAtDock_m
          ? DockingSuiteOutcome::kExact
          : DockingSuiteOutcome::kFailed;
  run_.estimate_off_m =
      robot_->EstimateError().value_or(suites::PoseMiss{}).distance_m;
  return absl::OkStatus();
}

void DockYard::Step() {
  robot_->Step();
  std::optional<core::Battery> battery;
  if (options_.has_contacts || scene_.is_wide || scene_.is_niche ||
      scene_.is_carried) {
    const simulator::Chargers chargers({{.map_from_docked = world_from_docked_,
                                         .height_m = run_.dock.height_m}});
    const bool touches =
        chargers.Touch(robot_->simulator().state().world_from_base);
    battery = {.charge = 0.5,
               .charging = touches || is_plugged_ ? core::Charging::kYes
                                                  : core::Charging::kNo};
  }
  pilot_->Step(robot_->navigator(), robot_->simulator().clock().Now(), battery);
  for (behavior::NavigatorEvent& event : pilot_->TakeEvents()) {
    dock_events_.push_back(std::move(event));
  }
}

void DockYard::StepFor(double seconds) {
  for (const double until_s = robot_->now_s() + seconds;
       robot_->now_s() < until_s;) {
    Step();
  }
}

DockMiss DockYard::MissNow() const {
  docking::Dock dock = dock_;
  dock.map_from_docked = world_from_docked_;
  return docking::OffsetFrom(
      dock, geometry::PlanarPose(robot_->record().final_state.world_from_base));
}

absl::Status DockYard::DriveIn(const std::stop_token& stop) {
  const auto way_m = place_.PathLength_m(run_.start, run_.dock);
  const double began_s = robot_->now_s();
  double until_s = began_s + kPatience_s + kPatience_spm * way_m.value_or(10);
  TL_RETURN_IF_ERROR(pilot_->Begin(robot_->navigator(), dock_).status());
  std::optional<double> blocked_s;
  while (pilot_->IsUnderWay() && robot_->now_s() < until_s) {
    if (stop.stop_requested()) return absl::CancelledError("interrupted");
    Step();
    const bool drives_in =
        pilot_->status().state == docking::DockingState::kDrivingIn;
    if (scene_.is_blocked && drives_in && !blocked_s.has_value()) {
      blocked_s = robot_->now_s();
      TL_RETURN_IF_ERROR(PutBlock());
    }
    if (blocked_s.has_value() && !scene_.stays &&
        robot_->now_s() > *blocked_s + kBlockedFor_s &&
        robot_->simulator().RemoveObstacle("block").ok()) {
      until_s += kBlockedFor_s;
    }
  }
  run_.docking_s = robot_->now_s() - began_s;
  run_.failed_tries = pilot_->status().failed_tries;
  StepFor(kSettle_s);
  run_.miss = MissNow();
  run_.estimate_off_m =
      robot_->EstimateError().value_or(suites::PoseMiss{}).distance_m;
  run_.why = pilot_->status().why;
  if (pilot_->status().outcome == docking::DockingOutcome::kUnderWay) {
    run_.outcome = DockingSuiteOutcome::kTimeout;
  } else if (pilot_->status().outcome != docking::DockingOutcome::kSucceeded) {
    run_.outcome = DockingSuiteOutcome::kFailed;
  } else {
    const bool is_exact =
        std::hypot(run_.miss.along_m, run_.miss.aside_m) <=
            docking::kTolerance_m &&
        std::abs(run_.miss.turned_rad) <= docking::kTolerance_rad;
    run_.outcome =
        is_exact ? DockingSuiteOutcome::kExact : DockingSuiteOutcome::kInexact;
  }
  return absl::OkStatus();
}

absl::Status DockYard::DriveOut(const std::stop_token& stop) {
  if (run_.outcome != DockingSuiteOutcome::kExact &&
      run_.outcome != DockingSuiteOutcome::kInexact) {
    return absl::OkStatus();
  }
  const double until_s = robot_->now_s() + kOutPatience_s;
  if (pilot_->DriveOut(robot_->navigator()).ok()) {
    while (pilot_->status().state == docking::DockingState::kDrivingOut &&
           robot_->now_s() < until_s) {
      if (stop.stop_requested()) return absl::CancelledError("interrupted");
      Step();
    }
  }
  if (-MissNow().along_m < dock_.staging_m - 2 * docking::kAtDock_m) {
    run_.outcome = DockingSuiteOutcome::kStuck;
  }
  return absl::OkStatus();
}

void DockYard::Summarize() {
  const std::string why = run_.why;
  suites::Summarize(*robot_, run_.dock, run_);
  if (!why.empty()) run_.why = why;
  run_.scene = scene_.name;
  run_.was_carried = scene_.is_carried;
  run_.can_dock = !scene_.stays;
  run_.false_losses = static_cast<int>(std::ranges::count(
      run_.events, std::string("lost"), &behavior::NavigatorEvent::kind));
  std::ranges::move(dock_events_, std::back_inserter(run_.events));
  std::ranges::stable_sort(run_.events, {}, &behavior::NavigatorEvent::stamp);
}

}  // namespace

const char* DockingSuiteOutcomeName(DockingSuiteOutcome outcome) {
  switch (outcome) {
    case DockingSuiteOutcome::kExact:
      return "exact";
    case DockingSuiteOutcome::kInexact:
      return "inexact";
    case DockingSuiteOutcome::kFailed:
      return "failed";
    case DockingSuiteOutcome::kTimeout:
      return "timeout";
    case DockingSuiteOutcome::kStuck:
      return "stuck";
  }
  return "unknown";
}

bool HasPeople(const std::string& scene) {
  const absl::StatusOr<Scene> found = SceneOf(scene);
  return found.ok() && found->HasPeople();
}

std::vector<std::string> DockingScenes() {
  std::vector<std::string> names;
  for (const Scene& scene : kScenes) names.emplace_back(scene.name);
  return names;
}

absl::StatusOr<DockingRun> RunDocking(const suites::SuitePlace& place,
                                      const DockingSuiteOptions& options,
                                      const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(const Scene scene, SceneOf(options.scene));
  if (stop.stop_requested()) return absl::CancelledError("interrupted");
  DockYard yard(place, options, scene);
  TL_RETURN_IF_ERROR(yard.Draw());
  TL_RETURN_IF_ERROR(yard.Begin());
  if (scene.is_wide) {
    TL_RETURN_IF_ERROR(yard.WakeUp());
  } else {
    TL_RETURN_IF_ERROR(scene.is_carried ? yard.CarryAway()
                                        : yard.LookAndLeave());
    TL_RETURN_IF_ERROR(yard.DriveIn(stop));
  }
  TL_RETURN_IF_ERROR(yard.DriveOut(stop));
  yard.Summarize();
  return std::move(yard.run());
}

}  // namespace treeline::dockings
