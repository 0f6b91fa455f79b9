#include "server/gateway/cors.h"

#include <arpa/inet.h>

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/error_info.h"
#include "common/connect_rpc/connect_error.h"

namespace treeline::gateway {
namespace {

// "127.0.0.1:8080", "[::1]" or "localhost": no name that a stranger could give
// to this machine.
bool IsAddress(absl::string_view host) {
  if (absl::StartsWith(host, "[")) return true;
  const absl::string_view name = host.substr(0, host.find(':'));
  in_addr address{};
  return name == "localhost" ||
         inet_pton(AF_INET, std::string(name).c_str(), &address) == 1;
}

// What a browser sends: lower case, no path, no more than host and port.
bool IsOrigin(absl::string_view text) {
  if (!absl::ConsumePrefix(&text, "https://") &&
      !absl::ConsumePrefix(&text, "http://")) {
    return false;
  }
  return !text.empty() &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) {
           return absl::ascii_islower(c) || absl::ascii_isdigit(c) ||
                  absl::StrContains("-._:[]", static_cast<char>(c));
         });
}

http::HttpResponse Refusal() {
  return connect_rpc::ConnectErrorResponse(
      base::WithReason(absl::PermissionDeniedError(
                           "the server does not serve pages of this origin"),
                       "ORIGIN_REFUSED"));
}

}  // namespace

absl::Status CorsPolicy::Validate(const std::vector<std::string>& origins) {
  for (const std::string& origin : origins) {
    if (!IsOrigin(origin)) {
      return absl::InvalidArgumentError(
          absl::StrCat("'", origin,
                       "' is not an origin; give http(s)://HOST[:PORT] in "
                       "lower case, for instance https://example.com. There "
                       "are no patterns and no * for all"));
    }
  }
  return absl::OkStatus();
}

CorsPolicy::CorsPolicy(std::vector<std::string> origins, OwnPages own_pages)
    : origins_(std::move(origins)), own_pages_(own_pages) {}

std::optional<http::HttpResponse> CorsPolicy::Check(
    const http::HttpRequest& request) const {
  if (request.Header("origin").empty() || IsOwnPage(request)) {
    return std::nullopt;
  }
  if (!IsAllowed(request)) {
    if (request.method == "GET" || request.method == "HEAD") {
      return std::nullopt;
    }
    return Refusal();
  }
  if (request.method != "OPTIONS" ||
      request.Header("access-control-request-method").empty()) {
    return std::nullopt;
  }
  return http::HttpResponse{
      .status = 204,
      .headers = {{"Access-Control-Allow-Methods", "GET, POST"},
                  {"Access-Control-Allow-Headers",
                   "Accept, Authorization, Connect-Protocol-Version, "
                   "Connect-Timeout-Ms, Content-Type, Traceparent, Tracestate, "
                   "X-Treeline-Scene"},
                  {"Access-Control-Max-Age", "7200"}}};
}

std::optional<http::HttpResponse> CorsPolicy::CheckSocket(
    const http::HttpRequest& request) const {
  if (request.Header("origin").empty() || IsOwnPage(request) ||
      IsAllowed(request)) {
    return std::nullopt;
  }
  return Refusal();
}

std::vector<std::pair<std::string, std::string>> CorsPolicy::Headers(
    const http::HttpRequest& request) const {
  if (origins_.empty()) return {};
  std::vector<std::pair<std::string, std::string>> headers{{"Vary", "Origin"}};
  if (IsAllowed(request)) {
    headers.emplace_back("Access-Control-Allow-Origin",
                         std::string(request.Header("origin")));
    headers.emplace_back("Access-Control-Expose-Headers", "Retry-After");
  }
  return headers;
}

bool CorsPolicy::IsAllowed(const http::HttpRequest& request) const {
  return std::find(origins_.begin(), origins_.end(),
                   request.Header("origin")) != origins_.end();
}

bool CorsPolicy::IsOwnPage(const http::HttpRequest& request) const {
  const absl::string_view host = request.Header("host");
  const absl::string_view origin = request.Header("origin");
  switch (own_pages_) {
    case OwnPages::kNone:
      return false;
    case OwnPages::kOverHttp:
      return IsAddress(host) && origin == absl::StrCat("http://", host);
    case OwnPages::kOverTls:
      return origin == absl::StrCat("https://", host);
  }
  return false;
}

}  // namespace treeline::gateway
