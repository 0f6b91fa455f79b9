// Errors as the Connect protocol says them.
// https://connectrpc.com/docs/protocol#error-codes
#ifndef COMMON_CONNECT_RPC_CONNECT_ERROR_H_
#define COMMON_CONNECT_RPC_CONNECT_ERROR_H_

#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "common/http/http_message.h"

namespace treeline::connect_rpc {

// The protocol's table: INVALID_ARGUMENT is 400, and so on.
int ConnectHttpStatus(absl::StatusCode code);

// The protocol's names: "invalid_argument", "canceled".
const char* ConnectCode(absl::StatusCode code);

// INVALID_ARGUMENT with reason INVALID_REQUEST.
absl::Status InvalidRequest(absl::string_view message);

// A JSON object of code, message and details (type, value in unpadded base64,
// and the same readable as `debug`). One line; bytes that are not UTF-8 become
// U+FFFD. `status` is not OK.
std::string ConnectErrorJson(const absl::Status& status);

// ConnectErrorJson with the status of its code, and Retry-After where trying
// again later may help.
http::HttpResponse ConnectErrorResponse(const absl::Status& status);
// The same for an error of HTTP itself.
http::HttpResponse ConnectErrorResponse(int http_status,
                                        const absl::Status& status);

}  // namespace treeline::connect_rpc

#endif  // COMMON_CONNECT_RPC_CONNECT_ERROR_H_
