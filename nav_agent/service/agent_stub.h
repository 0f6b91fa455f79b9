// A running agent, as commands in a shell talk to it.
#ifndef NAV_AGENT_SERVICE_AGENT_STUB_H_
#define NAV_AGENT_SERVICE_AGENT_STUB_H_

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "treeline/v1/docks.grpc.pb.h"
#include "treeline/v1/navigation.grpc.pb.h"

namespace treeline::agent_service {

// Where `treeline-agent run` answers gRPC unless it is told otherwise.
inline constexpr char kAgentAddress[] = "127.0.0.1:50061";

std::unique_ptr<v1::NavigationService::Stub> AgentStub(
    const std::string& address);

std::unique_ptr<v1::DockingService::Stub> DockingStub(
    const std::string& address);

// What a call ended with, with the agent's address.
absl::Status CallStatus(const std::string& address, const grpc::Status& status);

// "NAVIGATOR_MODE_DRIVING" -> "driving".
std::string EnumWord(const std::string& name, absl::string_view prefix);

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_AGENT_STUB_H_
