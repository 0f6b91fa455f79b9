// Who may call what, and how often.
#ifndef SERVER_SERVICE_ACCESS_POLICY_H_
#define SERVER_SERVICE_ACCESS_POLICY_H_

#include <string>

#include "absl/status/statusor.h"
#include "server/service/call.h"

namespace treeline::service {

// What a call needs to be allowed to do. kInspect: look at what was kept of
// others' queries, pictures included.
enum class Scope { kLocalize, kAdmin, kInspect };

// Who calls.
struct Client {
  // Stable for one client: the subject of its token, the name in its
  // certificate, or the address of an anonymous one without its port. The queue
  // is shared fairly between these.
  std::string id = {};
  // Requests a second that its token promises it, which may be less than what
  // the server allows everyone; 0: nothing said.
  double max_rate_per_s = 0;
};

class AccessPolicy {
 public:
  virtual ~AccessPolicy() = default;

  // Asked once for each call, before anything is decoded; counts it against the
  // client's rate. Thread-safe; quick.
  //   UNAUTHENTICATED     TOKEN_MISSING, TOKEN_INVALID, TOKEN_EXPIRED
  //   PERMISSION_DENIED   SCOPE_MISSING, ADMIN_LISTENER_ONLY
  //   RESOURCE_EXHAUSTED  RATE_LIMITED, with the time to try again
  virtual absl::StatusOr<Client> Admit(const CallInfo& call, Scope scope) = 0;

  // The same without counting, for what is not a call yet: a stream before its
  // first frame, a reader of metrics.
  virtual absl::StatusOr<Client> Identify(const CallInfo& call, Scope scope) {
    return Admit(call, scope);
  }
};

// Without tokens: everyone may localize, and administer through the admin
// listener. Nobody may inspect: there is nobody to be told from others.
class OpenAccess final : public AccessPolicy {
 public:
  absl::StatusOr<Client> Admit(const CallInfo& call, Scope scope) override;
};

// "ipv4:10.0.0.7:41234" -> "ipv4:10.0.0.7", "ipv6:%5B::1%5D:1234" ->
// "ipv6:%5B::1%5D". What has no port stays as it is: "unix:/run/treeline.sock".
std::string PeerWithoutPort(const std::string& peer);

}  // namespace treeline::service

#endif  // SERVER_SERVICE_ACCESS_POLICY_H_
