// One connection's requests, answered by a handler. httplib routes them and
// writes the answers. What a request is and where it ends is read here: httplib
// takes what others read in another way, and inflates without a bound.
#ifndef COMMON_HTTP_HTTP_ENGINE_H_
#define COMMON_HTTP_HTTP_ENGINE_H_

#include <httplib.h>

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "common/base/byte_budget.h"
#include "common/base/clock.h"
#include "common/http/http_message.h"
#include "common/http/http_stream.h"
#include "common/http/request_head.h"

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
    // For nothing but HttpHandler::IsProbe.
    bool only_probes = false;
    // What bodies are held by; nullptr: without a bound.
    base::ByteBudget* budget = nullptr;
    // The same of large answers, until they are written.
    base::ByteBudget* answers = nullptr;
    // Of a connection that is upgraded; see StreamDuplex.
    std::function<bool(bool idle)> mark_idle = {};
  };

  // Keeps references to `handler`, `stream` and `clock`.
  HttpEngine(HttpHandler& handler, HttpStream& stream, Connection connection,
             const base::Clock& clock);

  // Reads and answers a request. `last`: the response says that the connection
  // closes. False: it is to be closed.
  bool ServeOne(bool last);

 private:
  // What can be said before the body is read; asked once for a request.
  const std::optional<HttpResponse>& CheckHead(const httplib::Request& request);
  std::optional<HttpResponse> Refusal();
  HandlerResponse BeforeBody(const httplib::Request& request,
                             httplib::Response& response);
  void WithBody(httplib::Response& response);
  // Answers what httplib refuses on its own.
  void OnError(const httplib::Request& request, httplib::Response& response);

  // Answers what has no head of HTTP, past httplib.
  void RefuseHead();

  // Reads the body and has the handler answer; the body is let go again.
  HttpResponse AnswerToBody();
  // Sends an answer, streamed where it goes on; 503 where there is no memory to
  // hold it until it is taken.
  void Send(const HttpResponse& answer, httplib::Response& response);
  // Writes head and body of a response that goes on, and ends the connection.
  void Stream(const HttpRequest& request, const HttpResponse& response);
  // Hands the connection over, and ends it when it comes back.
  void Upgrade(const HttpRequest& request, const HttpResponse& response);

  HttpRequest Convert(const httplib::Request& request) const;
  void Apply(const HttpRequest& request, const HttpResponse& from,
             httplib::Response& to);

  HttpHandler& handler_;
  HttpStream& stream_;
  const Connection connection_;
  const base::Clock& clock_;
  // Of the request at hand.
  RequestHead head_;
  base::ByteLease answer_lease_;
  HttpRequest request_;
  bool is_head_checked_ = false;
  std::optional<HttpResponse> early_;
  bool answered_ = false;
  bool close_ = false;
};

}  // namespace treeline::http

#endif  // COMMON_HTTP_HTTP_ENGINE_H_
