#include "server/app/application.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <stop_token>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "common/base/byte_budget.h"
#include "common/base/listen_address.h"
#include "common/base/status_macros.h"
#include "common/base/version.h"
#include "common/http/static_files.h"
#include "common/metrics/registry.h"
#include "common/tracing/tracing.h"
#include "server/access/grpc_tls.h"
#include "server/access/http_tls.h"
#include "server/access/key_store.h"
#include "server/access/rate_limited_access.h"
#include "server/access/tls.h"
#include "server/access/token_access.h"
#include "server/access/token_verifier.h"
#include "server/access/wall_clock.h"
#include "server/app/call_log.h"
#include "server/app/call_spans.h"
#include "server/app/failed_query_folder.h"
#include "server/app/failed_query_recorder.h"
#include "server/app/flood_protection.h"
#include "server/app/model_supply.h"
#include "server/app/process_metrics.h"
#include "server/app/recording_dispatcher.h"
#include "server/app/service_metrics.h"
#include "server/gateway/gateway.h"
#include "server/repository/scene_repository.h"
#include "server/service/convert.h"
#include "server/service/grpc_server.h"
#include "server/service/recent_queries.h"
#include "server/service/service_dispatcher.h"

namespace treeline::server_app {
namespace {

// What requests may hold together from their arrival to their answer, on all
// transports, counted in the largest that is accepted: each is there as bytes
// and as a message while it is parsed.
constexpr uint64_t kLargestRequestsHeld = 4;
// Of 256 connections, what one address may have, and what is kept for probes.
constexpr int kHttpConnectionsOfClient = 128;
constexpr int kHttpConnectionsForProbes = 16;

// Another policy can take over while calls come in.
class LiveAccess final : public service::AccessPolicy {
 public:
  void Set(std::shared_ptr<service::AccessPolicy> policy) {
    absl::MutexLock lock(&mutex_);
    policy_ = std::move(policy);
  }
  absl::StatusOr<service::Client> Admit(const service::CallInfo& call,
                                        service::Scope scope) override {
    return Policy()->Admit(call, scope);
  }
  absl::StatusOr<service::Client> Identify(const service::CallInfo& call,
                                           service::Scope scope) override {
    return Policy()->Identify(call, scope);
  }

 private:
  std::shared_ptr<service::AccessPolicy> Policy() {
    absl::MutexLock lock(&mutex_);
    return policy_;
  }

  absl::Mutex mutex_;
  std::shared_ptr<service::AccessPolicy> policy_ ABSL_GUARDED_BY(mutex_);
};

access::TlsOptions TlsOptionsOf(const ServerConfig& config) {
  return {.certificate_file = config.tls_cert,
          .key_file = config.tls_key,
          .client_ca_file = config.tls_client_ca,
          .require_client_certificate = config.tls_require_client_cert};
}

absl::StatusOr<access::TokenAccessOptions> TokenAccessOptionsOf(
    const ServerConfig& config) {
  access::TokenAccessOptions options;
  options.admin_on_public_listener = config.admin_listen.empty();
  if (!config.admin_listen.empty()) {
    TL_ASSIGN_OR_RETURN(const base::ListenAddress admin,
                        base::ParseListenAddress(config.admin_listen));
    // Whoever is on this machine could read the keys as well.
    options.open_admin_listener = base::IsLoopback(admin);
  }
  if (!config.tls_client_ca.empty()) {
    options.certificate_scopes["*"] = {service::Scope::kLocalize};
    for (const std::string& name : config.tls_admin_name) {
      options.certificate_scopes[name] = {service::Scope::kLocalize,
                                          service::Scope::kAdmin,
                                          service::Scope::kInspect};
    }
  }
  return options;
}

access::RateLimitOptions RateLimitOf(const ServerConfig& config) {
  return {.rate_per_s = config.rate_limit,
          .burst = static_cast<int>(config.rate_burst)};
}

std::unique_ptr<service::RecentQueries> KeepRecentQueries(
    const ServerConfig& config) {
  if (config.recent_queries == 0) return nullptr;
  return std::make_unique<service::RecentQueries>(
      static_cast<size_t>(config.recent_queries),
      [] { return std::chrono::system_clock::now(); });
}

// Of a folder that was named, there must be a page.
absl::StatusOr<std::string> ArPageFolder(const ServerConfig& config) {
  if (config.ar_page == "auto") {
    return http::FindPageFolder("ar-page", TREELINE_BUILT_AR_PAGE);
  }
  if (!config.ar_page.empty() && !http::StaticFiles(config.ar_page).HasPage()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--ar-page: there is no page in ", config.ar_page,
        "; scripts/build-ar-page --out ", config.ar_page, " makes one"));
  }
  return config.ar_page;
}

// Null: nobody wants spans.
absl::StatusOr<std::unique_ptr<tracing::Tracing>> StartTracing(
    const ServerConfig& config, logging::ProgramLog& log) {
  TL_ASSIGN_OR_RETURN(const tracing::TracingOptions options,
                      TracingOptionsOf(config));
  if (!options.enabled()) return std::unique_ptr<tracing::Tracing>();
  log.Say(
      logging::LogLevel::kInfo,
      absl::StrCat("traces go to ", config::RedactAddress(options.endpoint)));
  return tracing::Tracing::Start(
      options, base::Version(), tracing::SeedOfProcess(),
      [&log](const absl::Status& health) {
        log.Say(
            health.ok() ? logging::LogLevel::kInfo : logging::LogLevel::kWarn,
            health.ok()
                ? "traces are sent again"
                : absl::StrCat("traces are not sent: ", health.message()));
      });
}

RepositoryFigures FiguresOf(const repository::SceneRepository& repository) {
  const repository::RepositoryStats stats = repository.Stats();
  RepositoryFigures figures;
  for (const repository::SceneStats& scene : stats.scenes) {
    figures.scenes.push_back({.scene = scene.name,
                              .state = scene.state,
                              .resident_bytes = scene.resident_bytes,
                              .loads = scene.counts.loads,
                              .load_failures = scene.counts.load_failures,
                              .evictions = scene.counts.evictions});
  }
  metrics::HistogramCounts times;
  times.upper_bounds.assign(repository::LoadTimes::kUpperBounds_s.begin(),
                            repository::LoadTimes::kUpperBounds_s.end());
  times.counts.assign(stats.load_times.counts.begin(),
                      stats.load_times.counts.end());
  times.sum = stats.load_times.sum_s;
  figures.load_seconds = std::move(times);
  return figures;
}

}  // namespace

// Destroyed from the last to the first: what calls before what it calls.
struct Application::Parts {
  Parts(const ServerConfig& config, logging::ProgramLog& server_log,
        const base::Clock& used_clock,
        std::unique_ptr<tracing::Tracing> used_tracing)
      : log(server_log),
        clock(used_clock),
        tracing(std::move(used_tracing)),
        budget(kLargestRequestsHeld *
               (static_cast<uint64_t>(config.max_message_mib) << 20)),
        answers(budget.total_bytes()),
        metrics(registry),
        call_log(server_log, used_clock),
        recent_queries(KeepRecentQueries(config)),
        call_spans(MakeCallSpans()),
        observers(Observers()) {}
  // Downloads must not outlast the rest.
  ~Parts() {
    stop_downloads.request_stop();
    // Connections may hold it longer.
    if (flood_guard != nullptr) flood_guard->StopReporting();
  }

  std::vector<service::CallObserver*> Observers() {
    std::vector<service::CallObserver*> all{&metrics, &call_log};
    if (recent_queries != nullptr) all.push_back(recent_queries.get());
    if (call_spans != nullptr) all.push_back(call_spans.get());
    return all;
  }
  std::unique_ptr<CallSpans> MakeCallSpans() const {
    if (tracing == nullptr) return nullptr;
    return std::make_unique<CallSpans>(
        tracing->tracer(), [] { return std::chrono::system_clock::now(); });
  }
  tracing::Tracer* tracer() const {
    return tracing == nullptr ? nullptr : &tracing->tracer();
  }

  absl::Status OpenAccessPolicy(const ServerConfig& config);
  absl::Status StartRecorder(const ServerConfig& config);
  absl::Status StartListeners(const ServerConfig& config);
  absl::Status StartGateway(const ServerConfig& config);
  void AddMetrics();
  void SetRateLimit(const ServerConfig& config);

  logging::ProgramLog& log;
  const base::Clock& clock;
  const access::SystemWallClock wall_clock;
  // Null: there are no spans.
  const std::unique_ptr<tracing::Tracing> tracing;
  // Of requests, and of large answers that are not taken yet.
  base::ByteBudget budget;
  base::ByteBudget answers;
  metrics::Registry registry;
  ServiceMetrics metrics;
  CallLog call_log;
  // Null: none are kept.
  std::unique_ptr<service::RecentQueries> recent_queries;
  // Null: there are no spans.
  const std::unique_ptr<CallSpans> call_spans;
  CallObservers observers;
  std::stop_source stop_downloads;
  std::unique_ptr<repository::SceneRepository> repository;
  std::unique_ptr<access::CertificateFiles> certificates;
  std::unique_ptr<access::HttpTls> http_tls;
  std::unique_ptr<access::KeyStore> keys;
  std::unique_ptr<access::TokenVerifier> tokens;
  std::unique_ptr<service::AccessPolicy> identity;
  LiveAccess access;
  std::unique_ptr<FailedQueryRecorder> recorder;
  std::unique_ptr<service::ServiceDispatcher> service;
  std::unique_ptr<RecordingDispatcher> recording;
  // The one of the two that the listeners call.
  service::Dispatcher* dispatcher = nullptr;
  // Null: nobody is cut off.
  std::shared_ptr<flood_guard::FloodGuard> flood_guard;
  std::unique_ptr<service::GrpcServer> grpc;
  std::unique_ptr<service::GrpcServer> admin;
  std::unique_ptr<gateway::Gateway> gateway;
  std::vector<std::string> announcements;
  std::atomic<bool> draining = false;
};

absl::Status Application::Parts::OpenAccessPolicy(const ServerConfig& config) {
  const access::TrustLog trust_log = [this](access::TrustSeverity severity,
                                            const std::string& message) {
    log.Say(severity == access::TrustSeverity::kWarning
                ? logging::LogLevel::kWarn
                : logging::LogLevel::kInfo,
            message);
  };
  if (!config.tls_cert.empty()) {
    TL_ASSIGN_OR_RETURN(
        certificates, access::CertificateFiles::Open(
                          TlsOptionsOf(config), clock, wall_clock, trust_log));
    http_tls = std::make_unique<access::HttpTls>(*certificates);
  }
  if (!config.auth_keys.empty()) {
    TL_ASSIGN_OR_RETURN(keys, access::KeyStore::Open({.path = config.auth_keys},
                                                     clock, trust_log));
    access::TokenVerifierOptions options;
    options.rules.issuer = config.auth_issuer;
    if (!config.auth_audience.empty()) {
      options.rules.audience = config.auth_audience;
    }
    TL_RETURN_IF_ERROR(options.Validate());
    tokens =
        std::make_unique<access::TokenVerifier>(options, *keys, wall_clock);
  }
  if (config.auth_keys.empty() && config.tls_client_ca.empty()) {
    identity = std::make_unique<service::OpenAccess>();
  } else {
    TL_ASSIGN_OR_RETURN(const access::TokenAccessOptions options,
                        TokenAccessOptionsOf(config));
    identity = std::make_unique<access::TokenAccess>(options, tokens.get());
  }
  TL_RETURN_IF_ERROR(RateLimitOf(config).Validate());
  SetRateLimit(config);
  return absl::OkStatus();
}

void Application::Parts::SetRateLimit(const ServerConfig& config) {
  access.Set(std::make_shared<access::RateLimitedAccess>(
      *identity, RateLimitOf(config), clock));
}

absl::Status Application::Parts::StartRecorder(const ServerConfig& config) {
  dispatcher = service.get();
  if (config.record.empty()) return absl::OkStatus();
  RecorderOptions options;
  options.folder = config.record;
  options.max_bytes = static_cast<uint64_t>(config.record_mib) << 20;
  TL_ASSIGN_OR_RETURN(
      recorder,
      FailedQueryRecorder::Start(
          std::move(options), [] { return std::chrono::system_clock::now(); },
          [this](const absl::Status& health) {
            log.Say(health.ok() ? logging::LogLevel::kInfo
                                : logging::LogLevel::kWarn,
                    health.ok() ? "failed queries are kept again"
                                : absl::StrCat("failed queries are not kept: ",
                                               health.ToString()));
          }));
  recording =
      std::make_unique<RecordingDispatcher>(*service, *recorder, tracer());
  dispatcher = recording.get();
  return absl::OkStatus();
}

absl::Status Application::Parts::StartListeners(const ServerConfig& config) {
  service::GrpcServerOptions options = GrpcOptionsOf(config);
  options.budget = &budget;
  options.answers = &answers;
  options.guard = flood_guard;
  if (certificates != nullptr) {
    options.credentials = access::MakeServerCredentials(*certificates);
    options.certificate_names = [](const grpc::AuthContext& context) {
      return access::CertificateNames(context);
    };
  }
  TL_ASSIGN_OR_RETURN(grpc, service::GrpcServer::Start(*dispatcher, *repository,
                                                       options, clock));
  announcements.push_back(absl::StrCat("listening on ", grpc->address()));
  if (config.admin_listen.empty()) return absl::OkStatus();
  options.kind = service::ListenerKind::kAdmin;
  options.listen = config.admin_listen;
  TL_ASSIGN_OR_RETURN(admin, service::GrpcServer::Start(
                                 *dispatcher, *repository, options, clock));
  announcements.push_back(absl::StrCat("admin on ", admin->address()));
  return absl::OkStatus();
}

absl::Status Application::Parts::StartGateway(const ServerConfig& config) {
  if (config.http_listen.empty()) return absl::OkStatus();
  gateway::GatewayOptions options;
  options.http.listen = config.http_listen;
  options.http.insecure_any_address = config.insecure_any_address;
  options.http.max_body_mib = config.max_message_mib;
  options.http.max_connections_per_client = kHttpConnectionsOfClient;
  options.http.max_probe_connections = kHttpConnectionsForProbes;
  options.http.budget = &budget;
  options.http.answers = &answers;
  options.allowed_origins = config.cors_origin;
  TL_ASSIGN_OR_RETURN(options.ar_page_folder, ArPageFolder(config));
  if (http_tls != nullptr) {
    options.http.tls = http::ServerTls{
        .configure =
            [this](SSL_CTX& context) { return http_tls->Configure(context); },
        .client_names =
            [](SSL* connection) {
              return access::CertificateNames(*connection);
            }};
  }
  gateway::GatewayHooks hooks;
  hooks.metrics = [this](absl::string_view accept) {
    const metrics::ExpositionFormat format = metrics::FormatFor(accept);
    return gateway::Content{metrics::ContentTypeOf(format),
                            registry.Expose(format)};
  };
  if (recorder != nullptr) {
    hooks.failed_queries =
        [folder = FailedQueryFolder(config.record)](absl::string_view path) {
          return folder.Get(path);
        };
    hooks.may_inspect = [this](const service::CallInfo& call) {
      return access.Identify(call, service::Scope::kInspect).status();
    };
  }
  hooks.may_read_metrics = [this](const service::CallInfo& call) {
    return access.Identify(call, service::Scope::kLocalize).status();
  };
  hooks.ready = [this] { return !draining; };
  hooks.scenes = [this] {
    std::vector<v1::SceneInfo> scenes;
    for (const repository::SceneStatus& status : repository->List()) {
      scenes.push_back(service::ToProto(status));
    }
    return scenes;
  };
  TL_ASSIGN_OR_RETURN(
      gateway,
      gateway::Gateway::Start(options, *dispatcher, std::move(hooks), clock));
  announcements.push_back(absl::StrCat("http on ", gateway->address()));
  if (!options.ar_page_folder.empty()) {
    announcements.push_back(absl::StrCat("ar page on ",
                                         http_tls == nullptr ? "http" : "https",
                                         "://", gateway->address(), "/ar/"));
  }
  return absl::OkStatus();
}

void Application::Parts::AddMetrics() {
  AddBuildInfo(registry, base::Version());
  AddProcessMetrics(registry);
  AddLoadMetrics(registry, [this] { return dispatcher->load(); });
  AddSceneMetrics(registry, [this] { return FiguresOf(*repository); });
  if (recorder != nullptr) AddRecorderMetrics(registry, *recorder);
  if (tracing != nullptr) AddTracingMetrics(registry, *tracing);
  if (flood_guard != nullptr) AddFloodMetrics(registry, flood_guard);
}

Application::Application(std::unique_ptr<Parts> parts)
    : parts_(std::move(parts)) {}

Application::~Application() { Stop(std::chrono::milliseconds(0)); }

absl::StatusOr<std::unique_ptr<Application>> Application::Start(
    const ServerConfig& config, logging::ProgramLog& log,
    const base::Clock& clock) {
  // Before the models are read: they may take a while.
  TL_RETURN_IF_ERROR(config.Validate());
  TL_ASSIGN_OR_RETURN(std::unique_ptr<tracing::Tracing> tracing,
                      StartTracing(config, log));
  auto parts = std::make_unique<Parts>(config, log, clock, std::move(tracing));
  TL_RETURN_IF_ERROR(parts->OpenAccessPolicy(config));
  TL_ASSIGN_OR_RETURN(
      parts->repository,
      OpenRepository(config, parts->stop_downloads.get_token(), log, clock));
  service::DispatcherOptions options = DispatcherOptionsOf(config);
  options.recent_queries = parts->recent_queries.get();
  options.tracer = parts->tracer();
  parts->service = std::make_unique<service::ServiceDispatcher>(
      *parts->repository, parts->access, parts->observers, clock, options);
  TL_RETURN_IF_ERROR(parts->StartRecorder(config));
  parts->flood_guard = MakeFloodGuard(config, log, clock);
  parts->AddMetrics();
  TL_RETURN_IF_ERROR(parts->StartListeners(config));
  TL_RETURN_IF_ERROR(parts->StartGateway(config));
  return std::unique_ptr<Application>(new Application(std::move(parts)));
}

const std::vector<std::string>& Application::announcements() const {
  return parts_->announcements;
}

void Application::ApplyLive(const ServerConfig& config) {
  parts_->SetRateLimit(config);
}

void Application::Drain() {
  parts_->draining = true;
  parts_->grpc->AnnounceStop();
}

void Application::Stop(std::chrono::milliseconds grace) {
  parts_->draining = true;
  const base::MonotonicTime end = parts_->clock.Now() + grace;
  const auto left = [&] {
    return std::max(std::chrono::milliseconds(0),
                    std::chrono::duration_cast<std::chrono::milliseconds>(
                        end - parts_->clock.Now()));
  };
  if (parts_->grpc != nullptr) parts_->grpc->Stop(grace);
  if (parts_->gateway != nullptr) parts_->gateway->Stop(left());
  if (parts_->admin != nullptr) parts_->admin->Stop(left());
  // Of calls that have ended; whether they were in time or not.
  if (parts_->tracing != nullptr) {
    parts_->tracing->Stop(tracing::Tracing::kPatience);
  }
}

std::string Application::MetricsText() const {
  return parts_->registry.Expose();
}

}  // namespace treeline::server_app
