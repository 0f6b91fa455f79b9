#include "server/service/access_policy.h"

#include "common/base/error_info.h"

namespace treeline::service {

absl::StatusOr<Client> OpenAccess::Admit(const CallInfo& call, Scope scope) {
  if (scope == Scope::kAdmin && !call.admin_listener) {
    return base::WithReason(
        absl::PermissionDeniedError("operators call the admin listener"),
        "ADMIN_LISTENER_ONLY");
  }
  if (scope == Scope::kInspect) {
    return base::WithReason(
        absl::PermissionDeniedError("this needs the scope 'inspect', and this "
                                    "server is not configured for tokens"),
        "SCOPE_MISSING", {{"scope", "inspect"}});
  }
  return Client{.id = PeerWithoutPort(call.peer)};
}

std::string PeerWithoutPort(const std::string& peer) {
  const bool ipv4 = peer.rfind("ipv4:", 0) == 0;
  const bool ipv6 = peer.rfind("ipv6:", 0) == 0;
  // The path of a socket may hold colons.
  if (!ipv4 && !ipv6) return peer;
  const size_t colon = peer.rfind(':');
  if (ipv6) {
    // gRPC escapes the brackets: "ipv6:%5B::1%5D:1234".
    const bool escaped = colon >= 3 && peer.compare(colon - 3, 3, "%5D") == 0;
    if (!escaped && peer[colon - 1] != ']') return peer;
  } else if (colon < sizeof("ipv4:") - 1) {
    return peer;
  }
  return peer.substr(0, colon);
}

}  // namespace treeline::service
