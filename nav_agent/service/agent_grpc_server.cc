#include "nav_agent/service/agent_grpc_server.h"

#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/clock.h"
#include "common/base/listen_address.h"
#include "common/base/status_macros.h"
#include "common/flood_guard/flood_guard.h"
#include "common/grpc_server/grpc_listener.h"
#include "common/grpc_server/reflection_service.h"
#include "nav_agent/service/grpc_services.h"

namespace treeline::agent_service {
namespace {

// A goal should not outlive by much the one who gave it.
constexpr int kKeepaliveTime_ms = 10'000;
constexpr int kKeepaliveTimeout_ms = 5'000;
constexpr int kMaxMessageBytes = 1 << 20;
// Beside those of streams.
constexpr int kMoreThreads = 16;
constexpr auto kGrace = std::chrono::seconds(1);
// Of one address: a joystick sends fifty commands a second.
constexpr flood_guard::FloodLimits kFloodLimits{
    .calls_per_s = 500, .open_calls = 512, .connections = 128};

std::vector<std::string> ServiceNames(bool is_simulated) {
  std::vector<std::string> names = {"grpc.health.v1.Health",
                                    "treeline.v1.NavigationService",
                                    "treeline.v1.DockingService"};
  if (is_simulated) names.emplace_back("treeline.v1.SimulationService");
  return names;
}

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
  Parts(AgentCommands& commands, const AgentGrpcOptions& options)
      : guard(std::make_shared<flood_guard::FloodGuard>(kFloodLimits, clock,
                                                        options.report)),
        navigation(commands, options.max_streams),
        docking(commands, options.max_streams),
        simulation(commands),
        reflection(ServiceNames(commands.is_simulated())) {}
  ~Parts() { guard->StopReporting(); }

  const base::SteadyClock clock;
  const std::shared_ptr<flood_guard::FloodGuard> guard;
  NavigationGrpcService navigation;
  DockingGrpcService docking;
  SimulationGrpcService simulation;
  grpc_server::ReflectionService reflection;
  grpc_server::GrpcListener listener;
};

AgentGrpcServer::AgentGrpcServer(std::unique_ptr<Parts> parts)
    : parts_(std::move(parts)) {}

AgentGrpcServer::~AgentGrpcServer() {
  parts_->listener.server->Shutdown(std::chrono::system_clock::now() + kGrace);
  parts_->listener.server->Wait();
}

absl::StatusOr<std::unique_ptr<AgentGrpcServer>> AgentGrpcServer::Start(
    AgentCommands& commands, const AgentGrpcOptions& options) {
  TL_RETURN_IF_ERROR(options.Validate());
  auto parts = std::make_unique<Parts>(commands, options);
  TL_ASSIGN_OR_RETURN(parts->listener,
                      grpc_server::StartGrpcListener(
                          {.listen = options.listen,
                           .max_message_bytes = kMaxMessageBytes,
                           .max_threads = options.max_streams + kMoreThreads,
                           .keepalive_time_ms = kKeepaliveTime_ms,
                           .keepalive_timeout_ms = kKeepaliveTimeout_ms,
                           .guard = parts->guard},
                          [&](grpc::ServerBuilder& builder) {
                            builder.RegisterService(&parts->navigation);
                            builder.RegisterService(&parts->docking);
                            builder.RegisterService(&parts->reflection);
                            if (commands.is_simulated()) {
                              builder.RegisterService(&parts->simulation);
                            }
                          }));
  return std::unique_ptr<AgentGrpcServer>(
      new AgentGrpcServer(std::move(parts)));
}

const std::string& AgentGrpcServer::address() const {
  return parts_->listener.address;
}

}  // namespace treeline::agent_service
