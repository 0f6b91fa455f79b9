// A connection after its upgrade: what HttpDuplex promises, over HttpStream.
#ifndef COMMON_HTTP_STREAM_DUPLEX_H_
#define COMMON_HTTP_STREAM_DUPLEX_H_

#include <functional>

#include "absl/strings/string_view.h"
#include "common/base/clock.h"
#include "common/http/http_message.h"
#include "common/http/http_stream.h"

namespace treeline::http {

class StreamDuplex final : public HttpDuplex {
 public:
  // Marks the connection as idle or not. False: it is to be closed.
  using MarkIdle = std::function<bool(bool idle)>;

  // Keeps references to `stream`, whose socket is `socket`, and `clock`.
  // `mark_idle` may be null: it goes on for ever.
  StreamDuplex(HttpStream& stream, int socket, MarkIdle mark_idle,
               const base::Clock& clock)
      : stream_(stream),
        socket_(socket),
        mark_idle_(std::move(mark_idle)),
        clock_(clock) {}

  bool Write(absl::string_view bytes) override {
    return stream_.WriteBetween(bytes);
  }
  Readiness Wait(bool reads, int other, base::MonotonicTime until) override;
  ssize_t ReadSome(char* to, size_t size) override {
    return stream_.ReadAvailable(to, size);
  }
  void BeginArrival() override {
    is_arriving_ = true;
    stream_.BeginBody();
  }
  void EndArrival() override {
    is_arriving_ = false;
    stream_.BeginHandling();
  }
  bool SetIdle(bool idle) override {
    return mark_idle_ == nullptr || mark_idle_(idle);
  }

 private:
  HttpStream& stream_;
  const int socket_;
  const MarkIdle mark_idle_;
  const base::Clock& clock_;
  bool is_arriving_ = false;
};

}  // namespace treeline::http

#endif  // COMMON_HTTP_STREAM_DUPLEX_H_
