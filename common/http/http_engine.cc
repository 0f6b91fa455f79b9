#include "common/http/http_engine.h"

#include <chrono>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/http/body_reader.h"
#include "common/http/stream_duplex.h"

namespace treeline::http {
namespace {

constexpr std::chrono::milliseconds kLinger{1000};
// What httplib tells clients; the server closes idle connections by its own
// limits.
constexpr time_t kKeepAliveSeconds = 60;
constexpr size_t kKeepAliveCount = 1'000'000;
// Bodies of answers that are larger are counted.
constexpr size_t kLargeAnswer = 16384;

std::string PeerName(const std::string& ip, int port) {
  return absl::StrContains(ip, ':') ? absl::StrCat("ipv6:[", ip, "]:", port)
                                    : absl::StrCat("ipv4:", ip, ":", port);
}

// What httplib would give as the reason of the few statuses that are written
// here.
absl::string_view ReasonOf(int status) {
  switch (status) {
    case 400:
      return "Bad Request";
    case 408:
      return "Request Timeout";
    case 431:
      return "Request Header Fields Too Large";
    default:
      return "OK";
  }
}

// 0: the length is fine, as far as the head says; else the status.
int CheckLength(const RequestHead& head, size_t max_body_bytes) {
  if (head.is_chunked) return 0;
  if (!head.content_length.has_value()) return head.method == "POST" ? 411 : 0;
  return *head.content_length > max_body_bytes ? 413 : 0;
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

bool IsEncodingKnown(const HttpRequest& request) {
  const absl::string_view encoding = request.Header("content-encoding");
  return encoding.empty() || absl::EqualsIgnoreCase(encoding, "gzip") ||
         absl::EqualsIgnoreCase(encoding, "identity");
}

}  // namespace

HttpEngine::HttpEngine(HttpHandler& handler, HttpStream& stream,
                       Connection connection, const base::Clock& clock)
    : handler_(handler),
      stream_(stream),
      connection_(std::move(connection)),
      clock_(clock),
      answer_lease_(connection_.answers) {
  set_keep_alive_timeout(kKeepAliveSeconds);
  set_keep_alive_max_count(kKeepAliveCount);
  set_payload_max_length(connection_.max_body_bytes);
  set_pre_routing_handler(
      [this](const httplib::Request& request, httplib::Response& response) {
        return BeforeBody(request, response);
      });
  set_expect_100_continue_handler(
      [this](const httplib::Request& request, httplib::Response& response) {
        const std::optional<HttpResponse>& early = CheckHead(request);
        if (!early.has_value()) return 100;
        Apply(request_, *early, response);
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
       [this](const httplib::Request& /*request*/, httplib::Response& response,
              const httplib::ContentReader& /*read*/) { WithBody(response); });
  set_error_handler(Handler(
      [this](const httplib::Request& request, httplib::Response& response) {
        OnError(request, response);
      }));
}

bool HttpEngine::ServeOne(bool last) {
  answered_ = false;
  close_ = false;
  is_head_checked_ = false;
  std::string().swap(request_.body);
  request_ = {};
  stream_.BeginHead();
  const absl::string_view raw = stream_.ReadHead();
  std::optional<RequestHead> head;
  if (!raw.empty()) head = ParseRequestHead(raw);
  if (!head.has_value()) {
    if (stream_.failure() != StreamFailure::kClosed) RefuseHead();
    return false;
  }
  head_ = *std::move(head);
  bool connection_closed = false;
  const bool written = process_request(
      stream_, last, connection_closed, [](httplib::Request& request) {
        request.ranges.clear();
        // Answers are small: not worth the time of compressing them.
        request.headers.erase("Accept-Encoding");
      });
  answer_lease_.Release();
  if (stream_.failure() == StreamFailure::kClosed) return false;
  if (close_) stream_.Linger(kLinger);
  return written && !close_ && !connection_closed && !last &&
         stream_.failure() == StreamFailure::kNone;
}

void HttpEngine::RefuseHead() {
  int status = 400;
  if (stream_.failure() == StreamFailure::kTimedOut) status = 408;
  if (stream_.failure() == StreamFailure::kHeadTooLarge) status = 431;
  const HttpResponse error = handler_.Error(status);
  std::string answer = absl::StrCat(
      "HTTP/1.1 ", status, " ", ReasonOf(status),
      "\r\nConnection: close\r\nContent-Type: ", error.content_type,
      "\r\nContent-Length: ", error.body.size(), "\r\n");
  for (const auto& [name, value] : handler_.CommonHeaders({})) {
    absl::StrAppend(&answer, name, ": ", value, "\r\n");
  }
  absl::StrAppend(&answer, "\r\n", error.body);
  if (stream_.write(answer.data(), answer.size()) > 0) stream_.Linger(kLinger);
}

const std::optional<HttpResponse>& HttpEngine::CheckHead(
    const httplib::Request& request) {
  // Clients that wait for "100 Continue" bring httplib here twice.
  if (is_head_checked_) return early_;
  is_head_checked_ = true;
  request_ = Convert(request);
  early_ = Refusal();
  // Where an unread body ends, the next request would begin.
  if (early_.has_value() &&
      (head_.has_body() ||
       CheckLength(head_, connection_.max_body_bytes) != 0)) {
    close_ = true;
  }
  return early_;
}

std::optional<HttpResponse> HttpEngine::Refusal() {
  if (connection_.only_probes && !handler_.IsProbe(request_)) {
    close_ = true;
    HttpResponse busy = handler_.Error(503);
    busy.headers.emplace_back("Retry-After", "1");
    return busy;
  }
  if (auto early = handler_.CheckHead(request_)) return early;
  const int status = CheckLength(head_, connection_.max_body_bytes);
  if (status != 0) return handler_.Error(status);
  if (!IsEncodingKnown(request_)) return handler_.Error(415);
  if (request_.method != "POST") return std::nullopt;
  return handler_.Admit(request_);
}

httplib::Server::HandlerResponse HttpEngine::BeforeBody(
    const httplib::Request& request, httplib::Response& response) {
  const std::optional<HttpResponse>& early = CheckHead(request);
  if (early.has_value()) {
    Apply(request_, *early, response);
    return HandlerResponse::Handled;
  }
  if (request.method == "POST") return HandlerResponse::Unhandled;
  close_ = close_ || head_.has_body();
  stream_.BeginHandling();
  request_.arrival = clock_.Now();
  Send(handler_.Handle(request_), response);
  return HandlerResponse::Handled;
}

void HttpEngine::Send(const HttpResponse& answer, httplib::Response& response) {
  if (answer.upgrade && request_.method == "GET") {
    Upgrade(request_, answer);
  } else if (answer.stream &&
             (request_.method == "GET" || request_.method == "POST")) {
    Stream(request_, answer);
  } else if (answer.body.size() > kLargeAnswer &&
             !answer_lease_.Resize(answer.body.size())) {
    HttpResponse busy = handler_.Error(503);
    busy.headers.emplace_back("Retry-After", "1");
    Apply(request_, busy, response);
  } else {
    Apply(request_, answer, response);
  }
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

void HttpEngine::Upgrade(const HttpRequest& request,
                         const HttpResponse& response) {
  answered_ = true;
  std::string head = absl::StrCat("HTTP/1.1 ", response.status,
                                  " Switching Protocols\r\n"
                                  "Connection: Upgrade\r\n");
  for (const auto& headers :
       {response.headers, handler_.CommonHeaders(request)}) {
    for (const auto& [name, value] : headers) {
      absl::StrAppend(&head, name, ": ", value, "\r\n");
    }
  }
  head += "\r\n";
  stream_.BeginPart();
  if (stream_.httplib::Stream::write(head) > 0) {
    StreamDuplex duplex(stream_, connection_.socket, connection_.mark_idle,
                        clock_);
    response.upgrade(duplex);
    // What the client has on its way must not take the last words back.
    stream_.Linger(kLinger);
  }
  // httplib must not answer too.
  stream_.Abandon();
}

void HttpEngine::WithBody(httplib::Response& response) {
  // The body's memory is given back before an answer that goes on.
  Send(AnswerToBody(), response);
}

HttpResponse HttpEngine::AnswerToBody() {
  stream_.BeginBody();
  base::ByteLease lease(connection_.budget);
  BodyReader reader(stream_, {.max_bytes = connection_.max_body_bytes}, lease);
  int status = reader.Read(head_, request_.body);
  HttpResponse answer;
  if (status == 0) {
    stream_.BeginHandling();
    request_.arrival = clock_.Now();
    answer = handler_.Handle(request_);
  } else {
    close_ = true;
    if (stream_.failure() == StreamFailure::kTimedOut) status = 408;
    answer = handler_.Error(status);
    if (status == 503) answer.headers.emplace_back("Retry-After", "1");
  }
  // Before the lease ends. Assigning would keep the memory.
  std::string().swap(request_.body);
  return answer;
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
  return {.method = request.method,
          .path = request.path,
          .query = {request.params.begin(), request.params.end()},
          .headers = head_.headers,
          .peer = PeerName(request.remote_addr, request.remote_port),
          .certificate_names = connection_.certificate_names,
          .socket = connection_.socket};
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
