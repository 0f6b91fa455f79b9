#include "server/service/grpc_server.h"

#include <grpcpp/ext/channelz_service_plugin.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/listen_address.h"
#include "common/base/status_macros.h"
#include "common/grpc_server/grpc_listener.h"
#include "common/grpc_server/reflection_service.h"
#include "server/service/grpc_services.h"
#include "server/service/health_service.h"
#include "server/service/scene_health.h"

namespace treeline::service {
namespace {

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

grpc_server::GrpcListenerOptions ListenerOptionsOf(
    const GrpcServerOptions& options) {
  const auto buffered_mib = static_cast<size_t>(
      options.max_buffered_mib > 0
          ? options.max_buffered_mib
          : std::max(kMinBuffered_mib,
                     kLargestAtATime * options.max_message_mib));
  grpc_server::GrpcListenerOptions listener{
      .listen = options.listen,
      .credentials = options.credentials,
      .default_health = false,
      .max_message_bytes = options.max_message_mib << 20,
      .allow_compression = false,
      .max_buffered_bytes = buffered_mib << 20,
      .max_calls_of_connection = kMaxStreams,
      .keepalive_without_calls = true,
      .max_connection_age_s = options.max_connection_age_s,
      .connection_grace_s = options.connection_grace_s,
      .guard = options.guard};
  // It tells much about peers: not to everyone.
  if (options.kind == ListenerKind::kAdmin) {
    listener.plugins.push_back(
        {"channelz_service",
         &grpc::channelz::experimental::InitChannelzService});
  }
  return listener;
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
  grpc_server::ReflectionService reflection;
  grpc_server::GrpcListener listener;
  std::optional<SceneHealth> scene_health;
};

GrpcServer::GrpcServer(std::unique_ptr<Parts> parts)
    : parts_(std::move(parts)) {}

GrpcServer::~GrpcServer() { Stop(std::chrono::milliseconds(0)); }

absl::StatusOr<std::unique_ptr<GrpcServer>> GrpcServer::Start(
    Dispatcher& dispatcher, const repository::SceneRepository& repository,
    const GrpcServerOptions& options, const base::Clock& clock) {
  TL_RETURN_IF_ERROR(options.Validate());
  const bool is_admin = options.kind == ListenerKind::kAdmin;
  std::vector<std::string> services = {"grpc.health.v1.Health",
                                       "treeline.v1.SceneService"};
  services.emplace_back(is_admin ? "grpc.channelz.v1.Channelz"
                                 : "treeline.v1.RelocalizationService");
  auto parts = std::make_unique<Parts>(
      dispatcher,
      CallSource{.clock = clock,
                 .budget = options.budget,
                 .answers = options.answers,
                 .admin_listener = is_admin,
                 .certificate_names = options.certificate_names},
      std::move(services));

  TL_ASSIGN_OR_RETURN(
      parts->listener,
      grpc_server::StartGrpcListener(
          ListenerOptionsOf(options), [&](grpc::ServerBuilder& builder) {
            if (!is_admin) builder.RegisterService(&parts->relocalization);
            builder.RegisterService(&parts->scenes);
            builder.RegisterService(&parts->health);
            builder.RegisterService(&parts->reflection);
          }));
  parts->scene_health.emplace(repository, parts->health);
  return std::unique_ptr<GrpcServer>(new GrpcServer(std::move(parts)));
}

const std::string& GrpcServer::address() const {
  return parts_->listener.address;
}

void GrpcServer::AnnounceStop() {
  // Else it would tell that scenes serve.
  parts_->scene_health.reset();
  parts_->health.Stop();
  parts_->relocalization.DrainStreams();
}

void GrpcServer::Stop(std::chrono::milliseconds grace) {
  if (parts_->listener.server == nullptr) return;
  parts_->scene_health.reset();
  parts_->relocalization.DrainStreams();
  // Else Watch would last as long as its clients.
  parts_->health.Stop();
  parts_->listener.server->Shutdown(std::chrono::system_clock::now() + grace);
  parts_->listener.server->Wait();
  parts_->listener.server.reset();
}

}  // namespace treeline::service
