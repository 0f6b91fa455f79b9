#include "client/cli/unavailable_hint.h"

#include <cstdlib>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "client/relocalizer/connect_options.h"

namespace treeline::client_cli {
namespace {

// The variable by which gRPC goes through a proxy; none: nullptr.
const char* ProxyVariable(const std::string& server) {
  if (relocalizer::IsOnThisMachine(server)) return nullptr;
  for (const char* name : {"grpc_proxy", "https_proxy", "http_proxy"}) {
    const char* value = std::getenv(name);
    if (value != nullptr && *value != '\0') return name;
  }
  return nullptr;
}

}  // namespace

std::string UnavailableHint(absl::string_view message,
                            const std::string& server) {
  if (absl::StrContains(message, "http1.x") ||
      absl::StrContains(message, "parsing HTTP/2")) {
    return absl::StrCat("What answers at ", server,
                        " speaks HTTP/1 and no gRPC: give the port ",
                        "that treeline-server says it is \"listening on\" "
                        "(50051), not that of ",
                        "\"http on\".");
  }
  if (absl::StrContains(message, "wrong version number")) {
    return absl::StrCat("What answers at ", server,
                        " speaks no TLS: leave --tls-ca out, or give the port ",
                        "that does.");
  }
  std::string hint = absl::StrCat("Is treeline-server running at ", server,
                                  ", and not overloaded?");
  if (const char* proxy = ProxyVariable(server); proxy != nullptr) {
    absl::StrAppend(&hint, "\nThe way there goes through the proxy of ", proxy,
                    ", unless no_proxy names the host.");
  }
  return hint;
}

}  // namespace treeline::client_cli
