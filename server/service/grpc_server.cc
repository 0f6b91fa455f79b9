#include "server/service/grpc_server.h"

#include <grpcpp/ext/channelz_service_plugin.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/listen_address.h"
#include "common/base/status_macros.h"
#include "server/service/grpc_services.h"
#include "server/service/scene_health.h"

namespace treeline::service {
namespace {

// A peer that does not finish its handshake is cut off; one that is silent is
// asked whether it lives, and cut off if it does not say so.
constexpr int kHandshake_ms = 10'000;
constexpr int kKeepaliveTime_ms = 60'000;
constexpr int kKeepaliveTimeout_ms = 20'000;
// Clients may ask as often as this themselves.
constexpr int kMinPingInterval_ms = 5'000;
// Calls at a time on one connection.
constexpr int kMaxStreams = 1024;
// Without an option for it: as many of the largest requests may arrive.
constexpr int kLargestAtATime = 64;

absl::Status CheckRange(absl::string_view name, int value, int low, int high) {
  if (value >= low && value <= high) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(name, " is ", value, "; it must be ", low, "..", high));
}

// gRPC's plugins are global: once for the process.
void EnablePlugins() {
  [[maybe_unused]] static const bool enabled = [] {
    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
    return true;
  }();
}

// Every server that is built later has channelz, which tells much about its
// peers: build the public one first.
void EnableChannelz() {
  [[maybe_unused]] static const bool enabled = [] {
    grpc::channelz::experimental::InitChannelzService();
    return true;
  }();
}

void SetLimits(const GrpcServerOptions& options, grpc::ServerBuilder& builder) {
  builder.SetMaxReceiveMessageSize(options.max_message_mib << 20);
  const auto buffered_mib = static_cast<size_t>(
      options.max_buffered_mib > 0 ? options.max_buffered_mib
                                   : kLargestAtATime * options.max_message_mib);
  grpc::ResourceQuota quota("treeline");
  quota.Resize(buffered_mib << 20);
  builder.SetResourceQuota(quota);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kMaxStreams);
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS,
                             kHandshake_ms);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveTime_ms);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS,
                             kKeepaliveTimeout_ms);
  builder.AddChannelArgument(
      GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS,
      kMinPingInterval_ms);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  if (options.max_connection_age_s > 0) {
    builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_AGE_MS,
                               options.max_connection_age_s * 1000);
    builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_AGE_GRACE_MS,
                               options.connection_grace_s * 1000);
  }
}

}  // namespace

absl::Status GrpcServerOptions::Validate() const {
  TL_ASSIGN_OR_RETURN(const base::ListenAddress address,
                      base::ParseListenAddress(listen));
  if (credentials == nullptr && !insecure_any_address &&
      !base::IsLoopback(address)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "refusing to listen on ", address.ToString(),
        ", which other machines may reach: the connection is neither encrypted "
        "nor authenticated. Give --tls-cert and --tls-key, listen on "
        "127.0.0.1, or accept the risk with --insecure-any-address"));
  }
  TL_RETURN_IF_ERROR(
      CheckRange("largest message (MiB)", max_message_mib, 1, 1024));
  TL_RETURN_IF_ERROR(CheckRange("memory for arriving requests (MiB)",
                                max_buffered_mib, 0, 1 << 20));
  TL_RETURN_IF_ERROR(
      CheckRange("age of connections (s)", max_connection_age_s, 0, 1'000'000));
  return CheckRange("grace of connections (s)", connection_grace_s, 1,
                    1'000'000);
}

// Destroyed from the last to the first: the server before what it calls.
struct GrpcServer::Parts {
  Parts(Dispatcher& dispatcher, const CallSource& source)
      : relocalization(dispatcher, source), scenes(dispatcher, source) {}

  RelocalizationGrpcService relocalization;
  SceneGrpcService scenes;
  std::string address;
  std::unique_ptr<grpc::Server> server;
  std::optional<SceneHealth> scene_health;
};

GrpcServer::GrpcServer(std::unique_ptr<Parts> parts)
    : parts_(std::move(parts)) {}

GrpcServer::~GrpcServer() { Stop(std::chrono::milliseconds(0)); }

absl::StatusOr<std::unique_ptr<GrpcServer>> GrpcServer::Start(
    Dispatcher& dispatcher, const repository::SceneRepository& repository,
    const GrpcServerOptions& options, const base::Clock& clock) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_ASSIGN_OR_RETURN(base::ListenAddress address,
                      base::ParseListenAddress(options.listen));
  // gRPC would fail too, but keep the reason to itself.
  TL_RETURN_IF_ERROR(base::TryBind(address));
  EnablePlugins();
  auto parts = std::make_unique<Parts>(
      dispatcher,
      CallSource{.clock = clock,
                 .admin_listener = options.kind == ListenerKind::kAdmin,
                 .certificate_names = options.certificate_names});

  grpc::ServerBuilder builder;
  // Else a second server would share the port, and half the calls, in silence.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  SetLimits(options, builder);
  if (options.kind == ListenerKind::kAdmin) {
    EnableChannelz();
  } else {
    builder.RegisterService(&parts->relocalization);
  }
  builder.RegisterService(&parts->scenes);
  int port = 0;
  builder.AddListeningPort(address.ToString(),
                           options.credentials != nullptr
                               ? options.credentials
                               : grpc::InsecureServerCredentials(),
                           &port);
  parts->server = builder.BuildAndStart();
  if (parts->server == nullptr || port == 0) {
    return absl::UnavailableError(
        absl::StrCat("cannot listen on ", address.ToString()));
  }
  address.port = port;
  parts->address = address.ToString();
  auto* health = parts->server->GetHealthCheckService();
  if (health != nullptr) parts->scene_health.emplace(repository, *health);
  return std::unique_ptr<GrpcServer>(new GrpcServer(std::move(parts)));
}

const std::string& GrpcServer::address() const { return parts_->address; }

void GrpcServer::AnnounceStop() {
  // Else it would tell that scenes serve.
  parts_->scene_health.reset();
  grpc::HealthCheckServiceInterface* health =
      parts_->server->GetHealthCheckService();
  if (health != nullptr) health->SetServingStatus(false);
  parts_->relocalization.DrainStreams();
}

void GrpcServer::Stop(std::chrono::milliseconds grace) {
  if (parts_->server == nullptr) return;
  parts_->scene_health.reset();
  parts_->relocalization.DrainStreams();
  parts_->server->Shutdown(std::chrono::system_clock::now() + grace);
  parts_->server->Wait();
  parts_->server.reset();
}

}  // namespace treeline::service
