// POST /localize: a picture in, JSON out. What `curl` and a page's form send,
// for whom no client library is worth it.
#ifndef SERVER_GATEWAY_PICTURE_ROUTES_H_
#define SERVER_GATEWAY_PICTURE_ROUTES_H_

#include <optional>

#include "absl/strings/string_view.h"
#include "common/base/byte_budget.h"
#include "common/base/clock.h"
#include "common/http/http_message.h"
#include "server/service/dispatcher.h"

namespace treeline::gateway {

// The answer is that of RelocalizationService.Localize, and so are the errors.
// Thread-safe.
class PictureRoutes {
 public:
  // `admin_listener`: see CallInfo; `budget`: for requests while they are
  // parsed; nullptr: without a bound. Keeps references.
  PictureRoutes(service::Dispatcher& dispatcher, bool admin_listener,
                const base::Clock& clock, base::ByteBudget* budget);

  static bool Owns(absl::string_view path) { return path == "/localize"; }

  std::optional<http::HttpResponse> CheckHead(
      const http::HttpRequest& request) const;
  // Of requests that CheckHead lets through: see HttpHandler::Admit.
  std::optional<http::HttpResponse> Admit(http::HttpRequest& request) const;
  http::HttpResponse Handle(const http::HttpRequest& request) const;

 private:
  absl::StatusOr<http::HttpResponse> Localize(
      const http::HttpRequest& http) const;

  service::Dispatcher& dispatcher_;
  const bool admin_listener_;
  const base::Clock& clock_;
  base::ByteBudget* const budget_;
};

}  // namespace treeline::gateway

#endif  // SERVER_GATEWAY_PICTURE_ROUTES_H_
