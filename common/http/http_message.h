// Requests and responses as handlers see them, without a socket.
#ifndef COMMON_HTTP_HTTP_MESSAGE_H_
#define COMMON_HTTP_HTTP_MESSAGE_H_

#include <sys/types.h>

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/string_view.h"
#include "common/base/clock.h"

namespace treeline::http {

struct HttpRequest {
  // "POST".
  std::string method = {};
  // Decoded, without the query.
  std::string path = {};
  // What stands behind the path's question mark, decoded, in no order but that
  // of each name's values.
  std::multimap<std::string, std::string> query = {};
  // Names in lower case, values as they came. Of a header that came twice, the
  // first.
  std::map<std::string, std::string> headers = {};
  std::string body = {};
  // "ipv4:127.0.0.1:41234" or "ipv6:[::1]:41234".
  std::string peer = {};
  // Of the client's certificate; empty: none.
  std::vector<std::string> certificate_names = {};
  // When the whole request had arrived.
  base::MonotonicTime arrival = {};
  // The client's connection, to be watched only; -1: none.
  int socket = -1;
  // Whom HttpHandler::Admit has taken the client for; nullopt: not asked. No
  // header sets it.
  std::optional<std::string> client = std::nullopt;

  // Empty: it has none. `lower_case_name` as it says.
  absl::string_view Header(const std::string& lower_case_name) const {
    const auto header = headers.find(lower_case_name);
    return header == headers.end() ? absl::string_view() : header->second;
  }
};

// Takes a body that goes on for as long as there is something to tell.
class HttpBodyWriter {
 public:
  virtual ~HttpBodyWriter() = default;
  // Waits until the system has taken the bytes, for no longer than
  // StreamLimits::write_timeout. False: the client has gone, or does not read;
  // nothing more can be written.
  virtual bool Write(absl::string_view bytes) = 0;
};

// A connection that is no longer one of requests and answers: bytes both ways.
// For the thread of the connection.
class HttpDuplex : public HttpBodyWriter {
 public:
  struct Readiness {
    // ReadSome() has something to say.
    bool can_read = false;
    // `other` of Wait() can be read.
    bool other = false;
    // The client has closed its half, or all of it; there may be more to read.
    bool has_gone = false;
  };

  // Waits until there is something to read, from the connection, if `reads`, or
  // from the descriptor `other`, until `until`. What is expected of a client
  // that has begun to send (see BeginArrival) may end it earlier.
  virtual Readiness Wait(bool reads, int other, base::MonotonicTime until) = 0;
  // What has arrived, without waiting: at most `size` bytes. 0: nothing now;
  // -1: the client has gone, or is too slow.
  virtual ssize_t ReadSome(char* to, size_t size) = 0;

  // The client is sending something that must be whole in time, as a request's
  // body must: from the first byte on, and until EndArrival().
  virtual void BeginArrival() = 0;
  virtual void EndArrival() = 0;

  // Whether nothing is under way: then the connection may be closed to make
  // room for others. False: it is to end, for that or since the server stops.
  virtual bool SetIdle(bool idle) = 0;
};

struct HttpResponse {
  int status = 200;
  std::string content_type = {};
  std::string body = {};
  std::vector<std::pair<std::string, std::string>> headers = {};
  // Instead of `body`, of GET and POST requests alone: called in the
  // connection's thread, and the connection closes when it returns.
  std::function<void(HttpBodyWriter&)> stream = {};
  // With status 101 to a GET: called in the connection's thread once that is
  // said, and the connection closes when it returns.
  std::function<void(HttpDuplex&)> upgrade = {};
};

// Thread-safe: every connection has a thread.
class HttpHandler {
 public:
  virtual ~HttpHandler() = default;

  // Before the body is read, which is empty here: an answer that needs none of
  // it, or nullopt to go on.
  virtual std::optional<HttpResponse> CheckHead(const HttpRequest& request) = 0;

  // After CheckHead, before a body is read: a refusal, or nullopt to go on. May
  // note in `request` whom it has let in.
  virtual std::optional<HttpResponse> Admit(HttpRequest& /*request*/) {
    return std::nullopt;
  }

  // Whether `request` asks how the server is, which it may also where there are
  // no more connections for others. Of all of ours: /healthz and /readyz.
  virtual bool IsProbe(const HttpRequest& request) const {
    return request.path == "/healthz" || request.path == "/readyz";
  }

  virtual HttpResponse Handle(const HttpRequest& request) = 0;

  // A response that the server gives itself: 400, 408, 411, 413,
  // 414, 415, 417, 431, 500, 503.
  virtual HttpResponse Error(int status) = 0;

  // Headers that go with every response to `request`, also with errors.
  virtual std::vector<std::pair<std::string, std::string>> CommonHeaders(
      const HttpRequest& request) = 0;
};

}  // namespace treeline::http

#endif  // COMMON_HTTP_HTTP_MESSAGE_H_
