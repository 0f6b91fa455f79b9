// Requests per second and client, on top of another policy.
#ifndef SERVER_ACCESS_RATE_LIMITED_ACCESS_H_
#define SERVER_ACCESS_RATE_LIMITED_ACCESS_H_

#include <cstddef>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "server/access/rate_limiter.h"
#include "server/service/access_policy.h"

namespace treeline::access {

struct RateLimitOptions {
  // Of one client, 0.001..1000000; 0: no limit but what its token says.
  double rate_per_s = 0;
  // Requests that may come at once after a pause, 1..1000000.
  int burst = 20;
  // Clients that are remembered, 100..10000000, about 200 bytes each.
  size_t max_clients = 100000;

  absl::Status Validate() const;
};

// Operators (Scope::kAdmin) are not limited. Of a client with a rate of its own
// the lesser holds, with a burst that is less in proportion.
class RateLimitedAccess final : public service::AccessPolicy {
 public:
  // `options` are valid; the references must outlive the policy.
  RateLimitedAccess(service::AccessPolicy& inner,
                    const RateLimitOptions& options, const base::Clock& clock);

  absl::StatusOr<service::Client> Admit(const service::CallInfo& call,
                                        service::Scope scope) override;
  absl::StatusOr<service::Client> Identify(const service::CallInfo& call,
                                           service::Scope scope) override {
    return inner_.Identify(call, scope);
  }

 private:
  absl::Status Charge(const service::Client& client);

  service::AccessPolicy& inner_;
  const RateLimitOptions options_;
  const base::Clock& clock_;
  RateLimiter limiter_;
};

// What the requests of an anonymous client are counted by: its id, but IPv6
// addresses by their first 64 bits, since who has one has all that share them.
std::string RateKeyOf(const std::string& client_id);

}  // namespace treeline::access

#endif  // SERVER_ACCESS_RATE_LIMITED_ACCESS_H_
