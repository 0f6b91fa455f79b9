// One thread steps the robot, so many times a second.
#ifndef NAV_AGENT_APP_RUN_AGENT_LOOP_H_
#define NAV_AGENT_APP_RUN_AGENT_LOOP_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "common/base/clock.h"
#include "nav_agent/app/run/agent_robot.h"
#include "nav_agent/service/agent_commands.h"
#include "nav_agent/service/agent_metrics.h"
#include "nav_agent/service/battery_tap.h"
#include "nav_agent/service/device_taps.h"

namespace treeline::run_app {

// When a step is due that is taken every `period` of real time. One that begins
// a whole period late has missed its deadline; it is not made up for. Not
// thread-safe.
class StepTimer {
 public:
  // Zero: every step is due at once, and none is late.
  explicit StepTimer(base::MonotonicTime::duration period) : period_(period) {}

  // The first step is due when this is first called.
  base::MonotonicTime NextDue(base::MonotonicTime now);
  // A step begins. False: it missed its deadline.
  bool Begin(base::MonotonicTime now);

 private:
  const base::MonotonicTime::duration period_;
  std::optional<base::MonotonicTime> due_;
};

struct AgentLoopOptions {
  double control_hz = 40;
  // Simulated seconds in a real one, above 0; infinity: as many as can be. Of a
  // real robot: 1.
  double speed = 1;
  // Ends after so much of the robot's time; 0: when a stop is requested (s).
  double duration_s = 0;
  // Pictures of the robot in a second.
  double publish_hz = 10;

  absl::Status Validate() const;
};

// All may be null: there is none.
struct WatchedDevices {
  core::RgbdCamera* camera = nullptr;
  const agent_service::WatchedServer* server = nullptr;
  // For a battery that the robot tells with its wheels alone.
  const agent_service::BatteryTap* battery = nullptr;
};

// Steps `navigator` until a stop is requested or the time is up, then has the
// robot stand. clock: real time.
class AgentLoop {
 public:
  // Called by the stepping thread for every event, of the navigator and of the
  // simulation.
  using OnEvent =
      std::function<void(const std::string& kind, const std::string& text)>;

  // All must outlive it. `options` must be valid.
  AgentLoop(AgentRobot& robot, behavior::Navigator& navigator,
            agent_service::AgentCommands& commands,
            agent_service::AgentMetrics& metrics, const WatchedDevices& devices,
            const AgentLoopOptions& options, const base::Clock& clock,
            OnEvent on_event);

  void Run(const std::stop_token& stop);

  int64_t steps() const { return steps_; }
  int64_t missed_deadlines() const { return missed_; }

 private:
  void Step(base::MonotonicTime began);
  void TakeEvents();
  std::optional<core::Battery> BatteryNow() const;
  // In a simulated world, at the docks that there are.
  void PlaceChargers();
  void Publish();
  // Stands until the base has stopped.
  void Stand();

  AgentRobot& robot_;
  behavior::Navigator& navigator_;
  agent_service::AgentCommands& commands_;
  agent_service::AgentMetrics& metrics_;
  const WatchedDevices devices_;
  const AgentLoopOptions options_;
  const base::Clock& clock_;
  const OnEvent on_event_;
  const base::MonotonicTime start_;
  std::optional<base::MonotonicTime> last_began_;
  int64_t steps_ = 0;
  int64_t missed_ = 0;
  // Where chargers stand.
  docking::Docks placed_;
};

// Every device's health as people read it.
std::vector<agent_service::DeviceReport> ReportDevices(
    const behavior::NavigatorDevices& devices,
    const agent_service::WatchedServer* server);

}  // namespace treeline::run_app

#endif  // NAV_AGENT_APP_RUN_AGENT_LOOP_H_
