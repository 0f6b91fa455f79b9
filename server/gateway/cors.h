// Which web pages may use the service: cross-origin resource sharing.
#ifndef SERVER_GATEWAY_CORS_H_
#define SERVER_GATEWAY_CORS_H_

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "common/http/http_message.h"

namespace treeline::gateway {

// Whether the server has pages of its own, and how browsers reach them.
enum class OwnPages { kNone, kOverHttp, kOverTls };

// Origins that are allowed, each exactly as browsers send it: "https://HOST" or
// "https://HOST:PORT". There are no patterns and there is no "*": any page that
// a user happens to open could then use the user's network and call a server
// that has no other protection than its address. Pages of the server itself may
// call it under the name that they came from, which `host` and `origin` agree
// on. Without TLS that must be an address or "localhost": anyone can make a
// name of his own lead here. Immutable.
class CorsPolicy {
 public:
  // INVALID_ARGUMENT: an origin that no browser would send.
  static absl::Status Validate(const std::vector<std::string>& origins);

  explicit CorsPolicy(std::vector<std::string> origins,
                      OwnPages own_pages = OwnPages::kNone);

  // 204 for a preflight from an allowed origin; 403 for everything else that
  // comes from an origin that is not allowed, but for GET and HEAD, whose
  // answers its browser hides; nullopt: go on. Requests without an origin do
  // not come from other pages.
  std::optional<http::HttpResponse> Check(
      const http::HttpRequest& request) const;

  // 403 for a WebSocket from an origin that is not allowed: no browser asks
  // before it opens one, or hides what it says.
  std::optional<http::HttpResponse> CheckSocket(
      const http::HttpRequest& request) const;

  // Of every response: for allowed origins who may read it.
  std::vector<std::pair<std::string, std::string>> Headers(
      const http::HttpRequest& request) const;

 private:
  bool IsAllowed(const http::HttpRequest& request) const;
  bool IsOwnPage(const http::HttpRequest& request) const;

  const std::vector<std::string> origins_;
  const OwnPages own_pages_;
};

}  // namespace treeline::gateway

#endif  // SERVER_GATEWAY_CORS_H_
