// A TCP connection for tests.
#ifndef COMMON_HTTP_TESTING_RAW_CLIENT_H_
#define COMMON_HTTP_TESTING_RAW_CLIENT_H_

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <string>

#include "absl/strings/string_view.h"
#include "common/base/listen_address.h"

namespace treeline::http {

// A connection on which a test may say what it likes.
class RawClient {
 public:
  // `from`: its own address, of loopback; empty: 127.0.0.1.
  explicit RawClient(const std::string& address, const std::string& from = "")
      : fd_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    if (!from.empty()) {
      sockaddr_in own{};
      own.sin_family = AF_INET;
      EXPECT_EQ(inet_pton(AF_INET, from.c_str(), &own.sin_addr), 1);
      EXPECT_EQ(bind(fd_, reinterpret_cast<sockaddr*>(&own), sizeof(own)), 0);
    }
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(
        static_cast<uint16_t>(base::ParseListenAddress(address).value().port));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(connect(fd_, reinterpret_cast<sockaddr*>(&to), sizeof(to)), 0);
  }
  virtual ~RawClient() { close(fd_); }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  virtual bool Send(absl::string_view bytes) const {
    return send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL) ==
           static_cast<ssize_t>(bytes.size());
  }
  // Everything until the server closes.
  std::string ReadAll() const {
    std::string all;
    std::array<char, 4096> buffer;
    for (;;) {
      const ssize_t got = Receive(buffer.data(), buffer.size());
      if (got <= 0) return all;
      all.append(buffer.data(), static_cast<size_t>(got));
    }
  }
  // At least one byte.
  std::string ReadSome() const {
    std::array<char, 4096> buffer;
    const ssize_t got = Receive(buffer.data(), buffer.size());
    return got <= 0 ? "" : std::string(buffer.data(), static_cast<size_t>(got));
  }

 protected:
  int fd() const { return fd_; }

 private:
  virtual ssize_t Receive(char* to, size_t size) const {
    return recv(fd_, to, size, 0);
  }

  const int fd_;
};

}  // namespace treeline::http

#endif  // COMMON_HTTP_TESTING_RAW_CLIENT_H_
