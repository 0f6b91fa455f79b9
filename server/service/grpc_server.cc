#include "server/service/grpc_server.h"

#include <grpcpp/ext/channelz_service_plugin.h>
#include <grpcpp/impl/server_builder_option.h>
#include <grpcpp/impl/server_builder_plugin.h>
#include <grpcpp/resource_quota.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/listen_address.h"
#include "common/base/status_macros.h"
#include "server/service/grpc_services.h"
#include "server/service/health_service.h"
#include "server/service/reflection_service.h"
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
constexpr int kLargestAtATime = 4;
// And never less than this (MiB): connections take of it too.
constexpr int kMinBuffered_mib = 64;

absl::Status CheckRange(absl::string_view name, int value, int low, int high) {
  if (value >= low && value <= high) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(name, " is ", value, "; it must be ", low, "..", high));
}

// gRPC's plugins are global: every builder that is made later has this one.
void EnableChannelz() {
  [[maybe_unused]] static const bool enabled = [] {
    grpc::channelz::experimental::InitChannelzService();
    return true;
  }();
}

// Channelz tells much about peers: not to everyone.
class WithoutPlugins final : public grpc::ServerBuilderOption {
 public:
  void UpdateArguments(grpc::ChannelArguments* /*arguments*/) override {}
  void UpdatePlugins(std::vector<std::unique_ptr<grpc::ServerBuilderPlugin>>*
                         plugins) override {
    plugins->clear();
  }
};

void SetLimits(const GrpcServerOptions& options, grpc::ServerBuilder& builder) {
  builder.SetMaxReceiveMessageSize(options.max_message_mib << 20);
  const auto buffered_mib = static_cast<size_t>(
      options.max_buffered_mib > 0
          ? options.max_buffered_mib
          : std::max(kMinBuffered_mib,
                     kLargestAtATime * options.max_message_mib));
  grpc::ResourceQuota quota("treeline");
  quota.Resize(buffered_mib << 20);
  builder.SetResourceQuota(quota);
  // Clients are told, and what they compress all the same is not inflated.
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
  builder.AddChannelArgument(GRPC_ARG_ENABLE_PER_MESSAGE_DECOMPRESSION, 0);
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
  Parts(Dispatcher& dispatcher, const CallSource& source,
        std::vector<std::string> services)
      : relocalization(dispatcher, source),
        scenes(dispatcher, source),
        health(dispatcher, source),
        reflection(std::move(services)) {}

  RelocalizationGrpcService relocalization;
  SceneGrpcService scenes;
  HealthGrpcService health;
  ReflectionGrpcService reflection;
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
  const bool is_admin = options.kind == ListenerKind::kAdmin;
  std::vector<std::string> services = {"grpc.health.v1.Health",
                                       "treeline.v1.SceneService"};
  services.emplace_back(is_admin ? "grpc.channelz.v1.Channelz"
                                 : "treeline.v1.RelocalizationService");
  auto parts = std::make_unique<Parts>(
      dispatcher,
      CallSource{.clock = clock,
                 .budget = options.budget,
                 .admin_listener = is_admin,
                 .certificate_names = options.certificate_names},
      std::move(services));

  // A builder takes the plugins that there are when it is made.
  if (is_admin) EnableChannelz();
  grpc::ServerBuilder builder;
  // Else a second server would share the port, and half the calls, in silence.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  SetLimits(options, builder);
  if (!is_admin) {
    builder.SetOption(std::make_unique<WithoutPlugins>());
    builder.RegisterService(&parts->relocalization);
  }
  builder.RegisterService(&parts->scenes);
  builder.RegisterService(&parts->health);
  builder.RegisterService(&parts->reflection);
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
  parts->scene_health.emplace(repository, parts->health);
  return std::unique_ptr<GrpcServer>(new GrpcServer(std::move(parts)));
}

const std::string& GrpcServer::address() const { return parts_->address; }

void GrpcServer::AnnounceStop() {
  // Else it would tell that scenes serve.
  parts_->scene_health.reset();
  parts_->health.Stop();
  parts_->relocalization.DrainStreams();
}

void GrpcServer::Stop(std::chrono::milliseconds grace) {
  if (parts_->server == nullptr) return;
  parts_->scene_health.reset();
  parts_->relocalization.DrainStreams();
  // Else Watch would last as long as its clients.
  parts_->health.Stop();
  parts_->server->Shutdown(std::chrono::system_clock::now() + grace);
  parts_->server->Wait();
  parts_->server.reset();
}

}  // namespace treeline::service
