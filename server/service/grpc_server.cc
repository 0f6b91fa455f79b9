#include "server/service/grpc_server.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/parallel_for.h"
#include "common/base/status_macros.h"
#include "server/service/grpc_services.h"
#include "server/service/listen_address.h"
#include "server/service/localize_rpc.h"
#include "server/service/worker_pool.h"

namespace treeline {
namespace {

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

}  // namespace

absl::Status GrpcServerOptions::Validate() const {
  TL_ASSIGN_OR_RETURN(const ListenAddress address, ParseListenAddress(listen));
  if (!insecure_any_address && !IsLoopback(address)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "refusing to listen on ", address.ToString(),
        ", which other machines may reach: the connection is neither encrypted "
        "nor authenticated. Listen on 127.0.0.1, or accept the risk with "
        "--insecure-any-address"));
  }
  TL_RETURN_IF_ERROR(CheckRange("number of workers", workers, 0, 1024));
  TL_RETURN_IF_ERROR(CheckRange("length of the queue", queue, 1, 100000));
  return CheckRange("largest message (MiB)", max_message_mib, 1, 1024);
}

// Destroyed from the last to the first: the server before what it calls.
struct GrpcServer::Parts {
  Parts(SceneRepository& repository, const GrpcServerOptions& options,
        CallObserver& observer, const Clock& clock)
      : localize(repository, options.decode_limits, clock),
        workers(options.workers > 0 ? options.workers : HardwareThreads(),
                options.queue, clock),
        relocalization(localize, workers, observer, clock),
        scenes(repository, observer, clock) {}

  const LocalizeRpc localize;
  WorkerPool workers;
  RelocalizationGrpcService relocalization;
  SceneGrpcService scenes;
  std::string address;
  std::unique_ptr<grpc::Server> server;
};

GrpcServer::GrpcServer(std::unique_ptr<Parts> parts)
    : parts_(std::move(parts)) {}

GrpcServer::~GrpcServer() { Stop(std::chrono::milliseconds(0)); }

absl::StatusOr<std::unique_ptr<GrpcServer>> GrpcServer::Start(
    SceneRepository& repository, const GrpcServerOptions& options,
    CallObserver& observer, const Clock& clock) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_ASSIGN_OR_RETURN(ListenAddress address,
                      ParseListenAddress(options.listen));
  // gRPC would fail too, but keep the reason to itself.
  TL_RETURN_IF_ERROR(TryBind(address));
  EnablePlugins();
  auto parts = std::make_unique<Parts>(repository, options, observer, clock);

  grpc::ServerBuilder builder;
  // Else a second server would share the port, and half the calls, in silence.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  builder.SetMaxReceiveMessageSize(options.max_message_mib << 20);
  builder.RegisterService(&parts->relocalization);
  builder.RegisterService(&parts->scenes);
  int port = 0;
  builder.AddListeningPort(address.ToString(),
                           grpc::InsecureServerCredentials(), &port);
  parts->server = builder.BuildAndStart();
  if (parts->server == nullptr || port == 0) {
    return absl::UnavailableError(
        absl::StrCat("cannot listen on ", address.ToString()));
  }
  address.port = port;
  parts->address = address.ToString();
  return std::unique_ptr<GrpcServer>(new GrpcServer(std::move(parts)));
}

const std::string& GrpcServer::address() const { return parts_->address; }

void GrpcServer::AnnounceStop() {
  grpc::HealthCheckServiceInterface* health =
      parts_->server->GetHealthCheckService();
  if (health != nullptr) health->SetServingStatus(false);
}

void GrpcServer::Stop(std::chrono::milliseconds grace) {
  if (parts_->server == nullptr) return;
  parts_->server->Shutdown(std::chrono::system_clock::now() + grace);
  parts_->server->Wait();
  parts_->server.reset();
}

}  // namespace treeline
