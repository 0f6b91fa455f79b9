#include "common/http/http_engine.h"

#include <chrono>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"

namespace treeline::http {
namespace {

constexpr std::chrono::milliseconds kLinger{1000};
// What httplib tells clients; the server closes idle connections by its own
// limits.
constexpr time_t kKeepAliveSeconds = 60;
constexpr size_t kKeepAliveCount = 1'000'000;

bool HasBody(const httplib::Request& request) {
  return request.has_header("Transfer-Encoding") ||
         (request.has_header("Content-Length") &&
          request.get_header_value("Content-Length") != "0");
}

std::string PeerName(const std::string& ip, int port) {
  return absl::StrContains(ip, ':') ? absl::StrCat("ipv6:[", ip, "]:", port)
                                    : absl::StrCat("ipv4:", ip, ":", port);
}

// 0: the lengths are fine, as far as the head says; else the status.
int CheckLengths(const httplib::Request& request, size_t max_body_bytes) {
  const bool chunked = request.has_header("Transfer-Encoding");
  const size_t lengths = request.get_header_value_count("Content-Length");
  // Two ways to say where a request ends let it end in two places.
  if (lengths > 1 || (chunked && lengths > 0)) return 400;
  if (chunked) {
    return absl::EqualsIgnoreCase(request.get_header_value("Transfer-Encoding"),
                                  "chunked")
               ? 0
               : 400;
  }
  if (lengths == 0) return request.method == "POST" ? 411 : 0;
  uint64_t length = 0;
  if (!absl::SimpleAtoi(request.get_header_value("Content-Length"), &length)) {
    return 400;
  }
  return length > max_body_bytes ? 413 : 0;
}

// Chunks of RFC 9112, 7.1.
class ChunkWriter final : public HttpBodyWriter {
 public:
  explicit ChunkWriter(HttpStream& stream) : stream_(stream) {}

  bool Write(absl::string_view bytes) override {
    if (bytes.empty()) return is_open_;
    if (!is_open_) return false;
    stream_.BeginPart();
    chunk_ = absl::StrCat(absl::Hex(bytes.size()), "\r\n", bytes, "\r\n");
    is_open_ = stream_.write(chunk_.data(), chunk_.size()) > 0;
    return is_open_;
  }
  void Finish() {
    constexpr absl::string_view kLast = "0\r\n\r\n";
    if (is_open_) stream_.write(kLast.data(), kLast.size());
  }

 private:
  HttpStream& stream_;
  std::string chunk_;
  bool is_open_ = true;
};

bool IsEncodingKnown(const httplib::Request& request) {
  if (!request.has_header("Content-Encoding")) return true;
  const std::string encoding = request.get_header_value("Content-Encoding");
  return absl::EqualsIgnoreCase(encoding, "gzip") ||
         absl::EqualsIgnoreCase(encoding, "identity");
}

}  // namespace

HttpEngine::HttpEngine(HttpHandler& handler, HttpStream& stream,
                       Connection connection, const base::Clock& clock)
    : handler_(handler),
      stream_(stream),
      connection_(std::move(connection)),
      clock_(clock) {
  set_keep_alive_timeout(kKeepAliveSeconds);
  set_keep_alive_max_count(kKeepAliveCount);
  set_payload_max_length(connection_.max_body_bytes);
  set_pre_routing_handler(
      [this](const httplib::Request& request, httplib::Response& response) {
        return BeforeBody(request, response);
      });
  set_expect_100_continue_handler(
      [this](const httplib::Request& request, httplib::Response& response) {
        const std::optional<HttpResponse> early = CheckHead(request);
        if (!early.has_value()) return 100;
        Apply(Convert(request), *early, response);
        return response.status;
      });
  set_exception_handler([this](const httplib::Request& request,
                               httplib::Response& response,
                               const std::exception_ptr&) {
    close_ = true;
    Apply(Convert(request), handler_.Error(500), response);
  });
  // Only paths that CheckHead has let through come here.
  Post(".*",
       [this](const httplib::Request& request, httplib::Response& response,
              const httplib::ContentReader& read) {
         WithBody(request, response, read);
       });
  set_error_handler(Handler(
      [this](const httplib::Request& request, httplib::Response& response) {
        OnError(request, response);
      }));
}

bool HttpEngine::ServeOne(bool last) {
  answered_ = false;
  close_ = false;
  stream_.BeginHead();
  bool connection_closed = false;
  const bool written = process_request(
      stream_, last, connection_closed, [this](httplib::Request& request) {
        stream_.BeginBody();
        request.ranges.clear();
        // Answers are small: not worth the time of compressing them.
        request.headers.erase("Accept-Encoding");
      });
  if (stream_.failure() == StreamFailure::kClosed) return false;
  if (stream_.failure() != StreamFailure::kNone && !stream_.has_written()) {
    // Nothing that httplib could have understood.
    stream_.write(
        absl::StrCat(stream_.failure() == StreamFailure::kTimedOut
                         ? "HTTP/1.1 408 Request Timeout\r\n"
                         : "HTTP/1.1 431 Request Header Fields Too Large\r\n",
                     "Connection: close\r\nContent-Length: 0\r\n\r\n"));
    close_ = true;
  }
  if (close_) stream_.Linger(kLinger);
  return written && !close_ && !connection_closed && !last &&
         stream_.failure() == StreamFailure::kNone;
}

std::optional<HttpResponse> HttpEngine::CheckHead(
    const httplib::Request& request) {
  const int status = CheckLengths(request, connection_.max_body_bytes);
  std::optional<HttpResponse> early;
  if (status == 400) {
    early = handler_.Error(status);
  } else {
    early = handler_.CheckHead(Convert(request));
  }
  if (!early.has_value() && status != 0) early = handler_.Error(status);
  if (!early.has_value() && !IsEncodingKnown(request)) {
    early = handler_.Error(415);
  }
  // Where an unread body ends, the next request would begin.
  if (early.has_value() && (status != 0 || HasBody(request))) close_ = true;
  return early;
}

httplib::Server::HandlerResponse HttpEngine::BeforeBody(
    const httplib::Request& request, httplib::Response& response) {
  const std::optional<HttpResponse> early = CheckHead(request);
  if (early.has_value()) {
    Apply(Convert(request), *early, response);
    return HandlerResponse::Handled;
  }
  if (request.method == "POST") return HandlerResponse::Unhandled;
  close_ = close_ || HasBody(request);
  HttpRequest converted = Convert(request);
  converted.arrival = clock_.Now();
  const HttpResponse answer = handler_.Handle(converted);
  if (answer.stream && request.method == "GET") {
    Stream(converted, answer);
  } else {
    Apply(converted, answer, response);
  }
  return HandlerResponse::Handled;
}

void HttpEngine::Stream(const HttpRequest& request,
                        const HttpResponse& response) {
  answered_ = true;
  std::string head =
      absl::StrCat("HTTP/1.1 ", response.status,
                   " OK\r\nContent-Type: ", response.content_type,
                   "\r\nTransfer-Encoding: chunked\r\nConnection: close\r\n");
  for (const auto& headers :
       {response.headers, handler_.CommonHeaders(request)}) {
    for (const auto& [name, value] : headers) {
      absl::StrAppend(&head, name, ": ", value, "\r\n");
    }
  }
  head += "\r\n";
  ChunkWriter writer(stream_);
  stream_.BeginPart();
  if (stream_.httplib::Stream::write(head) > 0) {
    response.stream(writer);
    writer.Finish();
  }
  // httplib must not answer too.
  stream_.Abandon();
}

void HttpEngine::WithBody(const httplib::Request& request,
                          httplib::Response& response,
                          const httplib::ContentReader& read) {
  stream_.BeginBody();
  HttpRequest converted = Convert(request);
  bool too_large = false;
  const bool complete = read([&](const char* data, size_t size) {
    // What comes here is decompressed already.
    if (size > connection_.max_body_bytes - converted.body.size()) {
      too_large = true;
      return false;
    }
    converted.body.append(data, size);
    return true;
  });
  if (complete && !too_large) {
    converted.arrival = clock_.Now();
    Apply(converted, handler_.Handle(converted), response);
    return;
  }
  close_ = true;
  int status = response.status >= 400 ? response.status : 400;
  if (too_large) status = 413;
  if (stream_.failure() == StreamFailure::kTimedOut) status = 408;
  Apply(converted, handler_.Error(status), response);
}

void HttpEngine::OnError(const httplib::Request& request,
                         httplib::Response& response) {
  if (answered_) return;
  close_ = true;
  if (stream_.failure() == StreamFailure::kTimedOut) response.status = 408;
  if (stream_.failure() == StreamFailure::kHeadTooLarge) response.status = 431;
  Apply(Convert(request), handler_.Error(response.status), response);
}

HttpRequest HttpEngine::Convert(const httplib::Request& request) const {
  HttpRequest converted{
      .method = request.method,
      .path = request.path,
      .peer = PeerName(request.remote_addr, request.remote_port),
      .certificate_names = connection_.certificate_names,
      .socket = connection_.socket};
  for (const auto& [name, value] : request.headers) {
    converted.headers.emplace(absl::AsciiStrToLower(name), value);
  }
  return converted;
}

void HttpEngine::Apply(const HttpRequest& request, const HttpResponse& from,
                       httplib::Response& to) {
  answered_ = true;
  to.status = from.status;
  if (!from.content_type.empty()) to.set_content(from.body, from.content_type);
  for (const auto& [name, value] : from.headers) to.set_header(name, value);
  for (const auto& [name, value] : handler_.CommonHeaders(request)) {
    to.set_header(name, value);
  }
  if (close_) to.set_header("Connection", "close");
}

}  // namespace treeline::http
