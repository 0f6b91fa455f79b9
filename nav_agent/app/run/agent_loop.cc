#include "nav_agent/app/run/agent_loop.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/clock.h"

namespace treeline::run_app {
namespace {

// How long a robot is told to stand before its drivers end (robot's time).
constexpr double kStandFor_s = 0.5;
// Between looks at a stop that was requested.
constexpr auto kLongestSleep = std::chrono::milliseconds(20);

base::MonotonicTime::duration FromSeconds(double seconds) {
  return std::chrono::duration_cast<base::MonotonicTime::duration>(
      std::chrono::duration<double>(seconds));
}

base::MonotonicTime::duration PeriodOf(const AgentLoopOptions& options) {
  if (std::isinf(options.speed)) return {};
  return FromSeconds(1 / (options.control_hz * options.speed));
}

agent_service::DeviceReport Report(const char* name,
                                   const core::DeviceHealth& health) {
  agent_service::DeviceReport report{
      .name = name, .state = "running", .cause = ""};
  if (health.state == core::DeviceState::kStarting) report.state = "starting";
  if (health.state == core::DeviceState::kLost) report.state = "lost";
  if (!health.cause.ok()) report.cause = std::string(health.cause.message());
  return report;
}

}  // namespace

base::MonotonicTime StepTimer::NextDue(base::MonotonicTime now) {
  if (!due_.has_value()) due_ = now;
  return period_ == base::MonotonicTime::duration::zero() ? now : *due_;
}

bool StepTimer::Begin(base::MonotonicTime now) {
  if (!due_.has_value()) due_ = now;
  const bool is_late =
      period_ > base::MonotonicTime::duration::zero() && now - *due_ >= period_;
  // What is lost is lost: no burst of steps follows.
  due_ = (is_late ? now : *due_) + period_;
  return !is_late;
}

absl::Status AgentLoopOptions::Validate() const {
  if (!(control_hz >= 10 && control_hz <= 200)) {
    return absl::InvalidArgumentError(
        absl::StrCat("control_hz is ", control_hz, "; it must be 10..200"));
  }
  if (!(speed > 0)) {
    return absl::InvalidArgumentError(
        absl::StrCat("speed is ", speed, "; it must be above 0"));
  }
  if (!(duration_s >= 0)) {
    return absl::InvalidArgumentError("the duration is below 0");
  }
  if (!(publish_hz >= 0.1 && publish_hz <= control_hz)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "publish_hz is ", publish_hz, "; it must be 0.1..", control_hz));
  }
  return absl::OkStatus();
}

std::vector<agent_service::DeviceReport> ReportDevices(
    const behavior::NavigatorDevices& devices,
    const agent_service::WatchedServer* server) {
  std::vector<agent_service::DeviceReport> reports = {
      Report("laser", devices.laser.Health()),
      Report("odometry", devices.odometry.Health()),
      Report("base", devices.base.Health())};
  if (devices.rear_laser != nullptr) {
    reports.push_back(Report("rear laser", devices.rear_laser->Health()));
  }
  if (devices.camera != nullptr) {
    reports.push_back(Report("camera", devices.camera->Health()));
  }
  if (server != nullptr) {
    const absl::Status error = server->last_error();
    reports.push_back({.name = "server",
                       .state = error.ok() ? "running" : "lost",
                       .cause = std::string(error.message())});
  }
  return reports;
}

AgentLoop::AgentLoop(AgentRobot& robot, behavior::Navigator& navigator,
                     agent_service::AgentCommands& commands,
                     agent_service::AgentMetrics& metrics,
                     const WatchedDevices& devices,
                     const AgentLoopOptions& options, const base::Clock& clock,
                     OnEvent on_event)
    : robot_(robot),
      navigator_(navigator),
      commands_(commands),
      metrics_(metrics),
      devices_(devices),
      options_(options),
      clock_(clock),
      on_event_(std::move(on_event)),
      start_(robot.clock().Now()) {}

void AgentLoop::Run(const std::stop_token& stop) {
  StepTimer timer(PeriodOf(options_));
  while (!stop.stop_requested()) {
    if (options_.duration_s > 0 &&
        base::SecondsBetween(start_, robot_.clock().Now()) >=
            options_.duration_s) {
      break;
    }
    const base::MonotonicTime now = clock_.Now();
    const base::MonotonicTime due = timer.NextDue(now);
    if (now < due) {
      std::this_thread::sleep_for(
          std::min<base::MonotonicTime::duration>(due - now, kLongestSleep));
      continue;
    }
    if (!timer.Begin(now)) {
      ++missed_;
      metrics_.CountMissedDeadline();
    }
    Step(now);
  }
  Stand();
}

void AgentLoop::Step(base::MonotonicTime began) {
  std::optional<double> period_s;
  if (last_began_.has_value())
    period_s = base::SecondsBetween(*last_began_, began);
  last_began_ = began;
  robot_.Advance(FromSeconds(1 / options_.control_hz));
  // What the simulation costs is not the robot's.
  const base::MonotonicTime thinks = clock_.Now();
  commands_.hub().RunCommands(navigator_);
  navigator_.Step();
  const base::MonotonicTime now = robot_.clock().Now();
  commands_.StepRoute(navigator_, now);
  commands_.StepDocks(navigator_, now, BatteryNow());
  PlaceChargers();
  metrics_.ObserveStep(period_s, base::SecondsBetween(thinks, clock_.Now()));
  ++steps_;
  TakeEvents();
  const auto every = std::max<int64_t>(
      1, std::llround(options_.control_hz / options_.publish_hz));
  if (steps_ % every == 0) Publish();
}

void AgentLoop::TakeEvents() {
  std::vector<behavior::NavigatorEvent> events = navigator_.TakeEvents();
  std::ranges::move(commands_.routes().runner().TakeEvents(),
                    std::back_inserter(events));
  std::ranges::move(commands_.docks().TakeEvents(), std::back_inserter(events));
  for (const behavior::NavigatorEvent& event : events) {
    metrics_.CountEvent(event.kind);
    commands_.hub().AddEvent(base::SecondsBetween(start_, event.stamp),
                             event.kind, event.text);
    on_event_(event.kind, event.text);
  }
  for (const std::string& incident : robot_.TakeIncidents()) {
    commands_.hub().AddEvent(base::SecondsBetween(start_, robot_.clock().Now()),
                             "simulation", incident);
    on_event_("simulation", incident);
  }
}

void AgentLoop::PlaceChargers() {
  const docking::Docks& docks = commands_.docks().pilot().docks();
  if (robot_.simulation() == nullptr || docks == placed_) return;
  placed_ = docks;
  std::vector<PlacedDock> places;
  for (const docking::Dock& dock : *docks) {
    const geometry::Vec2 at = dock.map_from_docked.translation;
    const absl::StatusOr<core::LevelPose> pose = commands_.OnLevel(
        {.x_m = at.x, .y_m = at.y, .yaw_rad = 0, .level = dock.level},
        dock.name);
    if (pose.ok()) places.push_back({dock, pose->place.height_m});
  }
  robot_.SetChargers(places);
}

std::optional<core::Battery> AgentLoop::BatteryNow() const {
  std::optional<core::Battery> battery = robot_.Battery();
  if (!battery.has_value() && devices_.battery != nullptr) {
    battery = devices_.battery->battery();
  }
  return battery;
}

void AgentLoop::Publish() {
  agent_service::AgentState state;
  state.snapshot = navigator_.Snapshot();
  state.time_s = base::SecondsBetween(start_, robot_.clock().Now());
  if (state.snapshot.goal.has_value()) {
    state.goal_poses = commands_.PosesOf(state.snapshot.goal->id);
  }
  behavior::NavigatorDevices devices = robot_.Devices();
  devices.camera = devices_.camera;
  state.devices = ReportDevices(devices, devices_.server);
  state.true_map_from_base = robot_.TrueMapFromBase();
  state.obstacles = robot_.Obstacles();
  state.battery = BatteryNow();
  state.missed_deadlines = missed_;
  state.zones_revision = commands_.zones().revision();
  commands_.ShowRoute(state);
  metrics_.ObserveState(state);
  commands_.hub().Publish(std::move(state));
}

void AgentLoop::Stand() {
  // A route is to be found as it is.
  commands_.routes().runner().Halt();
  commands_.docks().pilot().Halt();
  navigator_.Halt();
  StepTimer timer(PeriodOf(options_));
  const auto steps =
      static_cast<int64_t>(std::ceil(kStandFor_s * options_.control_hz));
  for (int64_t i = 0; i < steps; ++i) {
    const base::MonotonicTime now = clock_.Now();
    const base::MonotonicTime due = timer.NextDue(now);
    if (now < due) std::this_thread::sleep_for(due - now);
    timer.Begin(clock_.Now());
    Step(clock_.Now());
  }
  Publish();
}

}  // namespace treeline::run_app
