// What the headers of a request say about a call.
#ifndef SERVER_GATEWAY_CALL_HEADERS_H_
#define SERVER_GATEWAY_CALL_HEADERS_H_

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "common/http/http_message.h"
#include "server/service/access_policy.h"
#include "server/service/call.h"
#include "server/service/dispatcher.h"

namespace treeline::gateway {

// Peer, credentials (a "Bearer" token of Authorization, names of the client's
// certificate), traceparent, arrival, and the deadline of Connect-Timeout-Ms.
// `rpc` is a literal. INVALID_ARGUMENT: a time-out that is not 1 to 10 digits.
absl::StatusOr<service::CallInfo> CallInfoOf(const http::HttpRequest& request,
                                             const char* rpc,
                                             bool admin_listener);

// Asks the dispatcher whether the request is let in, before its body is read,
// and notes in it who that is.
absl::Status AdmitRequest(service::Dispatcher& dispatcher, const char* rpc,
                          service::Scope scope, bool admin_listener,
                          const base::Clock& clock, http::HttpRequest& request);

}  // namespace treeline::gateway

#endif  // SERVER_GATEWAY_CALL_HEADERS_H_
