// Everything that can be set on `treeline-agent run`.
#ifndef NAV_AGENT_APP_RUN_AGENT_CONFIG_H_
#define NAV_AGENT_APP_RUN_AGENT_CONFIG_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "common/config/config_table.h"
#include "common/tracing/tracing_options.h"
#include "nav_agent/docking/charge_keeper.h"
#include "nav_agent/service/agent_commands.h"
#include "simulation/worlds/world.h"

namespace treeline::run_app {

// What environment variables of the agent start with.
inline constexpr char kAgentPrefix[] = "TREELINE_AGENT_";

struct AgentConfig {
  // ---- the robot ----
  std::string simulate;
  std::string hardware;
  std::string ros2;
  double speed = 1;
  bool people = true;
  std::string light;
  std::string rearranged;
  double camera_hz = 5;
  bool rear_laser = true;
  std::string robot = "rmp100";
  std::string record;
  std::string state_dir;
  std::string zone_masks;
  double battery_at = 100;
  double battery_lasts_s = 10800;
  // ---- where it is ----
  std::string map;
  std::vector<std::string> start_at;
  bool find_yourself = false;
  std::vector<std::string> goal;
  // ---- who helps it ----
  std::string server;
  std::string scene;
  std::string tls_ca;
  std::string token_file;
  std::string trace_endpoint;
  std::vector<std::string> trace_headers;
  double trace_ratio = -1;
  // ---- who watches it ----
  std::string listen = "127.0.0.1:50061";
  std::string http_listen = "127.0.0.1:8081";
  std::string foxglove_listen;
  std::string foxglove_origins = "https://app.foxglove.dev,file://";
  bool insecure_any_address = false;
  std::string page_dir;
  int max_streams = 16;
  // ---- how it drives ----
  bool by_sight = false;
  std::string planner = "variable-rrt";
  double max_forward_mps = 0.6;
  double inflation_m = 0.5;
  double goal_tolerance_m = 0.10;
  double goal_tolerance_rad = 0.15;
  double laser_timeout_s = 0.3;
  double odometry_timeout_s = 0.2;
  // ---- when it charges ----
  double charge_below = 20;
  double charge_until = 90;
  // ---- the program ----
  double duration = 0;
  int64_t seed = 0;
  std::string log_level = "info";
  std::string log_format = "text";

  // No setting: what the environment says of OpenTelemetry, which the settings
  // of traces override.
  tracing::TracingOptions otel;

  // Of both together. INVALID_ARGUMENT.
  absl::StatusOr<tracing::TracingOptions> Tracing() const;
  // The state of the simulated world that people, light and rearranged ask
  // for. INVALID_ARGUMENT.
  absl::StatusOr<worlds::WorldOptions> SimulatedWorld() const;

  // When it goes to charge by itself.
  docking::ChargeOptions Charge() const {
    return {.below = charge_below / 100, .until = charge_until / 100};
  }

  // What a single setting cannot know. INVALID_ARGUMENT.
  absl::Status Validate() const;
};

// The settings; immutable.
const config::ConfigTable<AgentConfig>& AgentConfigTable();

// X,Y,YAW or X,Y,YAW,LEVEL in m and rad. nullopt: `numbers` is empty.
// INVALID_ARGUMENT names `flag`.
absl::StatusOr<std::optional<agent_service::RequestedPose>> ParseRequestedPose(
    const std::vector<std::string>& numbers, absl::string_view flag);

}  // namespace treeline::run_app

#endif  // NAV_AGENT_APP_RUN_AGENT_CONFIG_H_
