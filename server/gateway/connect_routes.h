// The Connect protocol, unary: POST /treeline.v1.SERVICE/METHOD with JSON or a
// binary message. https://connectrpc.com/docs/protocol
#ifndef SERVER_GATEWAY_CONNECT_ROUTES_H_
#define SERVER_GATEWAY_CONNECT_ROUTES_H_

#include <optional>

#include "absl/strings/string_view.h"
#include "common/base/byte_budget.h"
#include "common/base/clock.h"
#include "common/http/http_message.h"
#include "server/service/dispatcher.h"

namespace treeline::gateway {

// Every unary RPC of both services. Thread-safe.
class ConnectRoutes {
 public:
  // `admin_listener`: see CallInfo. `budget`: for requests while they are
  // parsed; nullptr: without a bound. Keeps references.
  ConnectRoutes(service::Dispatcher& dispatcher, bool admin_listener,
                const base::Clock& clock, base::ByteBudget* budget = nullptr);

  // Whether `path` lies in a package of ours.
  static bool Owns(absl::string_view path);

  // Answers unknown methods (404), streaming ones (501), what is not POST (405)
  // and unknown types (415).
  std::optional<http::HttpResponse> CheckHead(
      const http::HttpRequest& request) const;

  // Of requests that CheckHead lets through: see HttpHandler::Admit.
  std::optional<http::HttpResponse> Admit(http::HttpRequest& request) const;

  // For requests that both let through.
  http::HttpResponse Handle(const http::HttpRequest& request) const;

 private:
  service::Dispatcher& dispatcher_;
  const bool admin_listener_;
  const base::Clock& clock_;
  base::ByteBudget* const budget_;
};

}  // namespace treeline::gateway

#endif  // SERVER_GATEWAY_CONNECT_ROUTES_H_
