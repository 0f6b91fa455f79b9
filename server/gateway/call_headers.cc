#include "server/gateway/call_headers.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/strip.h"
#include "common/base/error_info.h"
#include "common/connect_rpc/connect_error.h"
#include "server/service/message_shape.h"

namespace treeline::gateway {
namespace {

// The Connect protocol allows this many.
constexpr size_t kMaxTimeoutDigits = 10;
constexpr std::chrono::milliseconds kPatienceForMemory{2000};

std::string BearerToken(absl::string_view authorization) {
  constexpr absl::string_view kScheme = "bearer ";
  if (!absl::StartsWithIgnoreCase(authorization, kScheme)) return "";
  return std::string(
      absl::StripAsciiWhitespace(authorization.substr(kScheme.size())));
}

}  // namespace

std::string MediaType(absl::string_view content_type) {
  return absl::AsciiStrToLower(absl::StripAsciiWhitespace(
      content_type.substr(0, content_type.find(';'))));
}

absl::Status InvalidRequest(absl::string_view message) {
  return base::WithReason(absl::InvalidArgumentError(message),
                          "INVALID_REQUEST");
}

absl::StatusOr<service::CallInfo> CallInfoOf(const http::HttpRequest& request,
                                             const char* rpc,
                                             bool admin_listener) {
  service::CallInfo call{
      .rpc = rpc,
      .transport = "http",
      .peer = request.peer,
      .credentials = {.bearer_token =
                          BearerToken(request.Header("authorization")),
                      .certificate_names = request.certificate_names},
      .traceparent = std::string(request.Header("traceparent")),
      .client = request.client,
      .admin_listener = admin_listener,
      .arrival = request.arrival};
  const absl::string_view timeout = request.Header("connect-timeout-ms");
  if (!timeout.empty()) {
    int64_t milliseconds = 0;
    if (timeout.size() > kMaxTimeoutDigits ||
        !std::all_of(timeout.begin(), timeout.end(), absl::ascii_isdigit) ||
        !absl::SimpleAtoi(timeout, &milliseconds)) {
      return InvalidRequest(
          "connect-timeout-ms: not a number of milliseconds of up to 10 "
          "digits");
    }
    call.deadline = request.arrival + std::chrono::milliseconds(milliseconds);
  }
  return call;
}

std::optional<http::HttpResponse> AdmitRequest(
    service::Dispatcher& dispatcher, const char* rpc, service::Scope scope,
    bool admin_listener, const base::Clock& clock, http::HttpRequest& request) {
  request.arrival = clock.Now();
  const absl::StatusOr<service::CallInfo> call =
      CallInfoOf(request, rpc, admin_listener);
  if (!call.ok()) return connect_rpc::ConnectErrorResponse(call.status());
  absl::StatusOr<service::Client> client = dispatcher.Admit(*call, scope);
  if (!client.ok()) return connect_rpc::ConnectErrorResponse(client.status());
  request.client = std::move(client->id);
  return std::nullopt;
}

absl::StatusOr<base::ByteLease> LeaseForParsing(
    base::ByteBudget* budget, const http::HttpRequest& request) {
  // JSON: what base64 becomes, the message in bytes, and the message.
  const bool is_json =
      MediaType(request.Header("content-type")) != "application/proto";
  base::ByteLease lease(budget);
  if (lease.Resize((is_json ? 3 : 1) * request.body.size(),
                   kPatienceForMemory)) {
    return lease;
  }
  return service::NoMemoryForRequest();
}

}  // namespace treeline::gateway
