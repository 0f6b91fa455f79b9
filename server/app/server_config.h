// The configuration of treeline-server.
#ifndef SERVER_APP_SERVER_CONFIG_H_
#define SERVER_APP_SERVER_CONFIG_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/config/config_table.h"
#include "common/flood_guard/flood_guard.h"
#include "common/tracing/tracing_options.h"
#include "server/service/grpc_server.h"
#include "server/service/service_dispatcher.h"

namespace treeline::server_app {

inline constexpr char kServerEnvironmentPrefix[] = "TREELINE_SERVER_";

// Each field is a setting of the same name; ServerConfigTable() has their help
// and bounds; docs/reference/server-settings.md is generated from both.
struct ServerConfig {
  // Scenes.
  std::string models;
  std::string cache;
  int cache_mib = 0;
  std::string models_ca;
  std::string models_keys;
  int memory_budget_mib = 0;
  double poll_s = 0;
  bool load_all = false;

  // Where it listens; empty: not at all.
  std::string listen = "127.0.0.1:50051";
  std::string admin_listen = "127.0.0.1:50052";
  std::string http_listen = "127.0.0.1:8080";
  bool insecure_any_address = false;
  std::vector<std::string> cors_origin;
  std::string ar_page = "auto";
  double max_connection_age_s = 600;

  // Trust.
  std::string tls_cert;
  std::string tls_key;
  std::string tls_client_ca;
  bool tls_require_client_cert = false;
  std::vector<std::string> tls_admin_name;
  std::string auth_keys;
  std::string auth_issuer;
  std::string auth_audience;
  double rate_limit = 0;
  double rate_burst = 10;
  double flood_limit = 500;
  int flood_open_calls = 2048;
  int flood_connections = 1024;

  // Capacity.
  int workers = 0;
  int queue = 64;
  int max_message_mib = 32;
  double max_megapixels = 32;

  // Stopping.
  double drain_s = 1;
  double grace_s = 10;

  // Seen from outside.
  std::string record;
  int record_mib = 1024;
  int recent_queries = 0;
  std::string trace_endpoint;
  std::vector<std::string> trace_headers;
  double trace_ratio = -1;
  std::string log_level = "info";
  std::string log_format = "text";

  // No setting: what the environment says of OpenTelemetry, which the settings
  // of traces override.
  tracing::TracingOptions otel;

  // What no setting can tell alone: a certificate needs its key, and so on.
  // INVALID_ARGUMENT names the flags.
  absl::Status Validate() const;
};

// Declares every setting once: for flags, environment, file, help, validation
// and --print-config.
const config::ConfigTable<ServerConfig>& ServerConfigTable();

// Of the environment and the settings together. INVALID_ARGUMENT.
absl::StatusOr<tracing::TracingOptions> TracingOptionsOf(
    const ServerConfig& config);

// Of the public listener.
service::GrpcServerOptions GrpcOptionsOf(const ServerConfig& config);
// Of a machine with so many processors; nullopt: no limits are wanted.
std::optional<flood_guard::FloodLimits> FloodLimitsOf(
    const ServerConfig& config, unsigned processors);
service::DispatcherOptions DispatcherOptionsOf(const ServerConfig& config);

}  // namespace treeline::server_app

#endif  // SERVER_APP_SERVER_CONFIG_H_
