// One connection's requests, parsed by httplib, answered by a handler.
#ifndef COMMON_HTTP_HTTP_ENGINE_H_
#define COMMON_HTTP_HTTP_ENGINE_H_

#include <httplib.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/http/http_message.h"
#include "common/http/http_stream.h"

namespace treeline::http {

// For one thread. httplib's server without its sockets: each connection has an
// own one, so that a handler's request knows its connection.
class HttpEngine final : private httplib::Server {
 public:
  struct Connection {
    // For HttpRequest::socket.
    int socket = -1;
    std::vector<std::string> certificate_names = {};
    size_t max_body_bytes = 0;
  };

  // Keeps references to `handler`, `stream` and `clock`.
  HttpEngine(HttpHandler& handler, HttpStream& stream, Connection connection,
             const base::Clock& clock);

  // Reads and answers a request. `last`: the response says that the connection
  // closes. False: it is to be closed.
  bool ServeOne(bool last);

 private:
  // What can be said before the body is read.
  std::optional<HttpResponse> CheckHead(const httplib::Request& request);
  HandlerResponse BeforeBody(const httplib::Request& request,
                             httplib::Response& response);
  void WithBody(const httplib::Request& request, httplib::Response& response,
                const httplib::ContentReader& read);
  // Answers what httplib refuses on its own.
  void OnError(const httplib::Request& request, httplib::Response& response);

  // Writes head and body of a response that goes on, and ends the connection.
  void Stream(const HttpRequest& request, const HttpResponse& response);

  HttpRequest Convert(const httplib::Request& request) const;
  void Apply(const HttpRequest& request, const HttpResponse& from,
             httplib::Response& to);

  HttpHandler& handler_;
  HttpStream& stream_;
  const Connection connection_;
  const base::Clock& clock_;
  // Of the request at hand.
  bool answered_ = false;
  bool close_ = false;
};

}  // namespace treeline::http

#endif  // COMMON_HTTP_HTTP_ENGINE_H_
