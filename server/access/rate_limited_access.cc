#include "server/access/rate_limited_access.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <optional>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/string_view.h"
#include "absl/strings/strip.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"

namespace treeline::access {

absl::Status RateLimitOptions::Validate() const {
  if (rate_per_s != 0 && !(rate_per_s >= 0.001 && rate_per_s <= 1e6)) {
    return absl::InvalidArgumentError(
        absl::StrCat("requests per second and client: ", rate_per_s,
                     "; it must be 0.001..1000000, or 0 for no limit"));
  }
  if (burst < 1 || burst > 1000000) {
    return absl::InvalidArgumentError(
        absl::StrCat("burst is ", burst, "; it must be 1..1000000"));
  }
  if (max_clients < 100 || max_clients > 10000000) {
    return absl::InvalidArgumentError(absl::StrCat(
        "clients remembered: ", max_clients, "; it must be 100..10000000"));
  }
  return absl::OkStatus();
}

RateLimitedAccess::RateLimitedAccess(service::AccessPolicy& inner,
                                     const RateLimitOptions& options,
                                     const base::Clock& clock)
    : inner_(inner),
      options_(options),
      clock_(clock),
      limiter_(options.max_clients) {}

absl::StatusOr<service::Client> RateLimitedAccess::Admit(
    const service::CallInfo& call, service::Scope scope) {
  TL_ASSIGN_OR_RETURN(service::Client client, inner_.Admit(call, scope));
  if (scope != service::Scope::kAdmin) TL_RETURN_IF_ERROR(Charge(client));
  return client;
}

absl::Status RateLimitedAccess::Charge(const service::Client& client) {
  double rate = options_.rate_per_s;
  double burst = options_.burst;
  if (client.max_rate_per_s > 0 &&
      (rate == 0 || client.max_rate_per_s < rate)) {
    // Without a limit of ours, a second's worth may come at once.
    burst *= client.max_rate_per_s / (rate == 0 ? burst : rate);
    rate = client.max_rate_per_s;
  }
  if (rate == 0) return absl::OkStatus();
  const std::optional<std::chrono::nanoseconds> wait =
      limiter_.Take(RateKeyOf(client.id), clock_.Now(), rate,
                    std::max<int64_t>(1, std::llround(std::min(burst, 1e6))));
  if (!wait) return absl::OkStatus();
  return base::WithRetryAfter(
      base::WithReason(absl::ResourceExhaustedError(absl::StrCat(
                           "more than ", rate, " requests per second")),
                       "RATE_LIMITED", {{"rate_per_s", absl::StrCat(rate)}}),
      std::chrono::ceil<std::chrono::milliseconds>(*wait));
}

std::string RateKeyOf(const std::string& client_id) {
  absl::string_view rest = client_id;
  if (!absl::ConsumePrefix(&rest, "ipv6:")) return client_id;
  std::string address = absl::StrReplaceAll(
      rest, {{"%5B", ""}, {"%5D", ""}, {"[", ""}, {"]", ""}});
  // Of "fe80::1%eth0", the zone.
  address.resize(std::min(address.size(), address.find('%')));
  std::array<char, 16> bytes = {};
  if (inet_pton(AF_INET6, address.c_str(), bytes.data()) != 1) {
    return client_id;
  }
  // An IPv4 address that a dual-stack listener shows in this form.
  static constexpr char kMapped[12] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -1, -1};
  if (std::equal(std::begin(kMapped), std::end(kMapped), bytes.begin())) {
    return client_id;
  }
  return absl::StrCat(
      "ipv6/64:", absl::BytesToHexString(absl::string_view(bytes.data(), 8)));
}

}  // namespace treeline::access
