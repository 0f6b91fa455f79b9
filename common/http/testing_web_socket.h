// Frames as a WebSocket's client sends and reads them, for tests.
#ifndef COMMON_HTTP_TESTING_WEB_SOCKET_H_
#define COMMON_HTTP_TESTING_WEB_SOCKET_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "common/http/testing_raw_client.h"

namespace treeline::http {

inline constexpr uint8_t kTestText = 1;
inline constexpr uint8_t kTestBinary = 2;
inline constexpr uint8_t kTestClose = 8;
inline constexpr uint8_t kTestPing = 9;
inline constexpr uint8_t kTestPong = 10;

// The head of a masked frame that says it has `size` bytes.
inline std::string TestFrameHead(uint8_t opcode, uint64_t size,
                                 bool is_last = true) {
  std::string head(1, static_cast<char>((is_last ? 0x80 : 0) | opcode));
  int length_bytes = 0;
  if (size < 126) {
    head.push_back(static_cast<char>(0x80 | size));
  } else if (size <= UINT16_MAX) {
    head.push_back(static_cast<char>(0x80 | 126));
    length_bytes = 2;
  } else {
    head.push_back(static_cast<char>(0x80 | 127));
    length_bytes = 8;
  }
  for (int i = length_bytes - 1; i >= 0; --i) {
    head.push_back(static_cast<char>(size >> (8 * i)));
  }
  return head + "mask";
}

inline std::string TestFrame(uint8_t opcode, absl::string_view bytes,
                             bool is_last = true) {
  constexpr absl::string_view kMask = "mask";
  std::string frame = TestFrameHead(opcode, bytes.size(), is_last);
  for (size_t i = 0; i < bytes.size(); ++i) {
    frame.push_back(static_cast<char>(bytes[i] ^ kMask[i % kMask.size()]));
  }
  return frame;
}

// A client on a connection of its own.
class TestSocket {
 public:
  struct Frame {
    // 0: the connection has ended.
    uint8_t opcode = 0;
    std::string bytes;
    // Of a close frame.
    int code() const {
      return bytes.size() < 2 ? 0
                              : static_cast<uint8_t>(bytes[0]) << 8 |
                                    static_cast<uint8_t>(bytes[1]);
    }
    std::string reason() const {
      return bytes.size() < 2 ? "" : bytes.substr(2);
    }
  };

  // Sends the handshake; `headers`: whole lines.
  TestSocket(const std::string& address, const std::string& path,
             const std::string& headers = "")
      : TestSocket(std::make_unique<RawClient>(address), address, path,
                   headers) {}
  // The same on a connection that there is.
  TestSocket(std::unique_ptr<RawClient> client, const std::string& address,
             const std::string& path, const std::string& headers)
      : client_(std::move(client)) {
    client_->Send(absl::StrCat("GET ", path, " HTTP/1.1\r\nHost: ", address,
                               "\r\nUpgrade: websocket\r\n"
                               "Connection: keep-alive, Upgrade\r\n"
                               "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
                               "Sec-WebSocket-Version: 13\r\n",
                               headers, "\r\n"));
  }

  // The head of the server's answer; what follows it is kept for ReadFrame().
  std::string ReadHead() {
    size_t end = std::string::npos;
    while ((end = ahead_.find("\r\n\r\n")) == std::string::npos) {
      if (!ReadMore()) return ahead_;
    }
    std::string head = ahead_.substr(0, end + 4);
    ahead_.erase(0, end + 4);
    return head;
  }

  bool Send(absl::string_view bytes) const { return client_->Send(bytes); }
  bool SendMessage(uint8_t opcode, absl::string_view bytes) const {
    return Send(TestFrame(opcode, bytes));
  }

  Frame ReadFrame() {
    Frame frame;
    if (!Await(2)) return frame;
    uint64_t size = static_cast<uint8_t>(ahead_[1]);
    size_t at = 2;
    const size_t length_bytes = size == 126 ? 2 : size == 127 ? 8 : 0;
    if (!Await(at + length_bytes)) return frame;
    if (length_bytes > 0) size = 0;
    for (size_t i = 0; i < length_bytes; ++i) {
      size = size << 8 | static_cast<uint8_t>(ahead_[at++]);
    }
    if (!Await(at + size)) return frame;
    frame.opcode = static_cast<uint8_t>(ahead_[0]) & 0x0f;
    frame.bytes = ahead_.substr(at, size);
    ahead_.erase(0, at + size);
    return frame;
  }

 private:
  bool ReadMore() {
    const std::string more = client_->ReadSome();
    ahead_ += more;
    return !more.empty();
  }
  bool Await(size_t size) {
    while (ahead_.size() < size) {
      if (!ReadMore()) return false;
    }
    return true;
  }

  const std::unique_ptr<RawClient> client_;
  std::string ahead_;
};

}  // namespace treeline::http

#endif  // COMMON_HTTP_TESTING_WEB_SOCKET_H_
