#include "nav_agent/service/agent_grpc_server.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/listen_address.h"
#include "common/base/status_macros.h"
#include "nav_agent/service/grpc_services.h"

namespace treeline::agent_service {
namespace {

// A peer that is silent is asked whether it lives, and cut off if it does not
// say so: a stream to it must not wait for ever.
constexpr int kKeepaliveTime_ms = 10'000;
constexpr int kKeepaliveTimeout_ms = 5'000;
constexpr int kMinPingInterval_ms = 5'000;
constexpr int kHandshake_ms = 10'000;
constexpr int kMaxMessageBytes = 1 << 20;
// Beside those of streams.
constexpr int kMoreThreads = 16;
constexpr auto kGrace = std::chrono::seconds(1);

}  // namespace

absl::Status AgentGrpcOptions::Validate() const {
  TL_ASSIGN_OR_RETURN(const base::ListenAddress address,
                      base::ParseListenAddress(listen));
  if (!insecure_any_address && !base::IsLoopback(address)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "refusing to listen on ", address.ToString(),
        ", which other machines may reach: whoever does drives the robot. "
        "Listen on 127.0.0.1 (and use ssh -L), or accept the risk with "
        "--insecure-any-address"));
  }
  if (max_streams < 1 || max_streams > 1000) {
    return absl::InvalidArgumentError(
        absl::StrCat("streams are ", max_streams, "; it must be 1..1000"));
  }
  return absl::OkStatus();
}

// Destroyed from the last to the first: the server before what it calls.
struct AgentGrpcServer::Parts {
  Parts(AgentCommands& commands, int max_streams)
      : navigation(commands, max_streams), simulation(commands) {}

  NavigationGrpcService navigation;
  SimulationGrpcService simulation;
  std::string address;
  std::unique_ptr<grpc::Server> server;
};

AgentGrpcServer::AgentGrpcServer(std::unique_ptr<Parts> parts)
    : parts_(std::move(parts)) {}

AgentGrpcServer::~AgentGrpcServer() {
  parts_->server->Shutdown(std::chrono::system_clock::now() + kGrace);
  parts_->server->Wait();
}

absl::StatusOr<std::unique_ptr<AgentGrpcServer>> AgentGrpcServer::Start(
    AgentCommands& commands, const AgentGrpcOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_ASSIGN_OR_RETURN(base::ListenAddress address,
                      base::ParseListenAddress(options.listen));
  // gRPC would fail too, but keep the reason to itself.
  TL_RETURN_IF_ERROR(base::TryBind(address));
  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  auto parts = std::make_unique<Parts>(commands, options.max_streams);
  grpc::ServerBuilder builder;
  // Else a second agent would share the port, and half the calls, in silence.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS,
                             kHandshake_ms);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveTime_ms);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS,
                             kKeepaliveTimeout_ms);
  builder.AddChannelArgument(
      GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS,
      kMinPingInterval_ms);
  builder.SetMaxReceiveMessageSize(kMaxMessageBytes);
  grpc::ResourceQuota quota("treeline-agent");
  quota.SetMaxThreads(options.max_streams + kMoreThreads);
  builder.SetResourceQuota(quota);
  builder.RegisterService(&parts->navigation);
  if (commands.is_simulated()) builder.RegisterService(&parts->simulation);
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
  return std::unique_ptr<AgentGrpcServer>(
      new AgentGrpcServer(std::move(parts)));
}

const std::string& AgentGrpcServer::address() const { return parts_->address; }

}  // namespace treeline::agent_service
