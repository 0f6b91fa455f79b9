#include "common/http/http_stream.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <openssl/err.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstring>
#include <utility>

namespace treeline::http {
namespace {

using NameOfEnd = int (*)(int, sockaddr*, socklen_t*);

void IpAndPort(int fd, NameOfEnd name_of_end, std::string& ip, int& port) {
  sockaddr_storage address{};
  socklen_t length = sizeof(address);
  if (name_of_end(fd, reinterpret_cast<sockaddr*>(&address), &length) != 0) {
    return;
  }
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (address.ss_family == AF_INET) {
    const auto* v4 = reinterpret_cast<const sockaddr_in*>(&address);
    inet_ntop(AF_INET, &v4->sin_addr, text.data(), text.size());
    port = ntohs(v4->sin_port);
  } else if (address.ss_family == AF_INET6) {
    const auto* v6 = reinterpret_cast<const sockaddr_in6*>(&address);
    inet_ntop(AF_INET6, &v6->sin6_addr, text.data(), text.size());
    port = ntohs(v6->sin6_port);
  }
  ip = text.data();
}

}  // namespace

HttpStream::HttpStream(int fd, UniqueSsl ssl, const StreamLimits& limits,
                       const base::Clock& clock)
    : fd_(fd), ssl_(std::move(ssl)), limits_(limits), clock_(clock) {
  fcntl(fd_, F_SETFL, fcntl(fd_, F_GETFL) | O_NONBLOCK);
  if (ssl_ != nullptr) {
    SSL_set_mode(ssl_.get(), SSL_MODE_ENABLE_PARTIAL_WRITE |
                                 SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
    SSL_set_fd(ssl_.get(), fd_);
  }
}

bool HttpStream::Handshake() {
  if (ssl_ == nullptr) return true;
  deadline_ = clock_.Now() + limits_.head_timeout;
  for (;;) {
    // SSL_get_error() looks at what is left of earlier failures too.
    ERR_clear_error();
    const int result = SSL_accept(ssl_.get());
    if (result == 1) return true;
    if (!WaitForTls(result)) return false;
  }
}

bool HttpStream::WaitForRequest(std::chrono::milliseconds patience) {
  if (begin_ < end_) return true;
  deadline_ = clock_.Now() + patience;
  const ssize_t received = Receive(buffer_.data(), buffer_.size());
  if (received <= 0) return false;
  begin_ = 0;
  end_ = static_cast<size_t>(received);
  return true;
}

void HttpStream::BeginHead() {
  phase_ = Phase::kHead;
  failure_ = StreamFailure::kNone;
  has_written_ = false;
  head_bytes_ = 0;
  deadline_ = clock_.Now() + limits_.head_timeout;
}

void HttpStream::BeginBody() {
  phase_ = Phase::kBody;
  deadline_ = clock_.Now() + limits_.body_timeout;
}

void HttpStream::BeginPart() {
  phase_ = Phase::kResponse;
  deadline_ = clock_.Now() + limits_.write_timeout;
}

void HttpStream::Linger(std::chrono::milliseconds patience) {
  if (ssl_ != nullptr) SSL_shutdown(ssl_.get());
  shutdown(fd_, SHUT_WR);
  deadline_ = clock_.Now() + patience;
  for (;;) {
    const ssize_t received = recv(fd_, buffer_.data(), buffer_.size(), 0);
    if (received > 0) {
      if (clock_.Now() >= deadline_) return;
    } else if (received == 0 || (errno != EAGAIN && errno != EINTR) ||
               !Wait(POLLIN)) {
      return;
    }
  }
}

ssize_t HttpStream::read(char* ptr, size_t size) {
  if (failure_ != StreamFailure::kNone) return -1;
  if (phase_ == Phase::kHead) {
    size = std::min(size, limits_.head_bytes - head_bytes_);
    if (size == 0) {
      failure_ = StreamFailure::kHeadTooLarge;
      return -1;
    }
  }
  ssize_t got = 0;
  if (begin_ == end_ && size >= buffer_.size()) {
    got = Receive(ptr, size);
  } else {
    if (begin_ == end_) {
      const ssize_t received = Receive(buffer_.data(), buffer_.size());
      if (received <= 0) return received;
      begin_ = 0;
      end_ = static_cast<size_t>(received);
    }
    const size_t taken = std::min(size, end_ - begin_);
    std::memcpy(ptr, buffer_.data() + begin_, taken);
    begin_ += taken;
    got = static_cast<ssize_t>(taken);
  }
  if (phase_ == Phase::kHead && got > 0) {
    head_bytes_ += static_cast<size_t>(got);
  }
  return got;
}

ssize_t HttpStream::write(const char* ptr, size_t size) {
  if (failure_ == StreamFailure::kClosed) return -1;
  if (phase_ != Phase::kResponse) {
    phase_ = Phase::kResponse;
    deadline_ = clock_.Now() + limits_.write_timeout;
  }
  size_t sent = 0;
  while (sent < size) {
    const ssize_t result = Send(ptr + sent, size - sent);
    if (result <= 0) return -1;
    sent += static_cast<size_t>(result);
    has_written_ = true;
  }
  return static_cast<ssize_t>(sent);
}

void HttpStream::get_remote_ip_and_port(std::string& ip, int& port) const {
  IpAndPort(fd_, &getpeername, ip, port);
}

void HttpStream::get_local_ip_and_port(std::string& ip, int& port) const {
  IpAndPort(fd_, &getsockname, ip, port);
}

ssize_t HttpStream::Receive(char* ptr, size_t size) {
  for (;;) {
    // Also where bytes keep coming: a steady trickle never has to wait.
    if (clock_.Now() >= deadline_) {
      failure_ = StreamFailure::kTimedOut;
      return -1;
    }
    if (ssl_ != nullptr) {
      ERR_clear_error();
      const int result = SSL_read(
          ssl_.get(), ptr, static_cast<int>(std::min<size_t>(size, INT_MAX)));
      if (result > 0) return result;
      if (!WaitForTls(result)) return -1;
      continue;
    }
    const ssize_t result = recv(fd_, ptr, size, 0);
    if (result > 0) return result;
    if (result < 0 && errno == EINTR) continue;
    if (result == 0 || errno != EAGAIN) {
      failure_ = StreamFailure::kClosed;
      return result;
    }
    if (!Wait(POLLIN)) return -1;
  }
}

ssize_t HttpStream::Send(const char* ptr, size_t size) {
  for (;;) {
    if (ssl_ != nullptr) {
      ERR_clear_error();
      const int result = SSL_write(
          ssl_.get(), ptr, static_cast<int>(std::min<size_t>(size, INT_MAX)));
      if (result > 0) return result;
      if (!WaitForTls(result)) return -1;
      continue;
    }
    const ssize_t result = send(fd_, ptr, size, MSG_NOSIGNAL);
    if (result >= 0) return result;
    if (errno == EINTR) continue;
    if (errno != EAGAIN || !Wait(POLLOUT)) return -1;
  }
}

bool HttpStream::Wait(short events) {
  for (;;) {
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(deadline_ - clock_.Now());
    if (left.count() <= 0) {
      failure_ = StreamFailure::kTimedOut;
      return false;
    }
    pollfd polled{.fd = fd_, .events = events, .revents = 0};
    const int result = poll(
        &polled, 1, static_cast<int>(std::min<int64_t>(left.count(), INT_MAX)));
    if (result > 0) return true;
    if (result < 0 && errno != EINTR) return false;
  }
}

bool HttpStream::WaitForTls(int result) {
  switch (SSL_get_error(ssl_.get(), result)) {
    case SSL_ERROR_WANT_READ:
      return Wait(POLLIN);
    case SSL_ERROR_WANT_WRITE:
      return Wait(POLLOUT);
    default:
      failure_ = StreamFailure::kClosed;
      return false;
  }
}

}  // namespace treeline::http
