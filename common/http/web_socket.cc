#include "common/http/web_socket.h"

#include <openssl/sha.h>

#include <algorithm>
#include <array>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace treeline::http {
namespace {

// RFC 6455, 1.3.
constexpr absl::string_view kGuid = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
constexpr size_t kKeyBytes = 16;

constexpr uint8_t kLastFrame = 0x80;
constexpr uint8_t kReservedBits = 0x70;
constexpr uint8_t kOpcodeBits = 0x0f;
constexpr uint8_t kMasked = 0x80;
constexpr uint8_t kLengthBits = 0x7f;
constexpr uint8_t kLength16 = 126;
constexpr uint8_t kLength64 = 127;
constexpr size_t kMaskBytes = 4;
constexpr size_t kMaxControlBytes = 125;
// What a message grows by while it arrives.
constexpr size_t kStep = 65536;

enum Opcode : uint8_t {
  kContinuation = 0,
  kText = 1,
  kBinary = 2,
  kCloseFrame = 8,
  kPingFrame = 9,
  kPongFrame = 10
};

bool IsControl(uint8_t opcode) { return (opcode & 8) != 0; }

bool IsKnown(uint8_t opcode) {
  return opcode <= kBinary || (opcode >= kCloseFrame && opcode <= kPongFrame);
}

// Whether a header that lists tokens has this one.
bool HasToken(absl::string_view list, absl::string_view token) {
  const std::vector<absl::string_view> tokens = absl::StrSplit(list, ',');
  return std::any_of(tokens.begin(), tokens.end(), [&](absl::string_view each) {
    return absl::EqualsIgnoreCase(absl::StripAsciiWhitespace(each), token);
  });
}

std::string AcceptOf(absl::string_view key) {
  const std::string text = absl::StrCat(key, kGuid);
  std::array<unsigned char, SHA_DIGEST_LENGTH> digest{};
  SHA1(reinterpret_cast<const unsigned char*>(text.data()), text.size(),
       digest.data());
  return absl::Base64Escape(absl::string_view(
      reinterpret_cast<const char*>(digest.data()), digest.size()));
}

std::string FrameOf(uint8_t opcode, absl::string_view bytes) {
  std::string frame(1, static_cast<char>(kLastFrame | opcode));
  const uint64_t size = bytes.size();
  int length_bytes = 0;
  if (size < kLength16) {
    frame.push_back(static_cast<char>(size));
  } else if (size <= UINT16_MAX) {
    frame.push_back(static_cast<char>(kLength16));
    length_bytes = 2;
  } else {
    frame.push_back(static_cast<char>(kLength64));
    length_bytes = 8;
  }
  for (int i = length_bytes - 1; i >= 0; --i) {
    frame.push_back(static_cast<char>(size >> (8 * i)));
  }
  frame.append(bytes.data(), bytes.size());
  return frame;
}

}  // namespace

bool AsksForWebSocket(const HttpRequest& request) {
  return HasToken(request.Header("upgrade"), "websocket") &&
         HasToken(request.Header("connection"), "upgrade");
}

std::vector<std::string> WebSocketProtocols(const HttpRequest& request) {
  std::vector<std::string> protocols;
  for (absl::string_view each :
       absl::StrSplit(request.Header("sec-websocket-protocol"), ',')) {
    each = absl::StripAsciiWhitespace(each);
    if (!each.empty()) protocols.emplace_back(each);
  }
  return protocols;
}

std::optional<HttpResponse> AcceptWebSocket(const HttpRequest& request,
                                            absl::string_view protocol) {
  const absl::string_view key =
      absl::StripAsciiWhitespace(request.Header("sec-websocket-key"));
  std::string nonce;
  if (request.method != "GET" || !AsksForWebSocket(request) ||
      request.Header("sec-websocket-version") != "13" ||
      !absl::Base64Unescape(key, &nonce) || nonce.size() != kKeyBytes) {
    return std::nullopt;
  }
  HttpResponse response{.status = 101,
                        .headers = {{"Upgrade", "websocket"},
                                    {"Sec-WebSocket-Accept", AcceptOf(key)}}};
  if (!protocol.empty()) {
    response.headers.emplace_back("Sec-WebSocket-Protocol",
                                  std::string(protocol));
  }
  return response;
}

std::string WebSocketMessage(bool is_text, absl::string_view bytes) {
  return FrameOf(is_text ? kText : kBinary, bytes);
}

std::string WebSocketPong(absl::string_view bytes) {
  return FrameOf(kPongFrame, bytes.substr(0, kMaxControlBytes));
}

std::string WebSocketCloseFrame(WebSocketClose code, absl::string_view reason) {
  const auto number = static_cast<uint16_t>(code);
  std::string bytes = {static_cast<char>(number >> 8),
                       static_cast<char>(number & 0xff)};
  reason = reason.substr(0, kMaxControlBytes - bytes.size());
  bytes.append(reason.data(), reason.size());
  return FrameOf(kCloseFrame, bytes);
}

std::string WebSocketReader::TakeMessage() {
  return std::exchange(message_, std::string());
}

WebSocketReader::Event WebSocketReader::Fail(WebSocketClose failure) {
  failure_ = failure;
  // Its memory is wanted elsewhere.
  std::string().swap(message_);
  return Event::kFailed;
}

WebSocketReader::Event WebSocketReader::Read(absl::string_view& bytes) {
  for (;;) {
    if (failure_.has_value()) return Event::kFailed;
    if (!in_frame_) {
      if (!ReadHead(bytes)) {
        return failure_.has_value() ? Event::kFailed : Event::kNone;
      }
    }
    if (left_ > 0) {
      if (bytes.empty()) return Event::kNone;
      if (!TakePayload(bytes)) return Event::kFailed;
      if (left_ > 0) continue;
    }
    const Event event = EndOfFrame();
    // Fragments and pongs are no news.
    if (event != Event::kNone) return event;
  }
}

bool WebSocketReader::TakePayload(absl::string_view& bytes) {
  std::string& to = IsControl(opcode_) ? control_ : message_;
  const size_t size =
      static_cast<size_t>(std::min<uint64_t>({left_, bytes.size(), kStep}));
  const size_t begin = to.size();
  if (!IsControl(opcode_) && begin + size > to.capacity()) {
    // A string that is to hold more at least doubles.
    const size_t capacity = std::min(
        max_message_bytes_, std::max({kStep, 2 * to.capacity(), begin + size}));
    if (!has_room_(capacity)) {
      Fail(WebSocketClose::kTryAgainLater);
      return false;
    }
    to.reserve(capacity);
  }
  to.append(bytes.data(), size);
  for (size_t i = begin; i < to.size(); ++i) {
    to[i] = static_cast<char>(to[i] ^ mask_[mask_at_]);
    mask_at_ = (mask_at_ + 1) % kMaskBytes;
  }
  bytes.remove_prefix(size);
  left_ -= size;
  return true;
}

bool WebSocketReader::ReadHead(absl::string_view& bytes) {
  while (!bytes.empty()) {
    head_.push_back(bytes.front());
    bytes.remove_prefix(1);
    if (head_.size() < 2) continue;
    const auto second = static_cast<uint8_t>(head_[1]);
    const uint8_t code = second & kLengthBits;
    size_t length_bytes = 0;
    if (code == kLength16) length_bytes = 2;
    if (code == kLength64) length_bytes = 8;
    if (head_.size() < 2 + length_bytes + kMaskBytes) {
      // The first two say whether it is worth waiting for the rest.
      if ((second & kMasked) == 0) {
        Fail(WebSocketClose::kProtocolError);
        return false;
      }
      continue;
    }
    uint64_t length = code;
    if (length_bytes > 0) {
      length = 0;
      for (size_t i = 0; i < length_bytes; ++i) {
        length = length << 8 | static_cast<uint8_t>(head_[2 + i]);
      }
      // Written as short as it can be; the highest bit is not used.
      const uint64_t least = length_bytes == 2 ? kLength16 : UINT16_MAX + 1;
      if (length < least || length >> 63 != 0) {
        Fail(WebSocketClose::kProtocolError);
        return false;
      }
    }
    mask_ = head_.substr(2 + length_bytes);
    return CheckHead(static_cast<uint8_t>(head_[0]), length);
  }
  return false;
}

bool WebSocketReader::CheckHead(uint8_t first, uint64_t length) {
  head_.clear();
  opcode_ = first & kOpcodeBits;
  is_last_ = (first & kLastFrame) != 0;
  left_ = length;
  mask_at_ = 0;
  const bool is_control = IsControl(opcode_);
  // A message goes on with continuations, and nothing else goes on.
  const bool is_in_order =
      is_control || (opcode_ == kContinuation) == is_amid_message_;
  if ((first & kReservedBits) != 0 || !IsKnown(opcode_) || !is_in_order ||
      (is_control && (!is_last_ || length > kMaxControlBytes))) {
    Fail(WebSocketClose::kProtocolError);
    return false;
  }
  if (is_control) {
    control_.clear();
  } else {
    if (length > max_message_bytes_ - message_.size()) {
      Fail(WebSocketClose::kTooLarge);
      return false;
    }
    if (!is_amid_message_) is_text_ = opcode_ == kText;
    is_amid_message_ = true;
  }
  in_frame_ = true;
  return true;
}

WebSocketReader::Event WebSocketReader::EndOfFrame() {
  in_frame_ = false;
  switch (opcode_) {
    case kCloseFrame:
      return Event::kClose;
    case kPingFrame:
      return Event::kPing;
    case kPongFrame:
      return Event::kNone;
    default:
      break;
  }
  if (!is_last_) return Event::kNone;
  is_amid_message_ = false;
  return Event::kMessage;
}

}  // namespace treeline::http
