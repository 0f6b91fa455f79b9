// Who may call what, by tokens and by certificates of clients.
#ifndef SERVER_ACCESS_TOKEN_ACCESS_H_
#define SERVER_ACCESS_TOKEN_ACCESS_H_

#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/access/token_verifier.h"
#include "server/service/access_policy.h"

namespace treeline::access {

struct TokenAccessOptions {
  // Whether operators may also come in where clients do, with scope `admin`.
  bool admin_on_public_listener = false;
  // Whether who reaches the admin listener may administer without a token: for
  // a listener that only this machine reaches.
  bool open_admin_listener = false;
  // What the holder of a certificate with this name may do, without a token;
  // "*": of any certificate that TLS has verified and none of whose names is
  // here.
  std::map<std::string, std::vector<service::Scope>> certificate_scopes = {};
};

// A call that brings a token is judged by it alone; else by its certificate.
class TokenAccess final : public service::AccessPolicy {
 public:
  // `verifier` may be nullptr: there are no tokens, then every one is invalid.
  // It must outlive the policy.
  TokenAccess(const TokenAccessOptions& options, TokenVerifier* verifier);

  absl::StatusOr<service::Client> Admit(const service::CallInfo& call,
                                        service::Scope scope) override;

 private:
  absl::StatusOr<service::Client> ByToken(const std::string& token,
                                          service::Scope scope) const;
  absl::StatusOr<service::Client> ByCertificate(const service::CallInfo& call,
                                                service::Scope scope) const;

  const TokenAccessOptions options_;
  TokenVerifier* const verifier_ = nullptr;
};

}  // namespace treeline::access

#endif  // SERVER_ACCESS_TOKEN_ACCESS_H_
