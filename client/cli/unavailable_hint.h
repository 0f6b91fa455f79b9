#ifndef CLIENT_CLI_UNAVAILABLE_HINT_H_
#define CLIENT_CLI_UNAVAILABLE_HINT_H_

#include <string>

#include "absl/strings/string_view.h"

namespace treeline::client_cli {

// What to look at if a call to `server` was UNAVAILABLE, as gRPC's message and
// the environment's proxies tell.
std::string UnavailableHint(absl::string_view message,
                            const std::string& server);

}  // namespace treeline::client_cli

#endif  // CLIENT_CLI_UNAVAILABLE_HINT_H_
