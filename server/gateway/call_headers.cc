#include "server/gateway/call_headers.h"

#include <string>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/string_view.h"
#include "common/base/status_macros.h"
#include "common/connect_rpc/connect_router.h"

namespace treeline::gateway {
namespace {

std::string BearerToken(absl::string_view authorization) {
  constexpr absl::string_view kScheme = "bearer ";
  if (!absl::StartsWithIgnoreCase(authorization, kScheme)) return "";
  return std::string(
      absl::StripAsciiWhitespace(authorization.substr(kScheme.size())));
}

}  // namespace

absl::StatusOr<service::CallInfo> CallInfoOf(const http::HttpRequest& request,
                                             const char* rpc,
                                             bool admin_listener) {
  TL_ASSIGN_OR_RETURN(const base::MonotonicTime deadline,
                      connect_rpc::ConnectDeadline(request));
  return service::CallInfo{
      .rpc = rpc,
      .transport = "http",
      .peer = request.peer,
      .credentials = {.bearer_token =
                          BearerToken(request.Header("authorization")),
                      .certificate_names = request.certificate_names},
      .traceparent = std::string(request.Header("traceparent")),
      .client = request.client,
      .admin_listener = admin_listener,
      .arrival = request.arrival,
      .deadline = deadline};
}

absl::Status AdmitRequest(service::Dispatcher& dispatcher, const char* rpc,
                          service::Scope scope, bool admin_listener,
                          const base::Clock& clock,
                          http::HttpRequest& request) {
  request.arrival = clock.Now();
  TL_ASSIGN_OR_RETURN(const service::CallInfo call,
                      CallInfoOf(request, rpc, admin_listener));
  TL_ASSIGN_OR_RETURN(service::Client client, dispatcher.Admit(call, scope));
  request.client = std::move(client.id);
  return absl::OkStatus();
}

}  // namespace treeline::gateway
