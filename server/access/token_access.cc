#include "server/access/token_access.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"

namespace treeline::access {
namespace {

const char* NameOf(service::Scope scope) {
  switch (scope) {
    case service::Scope::kAdmin:
      return "admin";
    case service::Scope::kInspect:
      return "inspect";
    case service::Scope::kLocalize:
      break;
  }
  return "localize";
}

bool Holds(const TokenClaims& claims, service::Scope scope) {
  switch (scope) {
    case service::Scope::kAdmin:
      return claims.may_administer;
    case service::Scope::kInspect:
      return claims.may_inspect;
    case service::Scope::kLocalize:
      break;
  }
  return claims.may_localize;
}

absl::Status ScopeMissing(service::Scope scope) {
  return base::WithReason(absl::PermissionDeniedError(absl::StrCat(
                              "this needs the scope '", NameOf(scope), "'")),
                          "SCOPE_MISSING", {{"scope", NameOf(scope)}});
}

bool Holds(const std::vector<service::Scope>& scopes, service::Scope scope) {
  return std::find(scopes.begin(), scopes.end(), scope) != scopes.end();
}

}  // namespace

TokenAccess::TokenAccess(const TokenAccessOptions& options,
                         TokenVerifier* verifier)
    : options_(options), verifier_(verifier) {}

absl::StatusOr<service::Client> TokenAccess::Admit(
    const service::CallInfo& call, service::Scope scope) {
  if (scope == service::Scope::kAdmin) {
    if (!call.admin_listener && !options_.admin_on_public_listener) {
      return base::WithReason(
          absl::PermissionDeniedError("operators call the admin listener"),
          "ADMIN_LISTENER_ONLY");
    }
    if (call.admin_listener && options_.open_admin_listener) {
      return service::Client{.id = service::PeerWithoutPort(call.peer)};
    }
  }
  if (!call.credentials.bearer_token.empty()) {
    return ByToken(call.credentials.bearer_token, scope);
  }
  return ByCertificate(call, scope);
}

absl::StatusOr<service::Client> TokenAccess::ByToken(
    const std::string& token, service::Scope scope) const {
  if (verifier_ == nullptr) {
    return base::WithReason(
        absl::UnauthenticatedError("this server is not configured for tokens"),
        "TOKEN_INVALID");
  }
  TL_ASSIGN_OR_RETURN(TokenClaims claims, verifier_->Verify(token));
  if (!Holds(claims, scope)) return ScopeMissing(scope);
  return service::Client{.id = std::move(claims.subject),
                         .max_rate_per_s = claims.rate_per_s};
}

absl::StatusOr<service::Client> TokenAccess::ByCertificate(
    const service::CallInfo& call, service::Scope scope) const {
  const std::vector<std::string>& names = call.credentials.certificate_names;
  const auto end = options_.certificate_scopes.end();
  bool known = false;
  for (const std::string& name : names) {
    const auto entry = options_.certificate_scopes.find(name);
    if (entry == end) continue;
    known = true;
    if (Holds(entry->second, scope)) return service::Client{.id = name};
  }
  const auto any = options_.certificate_scopes.find("*");
  if (!known && any != end && !names.empty()) {
    known = true;
    if (Holds(any->second, scope)) return service::Client{.id = names.front()};
  }
  if (known) return ScopeMissing(scope);
  return base::WithReason(
      absl::UnauthenticatedError(
          names.empty() ? "this needs a token ('authorization: Bearer ...')"
                        : "nothing is known about the client's certificate, "
                          "and there is no token"),
      "TOKEN_MISSING");
}

}  // namespace treeline::access
