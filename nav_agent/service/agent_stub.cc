#include "nav_agent/service/agent_stub.h"

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/status_macros.h"
#include "common/wire/status.h"

namespace treeline::agent_service {
namespace {

// A robot is in the same network: a proxy of the environment, which leads out
// of it, does not know the way.
std::shared_ptr<grpc::Channel> AgentChannel(const std::string& address) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(),
                                   arguments);
}

}  // namespace

std::unique_ptr<v1::NavigationService::Stub> AgentStub(
    const std::string& address) {
  return v1::NavigationService::NewStub(AgentChannel(address));
}

std::unique_ptr<v1::DockingService::Stub> DockingStub(
    const std::string& address) {
  return v1::DockingService::NewStub(AgentChannel(address));
}

absl::Status CallStatus(const std::string& address,
                        const grpc::Status& status) {
  if (status.error_code() == grpc::StatusCode::UNAVAILABLE &&
      absl::StrContains(status.error_message(), "connect")) {
    return absl::UnavailableError(absl::StrCat(
        address,
        ": no agent answers there; `treeline-agent run` must be running, and "
        "says `grpc on HOST:PORT`, which --agent takes (",
        status.error_message(), ")"));
  }
  return base::Annotate(wire::FromGrpc(status), address);
}

std::string EnumWord(const std::string& name, absl::string_view prefix) {
  return absl::AsciiStrToLower(absl::StripPrefix(name, prefix));
}

}  // namespace treeline::agent_service
