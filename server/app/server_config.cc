#include "server/app/server_config.h"

#include <algorithm>
#include <cstdint>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "common/base/listen_address.h"
#include "common/base/status_macros.h"
#include "server/gateway/cors.h"

namespace treeline::server_app {
namespace {

using Table = config::ConfigTable<ServerConfig>;

absl::Status CheckAddress(const config::ConfigValue& value) {
  const std::string& text = std::get<std::string>(value);
  if (text.empty()) return absl::OkStatus();
  return base::ParseListenAddress(text).status();
}

absl::Status CheckOrigins(const config::ConfigValue& value) {
  return gateway::CorsPolicy::Validate(
      std::get<std::vector<std::string>>(value));
}

absl::Status CheckTraceEndpoint(const config::ConfigValue& value) {
  const std::string& text = std::get<std::string>(value);
  return text.empty() ? absl::OkStatus() : tracing::CheckEndpoint(text);
}

absl::Status CheckTraceHeaders(const config::ConfigValue& value) {
  return tracing::ParsePairs(
             absl::StrJoin(std::get<std::vector<std::string>>(value), ","))
      .status();
}

void AddScenes(Table& table) {
  table.Add(
      &ServerConfig::models,
      {.name = "models",
       .value_name = "DIR|URL",
       .help = "Folder with the scenes, or the web address of their index",
       .required = true,
       .secrecy = config::Secrecy::kAddress});
  table.Add(&ServerConfig::cache,
            {.name = "cache",
             .value_name = "DIR",
             .help = "Folder for models that are fetched from a web address"});
  table.Add(&ServerConfig::cache_mib,
            {.name = "cache_mib",
             .help = "Maximum size of the fetched models, MiB; the least "
                     "recently used are deleted; 0: no limit",
             .min = 0,
             .max = 1 << 24});
  table.Add(&ServerConfig::models_ca,
            {.name = "models_ca",
             .value_name = "FILE",
             .help = "Authorities to trust for models from an https address, "
                     "PEM, instead of the system's"});
  table.Add(&ServerConfig::models_keys,
            {.name = "models_keys",
             .value_name = "FILE",
             .help = "Public Ed25519 keys, PEM, of which one must have signed "
                     "the index of models from a web address; without: it "
                     "need not be signed"});
  table.Add(&ServerConfig::memory_budget_mib,
            {.name = "memory_budget_mib",
             .help = "Memory for loaded scenes, MiB; the least recently used "
                     "make room; 0: no limit",
             .min = 0,
             .max = 1 << 24});
  table.Add(
      &ServerConfig::poll_s,
      {.name = "poll_s",
       .value_name = "SECONDS",
       .help =
           "Interval at which new scenes and versions are looked for; 0: never",
       .min = 0,
       .max = 86400});
  table.Add(
      &ServerConfig::load_all,
      {.name = "load_all",
       .help =
           "Load all scenes at the start instead of with their first query"});
}

void AddListening(Table& table) {
  table.Add(&ServerConfig::listen,
            {.name = "listen",
             .value_name = "HOST:PORT",
             .help = "Address of the gRPC listener; port 0 takes a free one",
             .check = CheckAddress,
             .required = true});
  table.Add(&ServerConfig::admin_listen,
            {.name = "admin_listen",
             .value_name = "HOST:PORT",
             .help = "Address of the admin listener, where LoadScene and "
                     "UnloadScene need no token on loopback; '': none",
             .check = CheckAddress});
  table.Add(&ServerConfig::http_listen,
            {.name = "http_listen",
             .value_name = "HOST:PORT",
             .help = "Address of the HTTP listener: calls, /ar/, /metrics, "
                     "/healthz, /readyz; '': none",
             .check = CheckAddress});
  table.Add(&ServerConfig::insecure_any_address,
            {.name = "insecure_any_address",
             .help = "Allow addresses that other machines reach, although "
                     "nothing is encrypted"});
  table.Add(&ServerConfig::cors_origin,
            {.name = "cors_origin",
             .value_name = "ORIGIN,...",
             .help = "Origins of web pages that may call over HTTP, as "
                     "browsers send them: https://HOST or https://HOST:PORT",
             .check = CheckOrigins});
  table.Add(&ServerConfig::ar_page,
            {.name = "ar_page",
             .value_name = "DIR",
             .help = "Folder of the AR page, served below /ar/ of the HTTP "
                     "listener; auto: where it was built or installed, if it "
                     "was; '': none"});
  table.Add(&ServerConfig::max_connection_age_s,
            {.name = "max_connection_age_s",
             .value_name = "SECONDS",
             .help = "Age at which clients are asked to reconnect, so that "
                     "balancers can balance; 0: never",
             .min = 0,
             .max = 86400});
}

void AddTrust(Table& table) {
  table.Add(
      &ServerConfig::tls_cert,
      {.name = "tls_cert",
       .value_name = "FILE",
       .help = "Certificate chain, PEM; read again when the file changes"});
  table.Add(&ServerConfig::tls_key,
            {.name = "tls_key",
             .value_name = "FILE",
             .help = "Private key of the certificate, PEM"});
  table.Add(&ServerConfig::tls_client_ca,
            {.name = "tls_client_ca",
             .value_name = "FILE",
             .help = "Authorities that may sign client certificates, PEM"});
  table.Add(&ServerConfig::tls_require_client_cert,
            {.name = "tls_require_client_cert",
             .help = "Refuse clients without a certificate"});
  table.Add(
      &ServerConfig::tls_admin_name,
      {.name = "tls_admin_name",
       .value_name = "NAME,...",
       .help = "Names in client certificates whose holders may administer"});
  table.Add(&ServerConfig::auth_keys,
            {.name = "auth_keys",
             .value_name = "FILE",
             .help = "Keys that bearer tokens are verified with: a folder of "
                     "<kid>.pem, or a JWKS file; tokens are required then"});
  table.Add(
      &ServerConfig::auth_issuer,
      {.name = "auth_issuer", .help = "Required issuer ('iss') of tokens"});
  table.Add(
      &ServerConfig::auth_audience,
      {.name = "auth_audience", .help = "Required audience ('aud') of tokens"});
  table.Add(&ServerConfig::rate_limit,
            {.name = "rate_limit",
             .value_name = "PER_SECOND",
             .help = "Calls a second that one client may make; 0: no limit",
             .min = 0,
             .max = 1e6,
             .live = true});
  table.Add(&ServerConfig::rate_burst,
            {.name = "rate_burst",
             .value_name = "CALLS",
             .help = "Calls that one client may make at once after a pause",
             .min = 1,
             .max = 1e6,
             .live = true});
  table.Add(&ServerConfig::flood_limit,
            {.name = "flood_limit",
             .value_name = "PER_SECOND",
             .help = "Calls a second, for each processor of this machine, that "
                     "one address may begin over gRPC before its connections "
                     "are cut off; 0: none are cut off for anything",
             .min = 0,
             .max = 1e6});
  table.Add(&ServerConfig::flood_open_calls,
            {.name = "flood_open_calls",
             .help = "Calls over gRPC that one address may have open before "
                     "its connections are cut off",
             .min = 10,
             .max = 1e6});
  table.Add(&ServerConfig::flood_connections,
            {.name = "flood_connections",
             .help = "Connections of gRPC that one address may have",
             .min = 1,
             .max = 1e6});
}

void AddCapacity(Table& table) {
  table.Add(
      &ServerConfig::workers,
      {.name = "workers",
       .help =
           "Queries that are computed at the same time; 0: one per processor",
       .min = 0,
       .max = 1024});
  table.Add(&ServerConfig::queue,
            {.name = "queue",
             .help = "Queries that may wait; further ones are refused with "
                     "UNAVAILABLE and a time to retry",
             .min = 1,
             .max = 100000});
  table.Add(&ServerConfig::max_message_mib,
            {.name = "max_message_mib",
             .help = "Maximum size of a request, MiB",
             .min = 1,
             .max = 1024});
  table.Add(&ServerConfig::max_megapixels,
            {.name = "max_megapixels",
             .help = "Maximum size of an image, millions of pixels; more than "
                     "8192 a side is always refused",
             .min = 0.01,
             .max = 1000});
}

void AddLife(Table& table) {
  table.Add(&ServerConfig::drain_s,
            {.name = "drain_s",
             .value_name = "SECONDS",
             .help = "Time for which calls are still answered after a stop was "
                     "requested, so that balancers notice",
             .min = 0,
             .max = 3600,
             .live = true});
  table.Add(&ServerConfig::grace_s,
            {.name = "grace_s",
             .value_name = "SECONDS",
             .help = "Time that calls in flight get after that",
             .min = 0,
             .max = 3600,
             .live = true});
  table.Add(&ServerConfig::record,
            {.name = "record",
             .value_name = "DIR",
             .help = "Folder to keep failed queries in for debugging, images "
                     "included; '': keep nothing"});
  table.Add(
      &ServerConfig::record_mib,
      {.name = "record_mib",
       .help = "Maximum size of the kept queries, MiB; the oldest are deleted",
       .min = 1,
       .max = 1 << 24});
  table.Add(
      &ServerConfig::recent_queries,
      {.name = "recent_queries",
       .help = "Results of so many of the latest queries are kept in memory, "
               "and shown to all who may localize in their scene: when, where "
               "or why not; no pictures. 0: none",
       .min = 0,
       .max = 10000});
  table.Add(
      &ServerConfig::trace_endpoint,
      {.name = "trace_endpoint",
       .value_name = "URL",
       .help = "Where spans of traces are posted to by OTLP, like "
               "http://collector:4318/v1/traces; '': where OpenTelemetry's "
               "variables say, or else there are none",
       .check = CheckTraceEndpoint,
       .secrecy = config::Secrecy::kAddress});
  table.Add(&ServerConfig::trace_headers,
            {.name = "trace_headers",
             .value_name = "NAME=VALUE,...",
             .help = "Headers to send with them, such as a collector's key",
             .check = CheckTraceHeaders,
             .secrecy = config::Secrecy::kSecret});
  table.Add(
      &ServerConfig::trace_ratio,
      {.name = "trace_ratio",
       .help = "Share of the traces that begin at the server which is "
               "recorded, 0 to 1; of those that callers began, they decide. "
               "-1: as OTEL_TRACES_SAMPLER says, or else all",
       .min = -1,
       .max = 1});
  table.Add(&ServerConfig::log_level,
            {.name = "log_level",
             .help = "debug logs every call, info only failed ones",
             .choices = {"debug", "info", "warn", "error", "off"},
             .live = true});
  table.Add(&ServerConfig::log_format,
            {.name = "log_format",
             .help = "Lines of key=value, or one JSON object a line",
             .choices = {"text", "json"}});
}

absl::Status Needs(absl::string_view flag, absl::string_view other) {
  return absl::InvalidArgumentError(absl::StrCat(flag, " needs ", other));
}

}  // namespace

absl::Status ServerConfig::Validate() const {
  if (tls_cert.empty() != tls_key.empty()) {
    return tls_cert.empty() ? Needs("--tls-key", "--tls-cert")
                            : Needs("--tls-cert", "--tls-key");
  }
  if (!tls_client_ca.empty() && tls_cert.empty()) {
    return Needs("--tls-client-ca", "--tls-cert and --tls-key");
  }
  if (tls_require_client_cert && tls_client_ca.empty()) {
    return Needs("--tls-require-client-cert", "--tls-client-ca");
  }
  if (auth_keys.empty() && !(auth_issuer.empty() && auth_audience.empty())) {
    return Needs("--auth-issuer and --auth-audience", "--auth-keys");
  }
  if (absl::StrContains(models, "://") && cache.empty()) {
    return Needs("--models with a web address", "--cache");
  }
  // Who asks for signatures and does not get them checked must know.
  if (!models_keys.empty() && !absl::StrContains(models, "://")) {
    return Needs("--models-keys", "--models with a web address");
  }
  if (!admin_listen.empty() && !insecure_any_address && auth_keys.empty() &&
      tls_client_ca.empty()) {
    TL_ASSIGN_OR_RETURN(const base::ListenAddress admin,
                        base::ParseListenAddress(admin_listen));
    // Encrypted or not, everyone who reaches it could unload every scene.
    if (!base::IsLoopback(admin)) {
      return Needs("--admin-listen on an address that other machines reach",
                   "--auth-keys or --tls-client-ca");
    }
  }
  TL_RETURN_IF_ERROR(TracingOptionsOf(*this).status());
  TL_RETURN_IF_ERROR(DispatcherOptionsOf(*this).Validate());
  return GrpcOptionsOf(*this).Validate();
}

const config::ConfigTable<ServerConfig>& ServerConfigTable() {
  // Immutable; made by the first who asks.
  static const auto* const table = [] {
    auto* made = new Table;
    AddScenes(*made);
    AddListening(*made);
    AddTrust(*made);
    AddCapacity(*made);
    AddLife(*made);
    return made;
  }();
  return *table;
}

absl::StatusOr<tracing::TracingOptions> TracingOptionsOf(
    const ServerConfig& config) {
  tracing::TracingOptions options = config.otel;
  TL_RETURN_IF_ERROR(tracing::ApplySettings(config.trace_endpoint,
                                            config.trace_headers,
                                            config.trace_ratio, options));
  return options;
}

service::GrpcServerOptions GrpcOptionsOf(const ServerConfig& config) {
  service::GrpcServerOptions options;
  options.listen = config.listen;
  // The credentials are the caller's to add.
  options.insecure_any_address =
      config.insecure_any_address || !config.tls_cert.empty();
  options.max_message_mib = config.max_message_mib;
  options.max_connection_age_s = static_cast<int>(config.max_connection_age_s);
  return options;
}

std::optional<flood_guard::FloodLimits> FloodLimitsOf(
    const ServerConfig& config, unsigned processors) {
  if (config.flood_limit == 0) return std::nullopt;
  return flood_guard::FloodLimits{
      .calls_per_s =
          std::max(1.0, config.flood_limit * std::max(1U, processors)),
      .open_calls = config.flood_open_calls,
      .connections = config.flood_connections};
}

service::DispatcherOptions DispatcherOptionsOf(const ServerConfig& config) {
  service::DispatcherOptions options;
  options.workers = config.workers;
  options.queue = config.queue;
  options.decode_limits.max_pixels =
      static_cast<int64_t>(config.max_megapixels * 1e6);
  return options;
}

}  // namespace treeline::server_app
