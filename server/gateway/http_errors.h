// Errors as HTTP says them.
#ifndef SERVER_GATEWAY_HTTP_ERRORS_H_
#define SERVER_GATEWAY_HTTP_ERRORS_H_

#include "absl/status/status.h"
#include "common/http/http_message.h"

namespace treeline::gateway {

// The table of the Connect protocol: INVALID_ARGUMENT is 400, and so on.
int HttpStatusOf(absl::StatusCode code);

// The Connect protocol's names: "invalid_argument".
const char* ConnectCodeName(absl::StatusCode code);

// An error of the Connect protocol, which GPP answers with too: JSON of code,
// message and details (type, value in base64, and the same readable as
// `debug`), and Retry-After where trying again later may help. `status` is not
// OK.
http::HttpResponse ErrorResponse(const absl::Status& status);

// The same for an error of HTTP itself: `http_status` with `status`'s JSON.
http::HttpResponse ErrorResponse(int http_status, const absl::Status& status);

}  // namespace treeline::gateway

#endif  // SERVER_GATEWAY_HTTP_ERRORS_H_
