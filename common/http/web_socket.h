// WebSocket, RFC 6455, as a server speaks it: the handshake and the frames.
// Without extensions: pictures are compressed already.
#ifndef COMMON_HTTP_WEB_SOCKET_H_
#define COMMON_HTTP_WEB_SOCKET_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/strings/string_view.h"
#include "common/http/http_message.h"

namespace treeline::http {

// Why a connection ends (RFC 6455, 7.4.1).
enum class WebSocketClose : uint16_t {
  kNormal = 1000,
  kGoingAway = 1001,
  kProtocolError = 1002,
  kBadMessage = 1007,
  kRefused = 1008,
  kTooLarge = 1009,
  kTryAgainLater = 1013,
};

// Whether the request asks for a WebSocket at all, in whatever version.
bool AsksForWebSocket(const HttpRequest& request);

// Names in Sec-WebSocket-Protocol, in the order of preference.
std::vector<std::string> WebSocketProtocols(const HttpRequest& request);

// The answer that opens the connection (101), without HttpResponse::upgrade; or
// nullopt: the request is no valid handshake (its key is none, or another
// version than 13). `protocol`: one of WebSocketProtocols(), or empty: none.
std::optional<HttpResponse> AcceptWebSocket(const HttpRequest& request,
                                            absl::string_view protocol);

// One message or control frame in one frame, as a server sends it: not masked.
std::string WebSocketMessage(bool is_text, absl::string_view bytes);
std::string WebSocketPong(absl::string_view bytes);
// `reason` is cut to what fits in.
std::string WebSocketCloseFrame(WebSocketClose code, absl::string_view reason);

// Takes frames of a client apart as they arrive. Safe on any bytes: no length
// is believed before its bytes are there. For one thread.
class WebSocketReader {
 public:
  enum class Event {
    // All bytes are used up; more are needed.
    kNone,
    // message() is whole.
    kMessage,
    // ping() wants to be answered.
    kPing,
    // The client says goodbye.
    kClose,
    // See failure(). Nothing more is read.
    kFailed
  };

  // Asked before a message comes to hold `bytes`: whether it may.
  using HasRoom = std::function<bool(size_t bytes)>;

  WebSocketReader(size_t max_message_bytes, HasRoom has_room)
      : max_message_bytes_(max_message_bytes), has_room_(std::move(has_room)) {}

  // Takes from the front of `bytes` what the next event needs, and shortens it.
  Event Read(absl::string_view& bytes);

  // Whether a message or a frame has begun and is not whole.
  bool is_amid() const {
    return is_amid_message_ || !head_.empty() || in_frame_;
  }

  bool is_text() const { return is_text_; }
  // Takes it out.
  std::string TakeMessage();
  const std::string& ping() const { return control_; }
  // Of kFailed: protocol error, too large, or no room.
  WebSocketClose failure() const { return *failure_; }

 private:
  // Reads the head of a frame; false: more bytes are needed, or it failed.
  bool ReadHead(absl::string_view& bytes);
  bool CheckHead(uint8_t first, uint64_t length);
  // Reads on in the frame's bytes. False: it failed.
  bool TakePayload(absl::string_view& bytes);
  Event EndOfFrame();
  Event Fail(WebSocketClose failure);

  const size_t max_message_bytes_;
  const HasRoom has_room_;
  // Of the head that is arriving.
  std::string head_;
  // Of the frame at hand.
  bool in_frame_ = false;
  bool is_last_ = false;
  uint8_t opcode_ = 0;
  uint64_t left_ = 0;
  size_t mask_at_ = 0;
  std::string mask_;
  // Of the message at hand.
  bool is_amid_message_ = false;
  bool is_text_ = false;
  std::string message_;
  std::string control_;
  std::optional<WebSocketClose> failure_;
};

}  // namespace treeline::http

#endif  // COMMON_HTTP_WEB_SOCKET_H_
